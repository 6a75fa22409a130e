"""The contract between sensors and estimators: named columns of samples, and a set-up. numpy only.

Units: SI and radians. Frames: world is east, north, up; body is x forward, y left, z up with its
origin at the rear-axle centre; headings are counter-clockwise from east.
Times are int64 nanoseconds: `epoch_ns` is the instant a sample describes, `arrival_ns` when it
reaches the estimator.
A sensor, or a column of it, may be absent; a NaN is a value that was not measured. The arrays of
`Streams` are read-only, because every estimator is handed the same ones: work on a `.copy()`.

One module: of the twin, an estimator may import only this one and `twin.compute.compiled`.
"""

from __future__ import annotations

import dataclasses
import json
from collections import ChainMap
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput

Array = NDArray[Any]
"""One column: numbers or text of any type."""

Table = dict[str, Array]
"""One sensor's samples: column name -> array of shape (n,), in order of arrival."""

Frames = Mapping[int, NDArray[np.uint8]]
"""Frames of a camera by number: grey of shape (height, width), or colour (height, width, 3)."""

WHEELS = ("fl", "fr", "rl", "rr")
"""Front left, front right, rear left, rear right."""

STAMPS = ("epoch_ns", "arrival_ns")

FEW = 16
"""Samples that are faster sorted one by one, as in a control step of an environment."""

Value = bool | int | float | str | tuple[float, ...]
"""A value of a data sheet."""

Block = TypeVar("Block")

COLUMNS: dict[str, tuple[str, ...]] = {
    "gnss": (
        "east_m", "north_m", "up_m", "v_east_mps", "v_north_mps", "v_up_mps", "heading_rad",
        "quality", "satellites_main", "satellites_aux",
        "position_sd_m", "velocity_sd_mps", "heading_sd_rad",
    ),
    "imu": (
        "gyro_x_radps", "gyro_y_radps", "gyro_z_radps",
        "accel_x_mps2", "accel_y_mps2", "accel_z_mps2",
    ),
    "wheels": (
        *(f"ticks_{w}" for w in WHEELS),
        *(f"speed_{w}_mps" for w in WHEELS),
        "speed_sd_mps",
        *(f"accel_{w}_mps2" for w in WHEELS),
    ),
    "depth": ("laser_m", "inclination_rad"),
    "machine": (
        "steer_rad", "hitch_m", "draft_pin_n", "axle_torque_nm",
        "engine_radps", "engine_load", "engine_torque", "fuel_lph",
    ),
    "camera": (
        "frame", "interval_s", "v_x_mps", "v_y_mps", "var_x_m2ps2", "var_y_m2ps2", "cov_xy_m2ps2",
        "yaw_rad", "scale", "tilt_ahead_rad", "tilt_left_rad", "quality", "used", "reason",
    ),
}  # fmt: skip
"""Columns each sensor may have beside its stamps.

`quality` is NMEA GGA's (4 fixed, 5 float, 1 single, 0 none); `ticks_*` are cumulative int64;
`speed_*_mps` are the theoretical speed w R of a source that gives no ticks (a single wheel-based
vehicle speed is in both driven wheels' columns); `frame` is the number of a camera's frame,
int64, under which `Streams.frames` has it. A camera with odometry on board gives no frames. Its
columns are the velocity of its optical centre, forward and left in the ground plane, over the
`interval_s` about the epoch, its covariance, `yaw_rad` by which the camera turned, `scale` by which
its height grew, and how far the ground's normal leans forward and left in the camera's axes. They
are NaN where a frame was not `used`, for a `reason` (`estimators.odometry.lens.Reason`), and
contain the yaw and tilt of its mounting. Samples that arrive at the same instant are processed in
the order of the sensors here.
"""

