"""The state of the filter by name, its flags, and what it carries from sample to sample."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.innovations import NOTES
from estimators.slip_ekf.held import HELD
from twin.streams import COLUMNS

V, A, W, W_RATE = range(4)
"""Ground speed [m/s], its acceleration [m/s2], speed of the driven wheels as their nominal radius
gives it [m/s], its rate [m/s2]."""
REAR, FRONT, READ_DELAY = range(4, 7)
"""Travel of the driven and of the towed wheels less what has been counted [m], and by how much the
counters were read after their stamp [s]."""
RADIUS, TOWED, TOWED_FAST, CAMERA = range(7, 11)
"""Relative errors: of the driven wheels' counted speed, of the towed wheels', its quick part, and
of a camera's speed."""
TRACTION, PITCH_SLIP, PITCH_SLIP_RATE = range(11, 14)
"""Gross traction at the mean load over its most (`brixius`), slip that comes and goes as the body
pitches on its tyres, and its rate [1/s]."""
BIAS, BIAS_RATE, WHEEL_BIAS = range(14, 17)
"""Bias of the accelerometer with gravity's part [m/s2], the gyro's bias as the rate of that
[m/s3], bias of a wheel accelerometer [m/s2]."""
GNSS_BIAS, LATENCY, V_Y, UNLOADED_SLIP = range(17, 21)
"""Error of GNSS that lasts [m/s], time by which it is later than stated [s], velocity across
the body [m/s], and slip of the axle with the plough out of the ground."""
SIZE = 21
NUMBER = np.arange(SIZE)
"""A number from here is no constant to the compiler, which would compile what it is passed to
anew for each constant."""

FROM_GNSS, FROM_IMU, FROM_TOWED, FROM_DRIVEN, FROM_CAMERA = range(5)
"""The sources, as `seen_mps` and the like count them."""
SOURCES = 5

GATED = 8
"""Flag: a speed was refused since the last estimate: it was further off than its sd allows."""
RAISED = 16
"""Flag: the zero condition holds: the plough is out of the ground, so the axle hardly slips."""
NO_FRONT = 32
"""Flag: no towed wheel has been counted for a second."""
NO_IMU = 64
"""Flag: no acceleration for a second."""
ONE_WHEEL = 128
"""Flag: the driven wheels disagree more than turning explains; one of them is taken alone."""

FIRST_CAMERA_PSD = 1e-4
"""Density of the walk of a camera's scale before it is learnt: 1 % in a second [1/s]."""
FIRST_SPREAD_SD = 0.15
"""sd of the traction about the one that the load calls for, before it is learnt."""
FIRST_JITTER_S = 1e-3
"""sd of the instants of reading before any is learnt [s]: a log's resolution is often 1 ms."""
LAGS = 10
"""Accelerations kept, which tell how fast the motion changes."""

