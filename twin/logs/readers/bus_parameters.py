"""What is in the frames of a tractor's bus, by name, without a DBC.

SAE J1939-71 (EEC1, EEC2, CCVS1, LFE1, EBC2, VDS, VDC2), ISO 11783-7 (wheel- and ground-based speed,
rear hitch, PTO) and NMEA 2000 (positions, course and speed, heading, rate of turn). Fields are
little-endian; bytes count from 1 as the standards count them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FAST_PACKET = frozenset({129029})
"""Parameter groups that come in several frames (NMEA 2000)."""


@dataclass(frozen=True)
class Parameter:
    """One field of a parameter group: value = raw x scale + offset, in its unit."""

    pgn: int
    name: str
    byte: int
    """Its first."""
    size: int
    """In bytes."""
    scale: float
    offset: float
    unit: str
    key: str = ""
    """Section and key of a column map that it is, if it is one."""
    signed: bool = False
    marine: bool = False
    """Of NMEA 2000, where only the two highest values are none."""

    @property
    def _codes(self) -> int:
        """How many of the highest values are codes: from 0xFB.. on, or two of NMEA 2000."""
        return 2 if self.marine else 5 * 2 ** (8 * (self.size - 1))

    def of(self, data: NDArray[np.uint8]) -> NDArray[np.float64]:
        """Values of frames, NaN where not available or in error. data: (n, bytes)."""
        raw = unsigned(data, self.byte, self.size)
        top = np.uint64(2 ** (8 * self.size - self.signed) - 1)
        codes = np.uint64(self._codes)
        none = raw > top - codes if not self.signed else (raw <= top) & (raw > top - codes)
        if self.signed:
            shift = np.uint64(64 - 8 * self.size)
            number = ((raw << shift).view(np.int64) >> np.int64(shift)).astype(np.float64)
        else:
            number = raw.astype(np.float64)
        return np.where(none, np.nan, number * self.scale + self.offset)

    def coded(self, values: NDArray[np.float64]) -> NDArray[np.uint64]:
        """Raw fields of values; not available where NaN or beyond the field."""
        top = 2 ** (8 * self.size - self.signed) - 1
        none = np.uint64(2 ** (8 * self.size) - 1 if not self.signed else top)
        with np.errstate(invalid="ignore", over="ignore"):
            number = np.round((values - self.offset) / self.scale)
            fits = (number <= top - self._codes) & (number >= (-top if self.signed else 0))
        whole = np.where(fits, number, 0.0).astype(np.int64).view(np.uint64)
        mask = np.uint64(2 ** (8 * self.size) - 1 if self.size < 8 else 2**64 - 1)
        return np.where(fits, whole & mask, none)


def unsigned(data: NDArray[np.uint8], byte: int, size: int) -> NDArray[np.uint64]:
    """A little-endian field of every frame as a number; all ones where a frame is too short."""
    if data.shape[1] < byte - 1 + size:
        return np.full(len(data), 2 ** (8 * size) - 1, np.uint64)
    field = data[:, byte - 1 : byte - 1 + size].astype(np.uint64)
    return np.asarray(
        (field << (8 * np.arange(size, dtype=np.uint64))).sum(axis=1, dtype=np.uint64)
    )


_KMH = 1.0 / 256.0
GROUPS: dict[int, str] = {
    61444: "EEC1", 61443: "EEC2", 65265: "CCVS1", 65266: "LFE1", 65215: "EBC2", 65256: "VDS",
    61449: "VDC2", 65096: "WBSD", 65097: "GBSD", 65093: "rear_hitch", 65091: "rear_PTO",
    65092: "front_PTO", 129025: "position_rapid", 129026: "COG_SOG", 129029: "position",
    127250: "heading", 127251: "rate_of_turn",
}  # fmt: skip
"""Parameter group number -> what signals are called after."""

PARAMETERS: tuple[Parameter, ...] = (
    Parameter(61444, "engine_torque", 3, 1, 1.0, -125.0, "%"),
    Parameter(61444, "engine_speed", 4, 2, 0.125, 0.0, "rpm", "machine.engine_speed"),
    Parameter(61443, "pedal", 2, 1, 0.4, 0.0, "%"),
    Parameter(61443, "engine_load", 3, 1, 1.0, 0.0, "%", "machine.engine_load"),
    Parameter(65266, "fuel_rate", 1, 2, 0.05, 0.0, "L/h", "machine.fuel_rate"),
    Parameter(65096, "speed", 1, 2, 1e-3, 0.0, "m/s", "wheels.driven_speed"),
    Parameter(65096, "distance", 3, 4, 1e-3, 0.0, "m"),
    Parameter(65265, "wheel_speed", 2, 2, _KMH, 0.0, "km/h", "wheels.driven_speed"),
    Parameter(65097, "speed", 1, 2, 1e-3, 0.0, "m/s", "gnss.speed"),
    Parameter(65097, "distance", 3, 4, 1e-3, 0.0, "m"),
    Parameter(65256, "bearing", 1, 2, 1.0 / 128.0, 0.0, "deg", "gnss.course"),
    Parameter(65256, "speed", 3, 2, _KMH, 0.0, "km/h", "gnss.speed"),
    Parameter(65256, "pitch", 5, 2, 1.0 / 128.0, -200.0, "deg"),
    Parameter(65256, "altitude", 7, 2, 0.125, -2500.0, "m", "gnss.height"),
    Parameter(61449, "steering_wheel", 1, 2, 1.0 / 1024.0, -31.374, "rad"),
    Parameter(61449, "yaw_rate", 4, 2, 1.0 / 8192.0, -3.92, "rad/s", "imu.gyro_z"),
    Parameter(61449, "lateral_acceleration", 6, 2, 1.0 / 2048.0, -15.687, "m/s2"),
    Parameter(65093, "position", 1, 1, 0.4, 0.0, "%"),
    Parameter(65093, "draft", 4, 2, 10.0, -320e3, "N", "machine.draft_pin"),
    Parameter(65091, "speed", 1, 2, 0.125, 0.0, "rpm"),
    Parameter(65092, "speed", 1, 2, 0.125, 0.0, "rpm"),
    Parameter(129025, "latitude", 1, 4, 1e-7, 0.0, "deg", "gnss.latitude", True, True),
    Parameter(129025, "longitude", 5, 4, 1e-7, 0.0, "deg", "gnss.longitude", True, True),
    Parameter(129026, "course", 3, 2, 1e-4, 0.0, "rad", "gnss.course", False, True),
    Parameter(129026, "speed", 5, 2, 0.01, 0.0, "m/s", "gnss.speed", False, True),
    Parameter(127250, "heading", 2, 2, 1e-4, 0.0, "rad", "gnss.heading", False, True),
    Parameter(127251, "rate", 2, 4, 3.125e-8, 0.0, "rad/s", "imu.gyro_z", True, True),
    Parameter(129029, "latitude", 8, 8, 1e-16, 0.0, "deg", "gnss.latitude", True, True),
    Parameter(129029, "longitude", 16, 8, 1e-16, 0.0, "deg", "gnss.longitude", True, True),
    Parameter(129029, "height", 24, 8, 1e-6, 0.0, "m", "gnss.height", True, True),
    Parameter(129029, "satellites", 34, 1, 1.0, 0.0, "1", "gnss.satellites", False, True),
)
"""By rank: of two that are the same quantity, that which stands first here counts, but for NMEA
2000's velocity and position, which count before the bus's own."""
RANK = {65265: 1, 65096: 0, 129026: 0, 65256: 1, 65097: 2, 129025: 1, 129029: 0, 127251: 0}
"""Which group counts where several have one quantity: the lowest."""
EBC2_WHEELS = {"fl": (1, 3), "fr": (1, 4), "rl": (1, 5), "rr": (1, 6)}
"""Wheel -> first byte of the front axle's speed and the byte of the wheel's own beside it; in
1/256 km/h, and in 1/16 km/h from -7.8125 km/h."""
RELATIVE = Parameter(65215, "relative", 3, 1, 1.0 / 16.0, -7.8125, "km/h")
AXLE = Parameter(65215, "front_axle", 1, 2, _KMH, 0.0, "km/h")
BACKWARD = {65096: 8, 65097: 8}
"""Group -> byte whose lowest two bits say the direction: 0 backward, 1 forward."""
RIGHT_IS_POSITIVE = frozenset({127251})
"""Groups that turn clockwise, seen from above."""
TURN_RAD = 2.0 * math.pi


def group_of(identifier: NDArray[np.int64]) -> NDArray[np.int64]:
    """Parameter group number of 29-bit identifiers (J1939-21): without the destination."""
    pgn = (identifier >> 8) & 0x3FFFF
    addressed = ((identifier >> 16) & 0xFF) < 240
    return np.where(addressed, pgn & 0x3FF00, pgn)