ESTIMATES = (
    "epoch_ns", "speed_mps", "wheel_speed_mps", "slip", "slip_sd", "slip_rl", "slip_rr",
    "sideslip_rad", "sideslip_sd_rad", "v_y_mps", "sideslip_m", "sideslip_sd_m",
    "sideslip_rear_rad", "sideslip_rear_m", "flags",
)  # fmt: skip
"""Columns of an estimate. Speeds are at the rear-axle centre; `v_y_mps` and `sideslip_*` without
`rear` are at the tractor's centre of gravity. An estimator gives `epoch_ns` and the columns it
knows."""


@dataclass(frozen=True, kw_only=True)
class GnssSetup:
    """What the data sheet and the tape measure say of the GNSS receiver."""

    rate_hz: float
    lever_arm_m: tuple[float, float, float]
    """Main antenna, body axes, from the rear-axle centre."""
    position_sd_m: float
    velocity_sd_mps: float
    heading_sd_rad: float
    heading_mount_rad: float = 0.0
    """Angle from body x to the antenna baseline."""


@dataclass(frozen=True, kw_only=True)
class ImuSetup:
    """What the data sheet and the tape measure say of the IMU; its axes are body axes."""

    rate_hz: float
    lever_arm_m: tuple[float, float, float]
    """Unit, body axes, from the rear-axle centre."""
    gyro_noise_radps_rthz: float
    accel_noise_mps2_rthz: float
    gyro_bias_sd_radps: float
    accel_bias_sd_mps2: float
    gravity: bool = True
    """Whether gravity is in the accelerations, as an accelerometer has it; False where the unit, or
    who made the log, took it out."""


ZERO_SLIPS = {
    "law": "the soil law's own slip",
    "hard-torque": "no torque on a hard surface",
    "hard-pull": "no pull on a hard surface",
    "field-torque": "no torque on the field",
    "field-pull": "no pull on the field",
    "unknown": "not stated",
}
"""Where slip is zero: the soil law's own zero, or a zero condition of ASABE S296."""


@dataclass(frozen=True, kw_only=True)
class WheelsSetup:
    """Encoders: counts per turn after decoding, and the nominal rolling radius of each wheel."""

    rate_hz: float
    radius_m: Mapping[str, float]
    """Nominal rolling radius by wheel; what the manual says, not what is true today."""
    counts_per_turn: int | None = None
    """None for a source that gives speeds."""
    zero_slip: str = "unknown"
    """Where slip by these radii is zero, one of ZERO_SLIPS."""
    radius_sd: float = 0.01
    """sd of an axle's true radius about the nominal, over it: wear and pressure of the tyres."""


@dataclass(frozen=True, kw_only=True)
class DepthSetup:
    """Laser range finder on the plough beam; depth = zero_m - laser_m cos(inclination)."""

    rate_hz: float
    zero_m: float
    laser_sd_m: float


@dataclass(frozen=True, kw_only=True)
class CameraSetup:
    """A camera that looks straight down, nominally; forward is at the top of the picture."""

    rate_hz: float
    width_px: int
    height_px: int
    focal_px: float
    """Focal length; the principal point is the middle of the picture."""
    lever_arm_m: tuple[float, float, float]
    """Optical centre, body axes, from the rear-axle centre."""
    height_m: float
    """Optical centre above level ground, the machine at rest."""


@dataclass(frozen=True, kw_only=True)
class OwnSetup:
    """Set-up of your own sensor, and the columns of its stream."""

    columns: Mapping[str, tuple[str, str]]
    """Column -> its unit and its meaning."""
    values: Mapping[str, Value] = field(default_factory=dict)
    """Data sheet and tape measure."""

    def __getitem__(self, name: str) -> Value:
        return self.values[name]


