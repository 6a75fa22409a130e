"""What the compiled loops pass to each other: records of named numbers.

Structured numpy arrays give compiled code fields by name, and are plain values: they copy and
pickle.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.streams import COLUMNS, Setup, WheelsSetup
from twin.streams import WHEELS as WHEEL_NAMES

GNSS, IMU, WHEELS, CAMERA = (tuple(COLUMNS).index(s) for s in ("gnss", "imu", "wheels", "camera"))
"""Number of each sensor in `Streams.merge_order`."""

GNSS_COLUMNS = (
    "v_east_mps", "v_north_mps", "v_up_mps", "heading_rad", "quality",
    "velocity_sd_mps", "heading_sd_rad",
)  # fmt: skip
IMU_COLUMNS = ("gyro_x_radps", "gyro_y_radps", "gyro_z_radps", "accel_x_mps2", "accel_y_mps2")
CAMERA_COLUMNS = ("v_x_mps", "var_x_m2ps2", "used")
WHEEL_COLUMNS = (
    *(f"ticks_{w}" for w in WHEEL_NAMES),
    *(f"speed_{w}_mps" for w in WHEEL_NAMES),
    *(f"accel_{w}_mps2" for w in WHEEL_NAMES),
    "speed_sd_mps",
)

OUT_OF_ORDER = 1
"""Flag: a sample was no newer than its sensor's last one, and was left out."""
NO_GROUND_SPEED = 2
"""Flag: the ground speed is unknown, or older than `STALE_S`."""
RESTARTED = 4
"""Flag: the filter started again after a gap longer than `STALE_S`."""
REPEATED = 256
"""Flag: the receiver gave its last velocity and heading again, to the bit: it may hang."""

STALE_S = 5.0
"""A measurement older than this says nothing; between a 1 Hz log's samples and a field's gaps."""
SILENT_S = 2.0
"""After so long without a sample of any sensor the unit may have been off: its turn-on bias is new
[s]."""
GRAVITY_MPS2 = 9.81
FIXED = 4.0
"""Quality of a fixed position of GNSS; others err by decimetres for a minute."""
HISTORY = 64
"""IMU samples remembered, 1.3 s at 50 Hz, so that a late GNSS sample meets the turning of its own
epoch."""

NOMINAL = np.dtype(
    [
        ("radius_m", "f8", 4),
        ("counts_per_turn", "f8"),
        ("driven", "f8", 4),
        ("wheelbase_m", "f8"),
        ("track_front_m", "f8"),
        ("track_rear_m", "f8"),
        ("cg_x_m", "f8"),
        ("radius_sd", "f8"),
        ("antenna_m", "f8", 3),
        ("velocity_sd_mps", "f8"),
        ("heading_sd_rad", "f8"),
        ("heading_mount_rad", "f8"),
        ("imu_m", "f8", 3),
        ("accel_sd_mps2", "f8"),
        ("accel_bias_sd_mps2", "f8"),
        ("gyro_bias_sd_radps", "f8"),
        ("gravity", "f8"),
        ("camera_y_m", "f8"),
    ],
    align=True,
)
"""The set-up as numbers. `driven` is 1 for a driven wheel; `accel_sd_mps2` is of one sample,
`gravity` 1 where it leaks into the accelerations as the body pitches."""

SIGNALS = np.dtype(
    [
        ("sensor", "i8"),
        ("epoch_ns", "i8"),
        ("flags", "i8"),
        ("v_x_mps", "f8"),
        ("v_sd_mps", "f8"),
        ("horizontal_mps", "f8"),
        ("accel_mps2", "f8"),
        ("accel_x_mps2", "f8"),
        ("gyro_y_radps", "f8"),
        ("wheel_mps", "f8", 4),
        ("wheel_sd_mps", "f8", 4),
        ("wheel_age_s", "f8", 4),
        ("wheel_accel_mps2", "f8", 4),
        ("one_driven_speed", "i8"),
        ("one_towed_speed", "i8"),
        ("yaw_rate_radps", "f8"),
        ("pitch_rate_radps", "f8"),
        ("v_y_held_mps", "f8"),
        ("v_y_held_sd_mps", "f8"),
        ("sideslip_m", "f8"),
        ("sideslip_rear_m", "f8"),
        ("sideslip_sd_m", "f8"),
    ],
    align=True,
)
"""One sample as speeds, at the rear-axle centre, along (x) and across (y) the body in the ground
plane. GNSS and camera samples have `v_x`, `v_sd`; GNSS samples have `horizontal`, the antenna's
speed; IMU samples have `accel` and, as measured, `accel_x` and `gyro_y`; wheel samples have
`wheel_*`; all else is NaN. `wheel_age_s`: the speed is that of
this much before the epoch. `one_*_speed`: those wheels' speeds are one and the same number. The
rest is held from the last sample that had it."""