MEMORY = np.dtype(
    [
        ("x", "f8", SIZE), ("p", "f8", (SIZE, SIZE)), ("known", "i8"), ("flags", "i8"),
        ("time_ns", "i8"), ("measured_ns", "i8"), ("wheels_ns", "i8"), ("imu_ns", "i8"),
        ("again_ns", "i8", (len(COLUMNS), 2)), ("again_count", "i8", len(COLUMNS)),
        ("first_mps", "f8"), ("first_var", "f8"), ("first_ns", "i8"),
        # by source
        ("seen_ns", "i8", SOURCES), ("seen_mps", "f8", SOURCES), ("refused_ns", "i8", SOURCES),
        ("mean_error_mps", "f8", SOURCES), ("noise_factor", "f8", SOURCES),
        ("white_ns", "i8", SOURCES), ("white_last", "f8", (SOURCES, 2)),
        ("white_var", "f8", SOURCES), ("nis_sum", "f8", SOURCES), ("nis_count", "i8", SOURCES),
        # the receiver's own rate
        ("repeated_mps", "f8"), ("changed_ns", "i8"), ("interval_s", "f8"),
        ("mean_innovation", "f8"), ("mean_innovation_ns", "i8"),
        # wheels
        ("unbroken", "i8", 2), ("step", "f8", 2), ("step_s", "f8"), ("counted", "i8"),
        ("jitter_var", "f8"), ("count_var", "f8"), ("rim_mps", "f8"), ("difference_mps", "f8", 2),
        ("lifted", "i8"), ("implausible", "i8", 2), ("last", "f8"), ("yaw_rate", "f8"),
        # motion
        ("wheel_factor", "f8"), ("motion_factor", "f8"), ("towed_innovation", "f8"),
        ("slow_mps", "f8", 2), ("gain_sums", "f8", 2), ("accel", "f8", LAGS),
        ("accel_ns", "i8", LAGS), ("accel_count", "i8"), ("accel_var", "f8"), ("jerk_psd", "f8"),
        ("gyro", "f8"), ("pitch_rad", "f8"), ("pitch_rate", "f8"), ("pitch_accel", "f8"),
        ("pitch_held_rad", "f8"), ("travelled_m", "f8"),
        # slip, load and camera
        ("plough", "i8"), ("lowered", "i8"), ("torque", "f8", 2),
        ("raised_s", "f8"), ("towed_before", "f8"), ("work_s", "f8"), ("work_slip", "f8"),
        ("y_var", "f8"), ("slip_s", "f8"),
        ("mean_load", "f8", HELD), ("line", "f8", HELD), ("line_p", "f8", (HELD, HELD)),
        ("camera_psd", "f8"), ("camera_scale", "f8", 2), ("camera_ns", "i8"),
        # for a smoother
        ("keeps", "i8"), ("gained", "f8", SIZE), ("lost", "f8", (SIZE, SIZE)), ("cut", "i8", SIZE),
        ("notes", NOTES),
    ],
    align=True,
)  # fmt: skip
"""A plain value.

`again_*`: by sensor, the first and the last epoch that were out of order since one was new, and how
many there were.

`first_*`: a ground speed from before the filter knows one, its variance, and its epoch.

By source: `seen_*` epoch and ground speed of its last sample; `refused_ns` since when it is
refused, `mean_error_mps` by how much on average; `noise_factor` of the variance of its lasting
error; `white_*` the variance of its white noise, and the speeds that is learnt from; `nis_*` the
normalised innovations squared. `repeated_mps`, `changed_ns`, `interval_s`: the receiver's last new
speed, when it came, and the mean time between two; `mean_innovation*`: mean of its
normalised innovations, and when that was last small.

By axle, driven and towed: `unbroken` 1 while the count has an unbroken origin; `step` the last
counted travel, in `step_s`; `difference_mps` right less left; `implausible` samples in a row in
which no wheel could be right. `jitter_var`, `count_var`: variances of the instants of reading and
of an axle's counted travel, learnt from `counted` samples; `rim_mps`: counted speed of the driven
wheels over some seconds; `lifted`: 1 more than the place of a towed wheel in the air; `last`:
e / sqrt(S) of the driven wheels' last count.

`wheel_factor`: factor of the noise on the driven wheels' own motion; `motion_factor`: of that on
both axles' motion, without an accelerometer; `towed_innovation`: last e / sqrt(S) of the
towed wheels; `slow_mps`, `gain_sums`: slow parts of both speeds, and sums over the quick ones;
`accel`: the last accelerations, newest first; `pitch_*`: how the body has turned nose down, and had
at the last wheel sample.

`plough`: 1 raised, -1 in the ground, 0 not known yet; `lowered`: 1 once it has gone down;
`torque`: the axle's mean torque, raised and at work; `raised_s`, `work_s`, `work_slip`: for how
long, and the mean slip at work; `towed_before`: error of the towed wheels as the plough went down;
`y_var`: variance of the traction about the expected one, learnt for `slip_s`; `mean_load`, `line`,
`line_p`: the mean loads, the line from them to traction, and its covariance; `camera_*`: density of
the walk of a camera's scale, and what that is learnt from.

`keeps`: 1 for a smoother, which needs what measurements have `gained` and `lost` of mean and
covariance since the last prediction, and which states were `cut` off then;
`notes`: the innovations of this sample."""


def first_memory(jerk_psd: float) -> NDArray[Any]:
    """One record of MEMORY before the first sample."""
    memory = np.zeros(1, MEMORY)
    for name in MEMORY.names or ():
        if name.endswith("_ns"):
            memory[name] = -1
    memory["white_last"] = memory["mean_load"] = np.nan
    memory["first_mps"] = memory["repeated_mps"] = memory["gyro"] = np.nan
    for name in ("interval_s", "noise_factor", "wheel_factor", "motion_factor"):
        memory[name] = 1.0
    memory["jerk_psd"] = jerk_psd
    memory["camera_psd"] = FIRST_CAMERA_PSD
    memory["y_var"] = FIRST_SPREAD_SD**2
    memory["jitter_var"] = FIRST_JITTER_S**2
    return memory
