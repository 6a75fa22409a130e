"""What a filter can be tuned by, as compiled code reads it, and the streams it counts by."""

from __future__ import annotations

import numpy as np

FROM_GNSS, FROM_IMU, FROM_FRONT, FROM_REAR, FROM_CAMERA = range(5)

TUNING = np.dtype(
    [
        (name, "f8")
        for name in (
            "jerk_psd", "restless", "accel_tau", "slip_share", "measured_slip_psd",
            "load_correlation", "unheard_psd", "unheard_share", "unheard_tau",
            "usual_tau", "usual_psd", "swing_sd", "swing_hz", "swing_damping",
            "leak_sd", "leak_psd", "bias_psd", "gyro_bias_sd", "radius_sd",
            "radius_psd", "skid_sd", "skid_psd", "quick_skid_sd", "quick_radius_sd",
            "quick_tau", "late_sd", "gate", "back", "patience", "trust", "lean", "follow",
            "zero_slip", "zero_slip_sd", "unload", "unload_sd", "load", "load_sd",
            "settle_sd", "camera_scale_sd", "camera_scale_psd", "camera_sd",
            "v_y_psd", "mount_sd", "accel_floor_sd",
        )
    ],
    align=True,
)  # fmt: skip
"""One record: the fields of `SlipEkf`, in their order."""
