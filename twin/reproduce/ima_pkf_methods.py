"""Who takes part in the IMA-PKF paper's simulation, and how its unprinted choices may be read.

The paper prints neither the box that Q and R are sought in, nor its encoding, nor P at the start,
nor the time between searches. The faithful reading is the plainest: variances in a wide linear
box, Q from 1e-6 to 1e-2 and R from 0.1 to 4 times the printed one, C growing from the start, a
search every five samples. The others stand beside it, whatever they give. None that was tried,
on other seeds than those of the trials, has both the published order, beyond its scatter and with
disturbances too, and the published error of the last method.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from scenarios.ima_pkf_signals import SD
from twin.io.result_rows import Row
from twin.pipeline.named import load

ADAPTIVE = {"PSO-PKF": "pso-pkf", "MA-PKF": "ma-pkf", "IMA-PKF": "ima-pkf"}
"""Name in the paper -> registered estimator, in the faithful reading."""
READINGS: dict[str, dict[str, Any]] = {
    "variances, Q to 1e-3, R x 0.1-10": {
        "process_var": (1e-6, 1e-3), "measurement_factor": (0.1, 10.0),
    },
    "variances, Q to 3e-3": {"process_var": (1e-6, 3e-3)},
    "variances, R x 0.01-10": {"measurement_factor": (0.01, 10.0)},
    "variances, R no less than printed": {"measurement_factor": (1.0, 4.0)},
    "deviations, Q to 1e-2, R x 0.1-10": {
        "encoding": "sd", "process_var": (1e-6, 1e-2), "measurement_factor": (0.1, 10.0),
    },
    "logarithms, Q 1e-8 to 1e-2, R x 0.1-4": {
        "encoding": "log", "process_var": (1e-8, 1e-2), "measurement_factor": (0.1, 4.0),
    },
    "logarithms, R as printed": {
        "encoding": "log", "process_var": (1e-8, 1e-2), "measurement_factor": (1.0, 1.0 + 1e-9),
    },
    "faithful, window of 1 s": {"window": 50},
    "faithful, adapted at every sample": {"every": 1},
}  # fmt: skip
"""Other readings -> what they change in the faithful one."""

PRINTED = {"front_sd_mps": SD["front"], "gnss_sd_mps": SD["gnss"], "rear_sd_mps": SD["rear"]}
NO_OFFSET = {"front_offset_sd_mps": 0.0, "front_offset_psd_m2ps3": 0.0}
NO_BIAS = {"bias_sd_mps2": 0.0, "wheel_bias_sd_mps2": 0.0, "bias_psd_m2ps5": 0.0}
BIAS = {"bias_sd_mps2": 0.1, "wheel_bias_sd_mps2": 0.1, "bias_psd_m2ps5": 0.0}


def adaptive(**changes: float) -> Row:
    """The three adaptive filters, with changes of the faithful reading."""
    return {name: replace(load("estimator", key), **changes) for name, key in ADAPTIVE.items()}


def beside(*, biased: bool) -> Row:
    """Raw ratios, the paper's KF, its PKF without optimiser, and filters that get the noise.

    Args:
        biased: whether the accelerometers are; tuned filters get this, too.
    """
    bias = BIAS if biased else NO_BIAS
    bank = PRINTED | bias
    tuned = PRINTED | bias | NO_OFFSET | {"accel_sd_mps2": SD["accel"]}
    smoother = {k: v for k, v in bias.items() if k != "wheel_bias_sd_mps2"}
    return {
        "raw ratio, GNSS": load("estimator", "ratio"),
        "raw ratio, front wheels": load("estimator", "ratio-front"),
        "KF": load("estimator", "kf-z2"),
        "PKF, Q = 1e-3 I": load("estimator", "pkf"),
        "tuned KF": replace(load("estimator", "kf-tuned"), **tuned),
        "likelihood bank": replace(load("estimator", "mmae"), **bank),
        "whiteness bank": replace(load("estimator", "whiteness"), **bank),
        "offline smoother": replace(load("estimator", "estimators.smoother:SMOOTHER"), **smoother),
    }
