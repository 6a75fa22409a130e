"""The units a column map may name, and the factor that takes each to SI."""

from __future__ import annotations

import math

UNITS: dict[str, dict[str, float]] = {
    "time": {
        "s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0, "days": 86400.0,
    },
    "angle": {"rad": 1.0, "deg": math.pi / 180.0, "mrad": 1e-3, "gon": math.pi / 200.0},
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254, "ft": 0.3048},
    "speed": {
        "m/s": 1.0, "km/h": 1.0 / 3.6, "mph": 0.44704, "kn": 1852.0 / 3600.0, "mm/s": 1e-3,
        "cm/s": 1e-2,
    },
    "acceleration": {"m/s2": 1.0, "g": 9.80665, "mg": 9.80665e-3},
    "angular rate": {
        "rad/s": 1.0, "deg/s": math.pi / 180.0, "rpm": math.pi / 30.0, "mrad/s": 1e-3,
        "deg/h": math.pi / 648000.0,
    },
    "force": {"N": 1.0, "kN": 1e3, "daN": 10.0, "kgf": 9.80665, "lbf": 4.4482216152605},
    "torque": {"Nm": 1.0, "kNm": 1e3},
    "ratio": {"1": 1.0, "%": 1e-2},
    "count": {"1": 1.0, "counts": 1.0},
    "fuel rate": {"L/h": 1.0, "mL/s": 3.6, "mL/min": 0.06, "gal/h": 3.785411784},
}  # fmt: skip
"""Dimension -> unit -> factor to SI (litres per hour stay L/h). Exact by definition:
knot and mile per hour by the international nautical and statute mile, g by CGPM 1901, the pound by
the international yard and pound agreement of 1959, the gallon of the United States."""
WHEEL_RATES = UNITS["angular rate"]
"""Units in which a wheel's speed may also stand, with its radius in the set-up."""
