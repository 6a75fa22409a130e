"""Values that mean no value: codes of buses and receivers, and texts of tables.

SAE J1939-71 and ISO 11783-7: a parameter of n bytes whose highest byte is 0xFF is not available,
0xFE an error; NMEA 2000 likewise; ITU-R M.1371 has latitude 91 and longitude 181.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from twin.logs.quantities import Quantity
from twin.streams import Array

KMH = 3.6
RPM = 30.0 / math.pi
_SPEED_MPS = ((254.0 / KMH, 256.0 / KMH), (65.02, 65.54), (650.2, 655.36))
"""0xFE00 to 0xFFFF at 1/256 km/h (CCVS1, VDS), 1 mm/s (ISO 11783-7) and 1 cm/s (NMEA 2000)."""
_BY_COLUMN: dict[str, tuple[tuple[float, float], ...]] = {
    "engine_radps": ((8128.0 / RPM, 8192.0 / RPM),),
    "engine_load": ((2.54, 2.55),),
    "fuel_lph": ((3251.2, 3276.75),),
    "latitude_rad": tuple((math.radians(d), math.radians(d)) for d in (91.0, 214.7483647)),
    "longitude_rad": tuple(
        (math.radians(d), math.radians(d)) for d in (181.0, 214.7483647, 219.4967295)
    ),
}
_FILLERS = np.array([
    *(s * float(f"{digits}{tail}") for digits in ("999", "9999", "99999", "999999", "9999999")
      for tail in ("", ".9", ".99", ".999") for s in (1, -1)),
    254.0, 255.0, 32767.0, -32768.0, 65534.0, 65535.0, 2147483647.0, -2147483648.0, 4294967295.0,
])  # fmt: skip
"""What programs write for no value, where it is beyond what the quantity can be."""


def stands_for_none(
    key: str, quantity: Quantity, raw: Array, si: Array, *, compass: bool
) -> NDArray[np.bool_]:
    """Which values are codes, not measurements. raw in the log's own numbers, si in SI."""
    holes = np.zeros(len(si), bool)
    with np.errstate(invalid="ignore"):
        speed = quantity.dimension == "speed"
        ranges = _SPEED_MPS if speed else _BY_COLUMN.get(quantity.column, ())
        for low, high in ranges:
            holes |= (np.abs(si) >= low * (1 - 1e-6)) & (np.abs(si) <= high * (1 + 1e-6))
        if compass:
            holes |= np.abs(si) >= 2.0 * math.pi * (1 - 1e-12)  # no bearing is a turn or more
        if speed and not key.startswith("v_"):
            negative = raw < 0
            holes |= negative & np.all(raw[negative] == -1.0)
        odd = (si < quantity.low) | (si > quantity.high)
        if speed:
            odd |= np.abs(si) * KMH > 100.0
        if odd.any():
            near = np.abs(raw[odd][:, None] - _FILLERS) <= 1e-9 * np.abs(_FILLERS)
            holes[odd] |= near.any(axis=1)
    return holes


def given_as_missing(raw: Array, codes: tuple[float, ...]) -> NDArray[np.bool_]:
    """Which values are those that a map calls missing, as exact as a table prints them."""
    holes = np.zeros(len(raw), bool)
    for code in codes:
        holes |= np.isclose(raw, code, rtol=5e-6, atol=1e-12)
    return holes
