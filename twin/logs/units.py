"""The units a column map may name, and the factor that takes each to SI."""

from __future__ import annotations

import math

UNITS: dict[str, dict[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0},
    "angle": {"rad": 1.0, "deg": math.pi / 180.0},
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "speed": {"m/s": 1.0, "km/h": 1.0 / 3.6, "mph": 0.44704, "kn": 1852.0 / 3600.0},
    "acceleration": {"m/s2": 1.0, "g": 9.80665},
    "angular rate": {"rad/s": 1.0, "deg/s": math.pi / 180.0, "rpm": math.pi / 30.0},
    "force": {"N": 1.0, "kN": 1e3},
    "torque": {"Nm": 1.0, "kNm": 1e3},
    "ratio": {"1": 1.0, "%": 1e-2},
    "count": {"1": 1.0},
    "fuel rate": {"L/h": 1.0},
}
"""Dimension -> unit -> factor to SI (litres per hour stay as they are). Exact by definition:
knot and mile per hour by the international nautical and statute mile, g by CGPM 1901."""
