"""What the filter can be tuned by, as compiled code reads it."""

from __future__ import annotations

import numpy as np

NAMES = (
    "jerk_psd", "fading_s", "slip_s", "load_gain", "own_share", "traction_psd",
    "swing_sd", "swing_hz", "leak_sd", "leak_psd", "bias_psd", "scale_sd", "towed_s", "camera_psd",
    "quick_sd", "quick_s", "receiver_share", "receiver_s", "across_psd", "gate", "patience_s",
)  # fmt: skip

TUNING = np.dtype([(name, "f8") for name in NAMES], align=True)
"""One record: the fields of `SlipEkf`, in their order."""
