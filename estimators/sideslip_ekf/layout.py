"""The state of the filter by name, what it is told, and what it carries from sample to sample."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.innovations import NOTES
from twin.streams import COLUMNS, Setup

V_X, V_Y = range(2)
"""Velocity of the rear-axle centre in the ground plane, ahead and to the left [m/s]."""
HEADING, ROLL, PITCH = range(2, 5)
"""The body's yaw, roll and pitch (nose down), in that order, from east, north, up [rad]."""
EAST, NORTH = range(5, 7)
"""Place of the rear-axle centre [m]."""
BIAS_P, BIAS_Q, BIAS_R, GYRO_SCALE = range(7, 11)
"""Errors of the gyros: biases about x, y and z [rad/s], and the third one's scale."""
BIAS_X, BIAS_Y = range(11, 13)
"""Biases of the accelerometers, ahead and to the left [m/s2]."""
MISALIGNED, RECEIVER_E, RECEIVER_N = range(13, 16)
"""Angle by which the antennas stand askew [rad], error of fixed positions that lasts [m]."""
COMPLIANCE, PUSH = range(16, 18)
"""Slide of the rear tyres per force across [rad s2/m], slide that an implement makes [rad]."""
CAMERA_YAW, CAMERA_PITCH, CAMERA_SCALE, CAMERA_PULL = range(18, 22)
"""Of the camera: how it is turned and nosed up [rad], error of its height, and of the pixels'
lateral speed [m/s]."""
SLIDE, SLIDE_REAR, ASIDE = range(22, 25)
"""Integrals of the lateral speed: of the centre of gravity, of the rear axle, and of the camera
since its last frame [m]."""
SIZE = 25
ENTRIES = 54
"""Places in F - I that are not zero, at most."""

SENSORS = tuple(COLUMNS)
GNSS, IMU, WHEELS, CAMERA = (SENSORS.index(s) for s in ("gnss", "imu", "wheels", "camera"))
FRAME = len(SENSORS)
"""A camera's sample is two: CAMERA at the middle of its interval, FRAME at its end."""
READ = {
    "gnss": (
        "v_east_mps", "v_north_mps", "v_up_mps", "heading_rad", "quality", "velocity_sd_mps",
        "heading_sd_rad", "east_m", "north_m", "position_sd_m",
    ),
    "imu": ("gyro_x_radps", "gyro_y_radps", "gyro_z_radps", "accel_x_mps2", "accel_y_mps2"),
    "camera": (
        "v_x_mps", "v_y_mps", "var_x_m2ps2", "var_y_m2ps2", "cov_xy_m2ps2", "interval_s", "used",
        "tilt_ahead_rad", "tilt_left_rad",
    ),
}  # fmt: skip
"""The columns that are taken, in the order in which they stand in a sample."""
P_RATE, Q_RATE, R_RATE, F_X, F_Y = range(5)
"""Where they stand in one of the IMU's."""
VALUES = 10

SAMPLE = np.dtype(
    [("epoch_ns", "i8"), ("sensor", "i8"), ("values", "f8", VALUES)], align=True
)  # fmt: skip
"""One sample that waits; of the wheels, ground speed, its sd and slip as the slip filter has
them."""
ROOM = 160
"""Samples that can wait: twice what IMU and wheels at 200 Hz bring in the time."""
SECTORS = 8
"""Directions of heading that are told apart."""
FIRST_LAG_NS = 60_000_000
"""How late samples are taken to come before any is seen to be later [ns]."""