@dataclass(frozen=True, kw_only=True)
class Setup:
    """All that an estimator gets beside the streams: nominal values only, never true ones."""

    machine: str
    wheelbase_m: float
    track_front_m: float
    track_rear_m: float
    cg_x_m: float
    """Centre of gravity of the machine without implement, ahead of the rear axle."""
    driven: tuple[str, ...] = ("rl", "rr")
    origin: tuple[float, float, float] | None = None
    """Geodetic origin of east, north, up: latitude [deg], longitude [deg], height [m]."""
    wheels: WheelsSetup | None = None
    gnss: GnssSetup | None = None
    imu: ImuSetup | None = None
    depth: DepthSetup | None = None
    camera: CameraSetup | None = None
    extra: Mapping[str, OwnSetup] = field(default_factory=dict)
    """Your own sensors, by stream."""

    def to_json(self) -> str:
        """The set-up as JSON text."""
        return json.dumps(dataclasses.asdict(self), indent=2)

    @classmethod
    def from_json(cls, text: str) -> Setup:
        """The set-up from JSON text. Raises BadInput if it is not one."""
        try:
            raw = dict(json.loads(text))
            for name, kind in BLOCKS.items():
                if raw.get(name) is not None:
                    raw[name] = _block(kind, raw[name])
            own = dict(raw.get("extra") or {})
            raw["extra"] = {stream: own_setup(block) for stream, block in own.items()}
            return _block(cls, raw)
        except (TypeError, ValueError, AttributeError) as error:
            raise BadInput(f"setup.json is not a set-up: {error}") from None


BLOCKS: dict[str, type] = {
    "wheels": WheelsSetup,
    "gnss": GnssSetup,
    "imu": ImuSetup,
    "depth": DepthSetup,
    "camera": CameraSetup,
}
"""Kind of each sensor's block of a set-up."""


def own_setup(raw: Mapping[str, Mapping[str, object]]) -> OwnSetup:
    """The set-up of your own sensor from plain values. Raises TypeError if it is not one."""
    known = {name: dict(block) for name, block in raw.items()}
    return _block(OwnSetup, {name: _tuples(block) for name, block in known.items()})


def _block(kind: type[Block], raw: Mapping[str, object]) -> Block:
    return kind(**_tuples(raw))


def _tuples(block: Mapping[str, object]) -> dict[str, object]:
    return {k: tuple(v) if isinstance(v, list) else v for k, v in block.items()}


def read_only(array: Array) -> Array:
    """The same values, which cannot be written to through this view."""
    array = np.asarray(array)  # what a user's scenario gives may be a list
    if not array.flags.writeable:
        return array
    view = array.view()
    view.flags.writeable = False
    return view


