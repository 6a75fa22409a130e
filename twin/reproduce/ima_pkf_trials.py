"""Trials of the IMA-PKF paper's simulation as streams, and the errors of estimators in them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from joblib import delayed
from numpy.typing import NDArray

from scenarios.ima_pkf import Trial, setup, simulate
from scenarios.ima_pkf_signals import streams
from twin.compute.parallel import many
from twin.io.result_rows import Row

Array = NDArray[np.float64]

SETTLED_S = 1.0
"""`rmse_settled` counts the errors after this time [s]; the others count all."""


@dataclass(frozen=True, kw_only=True)
class Errors:
    """Errors of slip in one trial [-]."""

    mae: float
    rmse: float
    largest: float
    rmse_settled: float
    """RMSE of the errors after 1 s."""


def errors(estimate: Array, truth: Array, time_s: Array) -> Errors:
    """Errors over a trial. Shapes (n,); a NaN anywhere is a NaN in all."""
    off = np.abs(estimate - truth)
    late = off[time_s > SETTLED_S]
    return Errors(
        mae=float(np.mean(off)),
        rmse=float(np.sqrt(np.mean(off**2))),
        largest=float(np.max(off)),
        rmse_settled=float(np.sqrt(np.mean(late**2))),
    )


def try_all(trial: Trial, estimators: Row) -> dict[str, Errors]:
    """Errors of each estimator in one trial; an estimator with a seed gets the trial's."""
    signals = simulate(trial)
    told, measured, out = setup(trial), streams(signals), {}
    for name, estimator in estimators.items():
        if hasattr(estimator, "seed"):
            estimator = replace(estimator, seed=trial.seed)
        _, table = estimator.run(estimator.init(told), measured)
        out[name] = errors(table["slip"], signals.slip, signals.time_s)
    return out


def study(trials: list[Trial], estimators: Row, jobs: int = 1) -> dict[str, list[Errors]]:
    """Errors of each estimator in each trial."""
    tried = many((delayed(try_all)(trial, estimators) for trial in trials), jobs)
    return {name: [each[name] for each in tried] for name in estimators}