MEMORY = np.dtype(
    [
        ("x", "f8", SIZE), ("p", "f8", (SIZE, SIZE)),
        ("epoch_ns", "i8"), ("newest_ns", "i8"), ("last_ns", "i8", len(SENSORS)),
        ("known", "i8"), ("placed", "i8"), ("lateral_ns", "i8"), ("frame_ns", "i8"),
        ("camera_ns", "i8"), ("law_ns", "i8"), ("fixed", "i8"), ("leapt", "i8"),
        ("waiting", SAMPLE, ROOM), ("count", "i8"), ("lag_ns", "i8"),
        ("lapse_s", "f8"), ("change", "f8", ENTRIES), ("speed", "f8", 4), ("speed_ns", "i8"),
        ("faster_mps", "f8"),
        # the IMU at the filter's time
        ("imu", "f8", 5), ("imu_ns", "i8"), ("heard", "i8", 5),
        ("felt", "f8", 2), ("felt_slow", "f8", 2), ("felt_var", "f8"), ("felt_s", "f8"),
        ("tilt", "f8", 2), ("tilted", "i8"),
        # ground and work
        ("grade", "f8"), ("grade_s", "f8"), ("ground", "f8", 2), ("ground_s", "f8"),
        ("surveyed", "i8"),
        ("pulls", "i8"), ("pulls_s", "f8"), ("depth_told", "i8"), ("slip", "f8"), ("level", "i8"),
        ("uneven", "f8", 2),
        ("sector_felt", "f8", (SECTORS, 2)), ("sector_s", "f8", SECTORS), ("stretch_s", "f8"),
        # learnt
        ("law_var", "f8"), ("law_s", "f8"), ("stance_s", "f8"), ("steady_rad", "f8"),
        ("lateral_psd", "f8"),
        ("accel", "f8", (2, 2)), ("accel_var", "f8"), ("accel_psd", "f8"), ("unrest", "f8"),
        ("excess", "f8"), ("agree", "f8"), ("anchor_m", "f8", 2),
        ("anchor_ns", "i8"), ("way_m", "f8", 2), ("way_mps", "f8", 2), ("way_ns", "i8"),
        ("notes", NOTES),
    ],
    align=True,
)  # fmt: skip
"""A plain value.

`known`: 1 once there is a heading and a speed; `placed`: 1 once there is a place; `lateral_ns`:
when GNSS or camera last told the lateral speed; `lag_ns`: how late samples come at most; `lapse_s`,
`change`: time over which the mean was carried and the covariance not yet, and F - I of it; `speed`:
what the slip filter said last, at `speed_ns`, -1 once it is taken; `faster_mps`: speed at which a
slide was last carried on; `heard`: 1 for each of the IMU's columns that has values; `felt`:
specific force ahead and to the left over half a second, `felt_slow` over some, in `felt_s`;
`tilt`: how far the ground's normal leans forward and left in the camera's axes, where it tells
that (`tilted`);
`ground`: gradient of the ground to the east and north, told while nothing is pulled (`surveyed`);
`sector_*`: what was felt along each heading; `uneven`: the part of it, ahead and to the left, that
is from level ground that leans a little [m/s2]; `law_var`: variance of the law of sliding [rad2];
`steady_rad`: its angle, averaged; `lateral_psd`: density of the lateral speed's walk from frame to
frame; `accel`, `accel_var`, `accel_psd`: the last forces, variance and density of their white
noise; `unrest`: factor of what no accelerometer tells; `excess`: of the gyro's noise; `agree`: how
far positions and velocities of the receiver are apart, from `anchor_*`, a position, and `way_*`,
the way since."""

NOMINAL = np.dtype(
    [
        ("cg_x_m", "f8"), ("wheelbase_m", "f8"), ("antenna_m", "f8", 3), ("mount_rad", "f8"),
        ("velocity_sd_mps", "f8"), ("heading_sd_rad", "f8"), ("position_sd_m", "f8"),
        ("gyro_density", "f8"), ("gyro_sd_radps", "f8"), ("gyro_bias_sd_radps", "f8"),
        ("accel_density", "f8"), ("accel_bias_sd_mps2", "f8"), ("gravity_mps2", "f8"),
        ("imu_m", "f8", 3), ("camera_m", "f8", 3),
    ],
    align=True,
)  # fmt: skip
"""The set-up as numbers."""


def first_memory() -> NDArray[Any]:
    """One record of MEMORY before the first sample."""
    memory = np.zeros(1, MEMORY)
    for name in MEMORY.names or ():
        if name.endswith("_ns"):
            memory[name] = -1
    memory["lag_ns"] = FIRST_LAG_NS
    memory["unrest"] = memory["excess"] = 1.0
    memory["accel"] = np.nan
    return memory


def nominal(setup: Setup) -> NDArray[Any]:
    """The set-up as one record; data-sheet values of the usual kind where it has none."""
    gnss, imu, camera = setup.gnss, setup.imu, setup.camera
    density = imu.gyro_noise_radps_rthz if imu else 1e-3
    gravity = 9.81 if imu is None or imu.gravity else 0.0
    told = (
        setup.cg_x_m,
        setup.wheelbase_m,
        gnss.lever_arm_m if gnss else (0.0, 0.0, 0.0),
        gnss.heading_mount_rad if gnss else 0.0,
        (gnss.velocity_sd_mps if gnss else 0.0) or 0.05,
        (gnss.heading_sd_rad if gnss else 0.0) or 0.005,
        (gnss.position_sd_m if gnss else 0.0) or 0.02,
        density,
        density * math.sqrt(imu.rate_hz if imu else 50.0),
        (imu.gyro_bias_sd_radps if imu else 0.0) or 1e-3,
        (imu.accel_noise_mps2_rthz if imu else 0.0) or 5e-3,
        (imu.accel_bias_sd_mps2 if imu else 0.0) or 0.1,
        gravity,
        imu.lever_arm_m if imu else (0.0, 0.0, 0.0),
        camera.lever_arm_m if camera else (0.0, 0.0, 0.0),
    )
    return np.array([told], NOMINAL)