@dataclass(frozen=True)
class Streams:
    """The samples of all sensors of a run, or of a part of it; their arrays are read-only."""

    tables: Mapping[str, Table] = field(default_factory=dict)
    frames: Frames | None = None
    """The camera's frames by number, read or drawn when asked for; a lost one is missing."""

    def __post_init__(self) -> None:
        tables = {n: {c: read_only(v) for c, v in t.items()} for n, t in self.tables.items()}
        object.__setattr__(self, "tables", tables)
        kept = self.frames
        if isinstance(kept, dict) and any(f.flags.writeable for f in kept.values()):
            object.__setattr__(self, "frames", {n: read_only(f) for n, f in kept.items()})

    def __contains__(self, sensor: object) -> bool:
        return sensor in self.tables

    def __getitem__(self, sensor: str) -> Table:
        return self.tables[sensor]

    def __len__(self) -> int:
        """Number of samples of all sensors."""
        return sum(len(t["epoch_ns"]) for t in self.tables.values())

    def only(self, sensors: Iterable[str]) -> Streams:
        """The samples of those of the sensors that there are, without frames."""
        part = object.__new__(Streams)  # its arrays are read-only already
        chosen = {s: self.tables[s] for s in sensors if s in self.tables}
        object.__setattr__(part, "tables", chosen)
        object.__setattr__(part, "frames", None)
        return part

    def column(self, sensor: str, name: str) -> Array:
        """A column, or NaN where the sensor has none. Shape (n,), (0,) without the sensor."""
        table = self.tables.get(sensor)
        if table is None:
            return np.empty(0)
        return table.get(name, np.full(len(table["epoch_ns"]), np.nan))

    def merge_order(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Order in which an estimator sees the samples: by arrival, then by sensor, then by row.

        Returns:
            sensor: index of each sample's sensor into COLUMNS, and from len(COLUMNS) on the
                your own sensors in alphabetical order, shape (n,).
            row: its row in that sensor's table, shape (n,).
        """
        present = self._numbered()
        counts = [len(self.tables[s]["arrival_ns"]) for _, s in present]
        if sum(counts) <= FEW:
            arrived = [
                (ns, i, row)
                for i, s in present
                for row, ns in enumerate(self.tables[s]["arrival_ns"].tolist())
            ]
            numbers = np.array([x[1:] for x in sorted(arrived)], np.int64).reshape(-1, 2)
            return numbers[:, 0].copy(), numbers[:, 1].copy()
        arrival = np.concatenate([self.tables[s]["arrival_ns"] for _, s in present])
        sensor = np.repeat([i for i, _ in present], counts)
        row = np.concatenate([np.arange(n) for n in counts])
        order = np.lexsort((row, sensor, arrival))
        return sensor[order], row[order]

    def samples(self, start: int, stop: int) -> Streams:
        """The samples from number `start` up to `stop` in merge order."""
        sensor, row = self.merge_order()
        chosen: dict[str, Table] = {}
        for i, name in self._numbered():
            rows = row[start:stop][sensor[start:stop] == i]
            chosen[name] = {k: v[rows] for k, v in self.tables[name].items()}
        return Streams(chosen, self.frames)

    def _numbered(self) -> list[tuple[int, str]]:
        """The sensors that there are, numbered as `merge_order` does."""
        own = sorted(self.tables.keys() - COLUMNS.keys())
        return [(i, s) for i, s in enumerate((*COLUMNS, *own)) if s in self.tables]

    def chunks(self, size: int) -> Iterator[Streams]:
        """The samples in merge order, `size` at a time."""
        for start in range(0, len(self), size):
            yield self.samples(start, start + size)


def concatenate(parts: Iterable[Streams]) -> Streams:
    """One stream from consecutive parts."""
    tables: dict[str, list[Table]] = {}
    frames: list[Frames] = []
    for part in parts:
        for name, table in part.tables.items():
            tables.setdefault(name, []).append(table)
        if part.frames is not None and not any(part.frames is known for known in frames):
            frames.append(part.frames)
    joined = {
        name: {c: np.concatenate([t[c] for t in pieces]) for c in pieces[0]}
        for name, pieces in tables.items()
    }
    return Streams(joined, _chained(frames))


def _chained(frames: list[Frames]) -> Frames | None:
    if len(frames) < 2:
        return frames[0] if frames else None
    return ChainMap(*frames)  # type: ignore[arg-type]  # only read


def check(streams: Streams, extra: Mapping[str, OwnSetup] | None = None) -> None:
    """Raise BadInput unless the tables obey the contract.

    Known names (of `COLUMNS`, or of the set-up's `extra`), equal lengths, arrivals in order.
    """
    known = COLUMNS | {stream: tuple(block.columns) for stream, block in (extra or {}).items()}
    for name, table in streams.tables.items():
        if name not in known:
            raise BadInput(f"stream '{name}' is not one of {', '.join(known)}")
        for column in table:
            if column not in (*STAMPS, *known[name]):
                raise BadInput(f"stream '{name}' has an unknown column '{column}'")
        for stamp in STAMPS:
            if stamp not in table:
                raise BadInput(f"stream '{name}' has no column '{stamp}'")
            if table[stamp].dtype != np.int64:
                raise BadInput(f"{name}.{stamp} is {table[stamp].dtype}, not int64 nanoseconds")
        lengths = {len(v) for v in table.values()}
        if len(lengths) > 1:
            raise BadInput(f"stream '{name}' has columns of different lengths {sorted(lengths)}")
        if np.any(np.diff(table["arrival_ns"]) < 0):
            row = int(np.argmax(np.diff(table["arrival_ns"]) < 0)) + 1
            raise BadInput(f"stream '{name}' arrives out of order at row {row}")
