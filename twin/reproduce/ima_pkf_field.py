"""The field comparison of the IMA-PKF paper (INMATEH 77-13), from the twin's own sensors.

Four depths, about 200 m each. Published are the reductions of MAE and RMSE against a KF that is not
defined and against RTK-GNSS, which is an input as well; here against the truth. The twin has no
accelerometer on the wheels, its encoders and receiver are far better than R1 and R2 say, and its
wheels' radius is not the nominal one: a bias that no choice of Q and R takes away.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from joblib import delayed

from twin.compute.mean import mean
from twin.compute.parallel import many
from twin.io.result_rows import Rows, row
from twin.pipeline.named import load
from twin.pipeline.run import run
from twin.scores.scores import score
from twin.streams import Setup, Table

DEPTHS_CM = (15, 20, 25, 30)
ESTIMATORS = {
    "raw ratio": "ratio",
    "KF": "kf-z2",
    "tuned KF": "kf-tuned",
    "PSO-PKF": "pso-pkf",
    "MA-PKF": "ma-pkf",
    "IMA-PKF": "ima-pkf",
    "IMA-PKF, log box": "ima-pkf-log",
    "slip as a state": "slip-ekf",
    "offline smoother": "slip-ekf-smooth",
}
REDUCTIONS = {
    15: {"MAE": 0.3395, "RMSE": 0.3467},
    20: {"MAE": 0.3435, "RMSE": 0.3442},
    25: {"MAE": 0.3629, "RMSE": 0.3706},
    30: {"MAE": 0.2747, "RMSE": 0.2260},
}
"""Published: 1 - error of IMA-PKF / error of KF, by depth."""
LARGEST = 0.0194
"""Published largest error of slip."""
KEYS = {"MAE": "mae", "RMSE": "rmse", "max": "max", "bias": "bias"}

FLOOR = "closed-form floor, unbiased"

Scores = dict[str, dict[str, float]]


def rows(trials: int = 8, jobs: int = 1) -> Rows:
    """All rows, over `trials` seeds; low and high of a measured figure are its 95 % interval."""
    cases = [(cm, seed) for cm in DEPTHS_CM for seed in range(trials)]
    found = many((delayed(plough)(*case) for case in cases), jobs)
    out: Rows = []
    for cm in DEPTHS_CM:
        scores = [each for each, case in zip(found, cases, strict=True) if case[0] == cm]
        out += _errors(f"{cm} cm", scores)
        for other in ("KF", "tuned KF"):
            out += _reductions(cm, other, scores)
    return out


def plough(depth_cm: int, seed: int) -> Scores:
    """Errors of slip of each estimator in one pass, by MAE, RMSE, max and bias."""
    scenario = replace(load("scenario", f"plough-{depth_cm}cm"), seed=seed)
    estimators = {name: load("estimator", key) for name, key in ESTIMATORS.items()}
    done = run(scenario, estimators=estimators)
    scored = score(done.truth, done.estimates, scenario=scenario.name, seed=seed)["estimators"]
    errors = {
        name: {key: float(scored[name]["slip"][field]) for key, field in KEYS.items()}
        for name in ESTIMATORS
    }
    return errors | {FLOOR: {"RMSE": floor(done.setup, done.truth)}}


def floor(setup: Setup, truth: Table) -> float:
    """The least slip RMSE of a causal filter of GNSS speed and acceleration, wheels known.

    P_v = sigma_v n_a / sqrt(rate of GNSS),  var s = P_v / w^2

    Source: as the closed form of the signals' simulation, with the accelerometer's noise as a
    density n_a; unbiased, level and without vibration, so that no filter comes near.
    """
    assert setup.gnss is not None
    assert setup.imu is not None
    noise = setup.imu.accel_noise_mps2_rthz
    var_v = setup.gnss.velocity_sd_mps * noise / setup.gnss.rate_hz**0.5
    wheel = truth["wheel_speed_mps"][truth["ploughing"].astype(bool)]
    return float(np.sqrt(np.mean(var_v / wheel**2)))


def _errors(case: str, scores: list[Scores]) -> Rows:
    out = []
    for name in ESTIMATORS:
        for key in ("MAE", "RMSE", "bias"):
            found = mean(each[name][key] for each in scores)
            out.append(row(case, f"{key}, {name}", found.mean, "1") | found.bounds)
        largest = max(each[name]["max"] for each in scores)
        published = LARGEST if name == "IMA-PKF" else None
        out.append(row(case, f"max, {name}", largest, "1", published=published))
    out.append(row(case, f"RMSE, {FLOOR}", float(np.mean([s[FLOOR]["RMSE"] for s in scores])), "1"))
    return out


def _reductions(cm: int, other: str, scores: list[Scores]) -> Rows:
    """How much smaller than another's the error of IMA-PKF is; negative where it is larger."""
    out = []
    for key in ("MAE", "RMSE"):
        gain = mean(1.0 - each["IMA-PKF"][key] / each[other][key] for each in scores)
        published = REDUCTIONS[cm][key] if other == "KF" else None
        line = row(
            f"{cm} cm", f"reduction of {key} against {other}", gain.mean, "1", published=published
        )
        out.append(line | gain.bounds)
    return out
