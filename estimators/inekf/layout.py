"""The state of the filter by name, and what it carries from sample to sample."""

from __future__ import annotations

import numpy as np

from estimators.innovations import NOTES

ATTITUDE, VELOCITY, SLIP, GYRO_BIAS, ACCEL_BIAS, FRONT_SCALE = range(0, 18, 3)
"""Where the parts of the error begin: phi, nu, mu, gyro bias, accelerometer bias, and the relative
error of the towed wheels' speed."""
SIZE = FRONT_SCALE + 1

TUNING = np.dtype(
    [
        ("accel_psd", "f8"),
        ("gyro_psd", "f8"),
        ("slip_psd", "f8"),
        ("skid_psd", "f8"),
        ("accel_bias_psd", "f8"),
        ("gyro_bias_psd", "f8"),
        ("skid_sd", "f8"),
        ("front_scale_sd", "f8"),
        ("front_scale_psd", "f8"),
        ("front_quick_sd", "f8"),
    ],
    align=True,
)
MEMORY = np.dtype(
    [
        ("time_ns", "i8"),
        ("first_ns", "i8"),
        ("imu_ns", "i8"),
        ("gnss_ns", "i8"),
        ("heading_ns", "i8"),
        ("flags", "i8"),
        ("known", "i8"),
        ("placed", "i8"),
        ("astray", "i8"),
        ("world_from_body", "f8", (3, 3)),
        ("v", "f8", 3),
        ("u", "f8", 3),
        ("gyro_bias", "f8", 3),
        ("accel_bias", "f8", 3),
        ("front_scale", "f8"),
        ("p", "f8", (SIZE, SIZE)),
        ("gyro", "f8", 3),
        ("accel", "f8", 3),
        ("rim_mps", "f8"),
        ("heading_rad", "f8"),
        ("sideslip_m", "f8"),
        ("sideslip_rear_m", "f8"),
        ("notes", NOTES),
    ],
    align=True,
)
"""`v`: velocity of the inertial unit in the world; `u`: what the driven wheels turn faster by, and
skid by, in the world; `placed`: 1 once the heading is known; `gyro`, `accel`: the newest
sample as measured, NaN where it has none; `rim_mps`: the driven wheels' newest speed;
`heading_rad`: of the antennas' baseline, at `heading_ns`; `astray`: how many headings in a row
were far off."""