MEMORY = np.dtype(
    [
        ("epoch_ns", "i8", len(COLUMNS)),
        ("tick_ns", "i8", 4),
        ("tick", "f8", 4),
        ("tick_step_s", "f8", 4),
        ("direction", "f8"),
        ("imu_samples", "i8"),
        ("gyro_s", "f8"),
        ("gyro_mean_radps", "f8", 2),
        ("yaw_rate_radps", "f8"),
        ("yaw_rad", "f8"),
        ("pitch_rad", "f8"),
        ("accel_y_mps2", "f8"),
        ("history_ns", "i8", HISTORY),
        ("history", "f8", (HISTORY, 4)),
        ("heading_ns", "i8"),
        ("heading_offset_rad", "f8"),
        ("gnss_samples", "i8"),
        ("gnss", "f8", 4),
        ("grade", "f8"),
        ("v_ns", "i8"),
        ("v_x_mps", "f8"),
        ("v_y_mps", "f8"),
        ("v_y_sd_mps", "f8"),
        ("v_y_cg_mps", "f8"),
        ("sideslip_m", "f8"),
        ("sideslip_rear_m", "f8"),
        ("sideslip_var_m2", "f8"),
    ],
    align=True,
)
"""What is carried from sample to sample."""

_AT_START = {"direction": 1.0, "wheel_age_s": 0.0}
_UNKNOWN = frozenset({"tick", "v_x_mps", "v_y_mps", "v_y_sd_mps", "v_y_cg_mps"})


def blank(layout: np.dtype[Any], n: int) -> NDArray[Any]:
    """Records before anything is known: epochs -1, signals NaN, the rest of a memory 0."""
    return np.full(n, _blank(layout)[0], layout)


@cache
def _blank(layout: np.dtype[Any]) -> NDArray[Any]:
    """One of them."""
    records = np.zeros(1, layout)
    for name in layout.names or ():
        if name.endswith("_ns"):
            records[name] = -1
        elif name in _AT_START:
            records[name] = _AT_START[name]
        elif layout[name].base.kind == "f" and (layout is SIGNALS or name in _UNKNOWN):
            records[name] = np.nan
    return records


def nominal(setup: Setup) -> tuple[Any, ...]:
    """The set-up as one record of NOMINAL; NaN or 0 for what it does not say."""
    wheels, gnss, imu = setup.wheels, setup.gnss, setup.imu
    radius = wheels.radius_m if wheels else {}
    accel_sd = imu.accel_noise_mps2_rthz * np.sqrt(imu.rate_hz) if imu else np.nan
    return (
        [radius.get(w, np.nan) for w in WHEEL_NAMES],
        wheels.counts_per_turn if wheels and wheels.counts_per_turn else np.nan,
        [float(w in setup.driven) for w in WHEEL_NAMES],
        setup.wheelbase_m,
        setup.track_front_m,
        setup.track_rear_m,
        setup.cg_x_m,
        wheels.radius_sd if wheels else WheelsSetup.radius_sd,
        gnss.lever_arm_m if gnss else (0.0, 0.0, 0.0),
        gnss.velocity_sd_mps if gnss else 0.05,
        gnss.heading_sd_rad if gnss else 0.0,
        gnss.heading_mount_rad if gnss else 0.0,
        imu.lever_arm_m if imu else (0.0, 0.0, 0.0),
        accel_sd,
        imu.accel_bias_sd_mps2 if imu else 0.0,
        imu.gyro_bias_sd_radps if imu else 0.0,
        float(imu.gravity) if imu else 1.0,
        setup.camera.lever_arm_m[1] if setup.camera else 0.0,
    )
