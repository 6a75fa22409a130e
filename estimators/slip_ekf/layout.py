"""The named state of the filter, its constants, and what it carries from sample to sample."""

from __future__ import annotations

import numpy as np

V, A, ACCEL_BIAS, W, RIM_RATE, RADIUS, REAR_TRAVEL = range(7)
"""Ground speed [m/s], its acceleration, the accelerometer's bias with gravity's leak [m/s2], speed
of the driven wheels' rims [m/s], its rate [m/s2], error of the driven wheels' radius, and their
travel less what has been counted [m]."""
SKID, QUICK_SKID, FRONT_TRAVEL, WHEEL_BIAS, LATE, QUICK_RADIUS = range(7, 13)
"""Slow and quick error of the front wheels' travel over the ground's, their travel less what has
been counted [m], bias of a wheel accelerometer [m/s2], time by which GNSS is later than it
says [s], quick error of the driven radius under changing load."""
SWING, SWING_RATE, USUAL, TILTING, CAMERA_SCALE = 13, 14, 15, 16, 17
"""Slip that comes and goes as the body pitches on its tyres, its rate [1/s], and the slip that the
load and the ground of the last minute have called for. Then the gyro's bias as
the false tilting it makes, times gravity [m/s3], and the error of a camera's speed, which is that
of its height."""
SIZE = 18

LAGS = 10
"""Accelerations kept, to hear how fast the motion changes."""

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

MEMORY = np.dtype(
    [
        ("time_ns", "i8"),
        ("measured_ns", "i8"),
        ("agreed_ns", "i8"),
        ("imu_ns", "i8"),
        ("front_ns", "i8"),
        ("refused_ns", "i8", 5),
        ("conflict_mps", "f8", 5),
        ("lean", "f8", 5),
        ("lifted", "i8"),
        ("towed_apart_mps", "f8"),
        ("miscounted", "f8"),
        ("leaps", "i8"),
        ("flags", "i8"),
        ("known", "i8"),
        ("raised", "i8"),
        ("lowered", "i8"),
        ("rear_ns", "i8"),
        ("rear_spans", "i8"),
        ("front_spans", "i8"),
        ("x", "f8", SIZE),
        ("cov", "f8", (SIZE, SIZE)),
        ("shift", "f8", SIZE),
        ("cut", "i8", SIZE),
        ("grown", "f8", (SIZE, SIZE)),
        ("first_mps", "f8"),
        ("first_var", "f8"),
        ("accel", "f8", LAGS),
        ("accel_ns", "i8", LAGS),
        ("jerk_psd", "f8"),
        ("accel_count", "i8"),
        ("accel_var", "f8"),
        ("apart_mps", "f8"),
        ("rim_mps", "f8"),
        ("spin", "f8"),
        ("forgotten_s", "f8"),
        ("gyro_y", "f8"),
        ("gyro_y_known", "i8"),
        ("pitch_rad", "f8"),
        ("pitch_rate", "f8"),
        ("pitch_accel", "f8"),
        ("pitch_held_rad", "f8"),
        ("v_y", "f8"),
        ("v_y_var", "f8"),
        ("v_y_ns", "i8"),
        ("travelled_m", "f8"),
        ("nis_sum", "f8", 5),
        ("nis_count", "i8", 5),
        ("refused", "i8", 5),
    ],
    align=True,
)
"""A plain value. `agreed_ns` is when a ground speed last fitted well, `refused_ns` since when one
does not, and `conflict_mps` by how much where no other speaks for the estimate; `lean` is the mean
of normalised innovations, `lifted` 1 more than the place of a towed wheel in the air,
`towed_apart_mps` the towed wheels' speeds right less left, averaged, beyond what turning makes,
`miscounted` the last error of the driven wheels' count if it was too large to be noise, `leaps` how
many of their samples in a row could not be. `*_spans` is 1 while the counted travel has an unbroken
origin; `shift`, `cut` and `grown` say what else than a measurement changed the state since the last
prediction: what was added to the mean, which states began anew, what was added to the covariance.
`first_*` is the ground speed before the filter has begun; `accel` the last accelerations, newest
first, `accel_var` the variance of their noise, `jerk_psd` the density of the jerk as they show it,
`forgotten_s` the time over which accelerations are forgotten; `lowered` is 1 once the plough has
been in the ground; `apart` the driven wheels' speeds right less left, `rim` their mean, averaged
over some seconds, `spin` the factor of the noise on their motion; `pitch_*` how the body has turned
nose down, and had at the last wheel sample; `travelled` the way since sideslip is summed; `nis_*`
and `refused` count for GNSS, IMU, front, rear and camera, in this order."""
