"""The same estimators on a recorded drive, and what its slip looks like."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from twin import logs
from twin.io import run_folder
from twin.io.plain import Plain
from twin.logs import Log, Reader
from twin.pipeline import log_check
from twin.pipeline.estimating import Estimator, all_estimates
from twin.pipeline.hidden import hidden_scores
from twin.pipeline.log_check import SteadySlip
from twin.pipeline.result import Result
from twin.plugins.percent import MOVING_MPS, percent_note
from twin.scores import scores
from twin.streams import Table


def estimate(
    path: Path,
    column_map: Path | None,
    *,
    estimators: Mapping[str, Estimator],
    reader: Reader | None = None,
    hide_s: Sequence[float] = (),
    told: Callable[[int, int], None] = lambda done, total: None,
) -> Result:
    """Read a log and run the estimators on it.

    Args:
        path: the log.
        column_map: TOML that says which column is what; None where the format says it.
        estimators: by name.
        reader: what reads the log; None finds out by what is in it.
        hide_s: for how long GNSS is hidden to score what is foretold [s]; none leaves it out.
        told: told how many estimators of how many are done.

    Raises:
        BadInput: the log or the map cannot be used; says which value, and what would do.
    """
    start = time.perf_counter()
    log, steady = _prepared(logs.read(path, column_map, reader))
    done = all_estimates(estimators, log.setup, log.streams, told)
    found = findings(log, done.tables, steady)
    if hide_s:
        found["hidden"] = hidden_scores(log, estimators, hide_s)
    reference = _reference(log, path) or {}
    odd = percent_note("slip of the reference", reference, log.streams)
    return Result(
        scenario=None,
        setup=log.setup,
        streams=log.streams,
        truth=reference,
        estimates=done.tables,
        wall_s=time.perf_counter() - start,
        notes=(*log.notes, *done.notes, *([odd] if odd else [])),
        failed=done.failed,
        name=path.resolve().stem,
        found=found,
    )


def findings(
    log: Log, estimates: Mapping[str, Table], steady: SteadySlip | None
) -> dict[str, Plain]:
    """The slip of each estimator while driving and, where the map has the rules, steady work."""
    found: dict[str, Plain] = {"slip": {n: slip_summary(t) for n, t in estimates.items()}}
    if steady is None:
        return found
    found["steady_slip"] = {n: steady_summary(log, t) for n, t in estimates.items()}
    found["steady"] = {
        "slip_median": steady.median, "slip_low": steady.low, "slip_high": steady.high,
        "n": steady.n, "rule": steady.rule, "scale": steady.scale.scale,
        "scale_low": steady.scale.low, "scale_high": steady.scale.high,
        "scale_n": steady.scale.n, "scale_rule": steady.scale.rule,
        "lag_s": float(steady.lag_s) if np.isfinite(steady.lag_s) else None,
    }  # fmt: skip
    return found


def slip_summary(estimates: Table) -> dict[str, float | int | None]:
    """Median, 5 % and 95 % of the estimated slip while driving faster than 0.5 m/s."""
    if "slip" not in estimates:
        return _quantiles(np.empty(0))
    slip = np.asarray(estimates["slip"], np.float64)
    speed = np.asarray(estimates.get("speed_mps", np.full(len(slip), np.inf)), np.float64)
    return _quantiles(slip[np.abs(speed) > MOVING_MPS])


def steady_summary(log: Log, estimates: Table) -> dict[str, float | int | None]:
    """The same over the rows of steady work, as the map's rule chooses them."""
    _, wheel_mps = logs.paired_speeds(log.streams)
    epoch_ns = log.streams["wheels"]["epoch_ns"]
    chosen = logs.choose(log.rules["steady"], log.rows, epoch_ns, wheel_mps)
    if "slip" not in estimates or not len(estimates["epoch_ns"]):
        return _quantiles(np.empty(0))
    return _quantiles(scores.at(estimates, "slip", epoch_ns[chosen]))


def _quantiles(slip: np.ndarray[Any, Any]) -> dict[str, float | int | None]:
    known = slip[np.isfinite(slip)]
    if not len(known):
        return {"median": None, "p05": None, "p95": None, "n": 0}
    p05, median, p95 = (float(q) for q in np.quantile(known, (0.05, 0.5, 0.95)))
    return {"median": median, "p05": p05, "p95": p95, "n": len(known)}


def _prepared(log: Log) -> tuple[Log, SteadySlip | None]:
    """The log with wheel speeds scaled to zero slip where its map gives the rules."""
    if "zero_slip" not in log.rules:
        return log, None
    scaled = log_check.scaled(log, log_check.log_scale(log).scale)
    return scaled, log_check.steady_slip(log) if "steady" in log.rules else None


def _reference(log: Log, path: Path) -> Table | None:
    """The log's own reference; for a run folder, its truth."""
    truth = path / run_folder.TRUTH
    if log.reference is None and path.is_dir() and truth.exists():
        return run_folder.read_parquet(truth)
    return log.reference
