"""Scores: each estimate against the truth at its own epoch, inside a stated window.

Pure functions on tables. What is left out is counted: a NaN, in the estimate or in the truth, and
what is slower than `twin.scores.phases.DRIVING_MPS`, where a slip is a ratio of two noises.

The module is longer than 300 lines because each score has a definition in its docstring, and all
scores share the window and the rule of what is left out.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from twin.plugins.lookup import Thing
from twin.scores.phases import DRIVING_MPS, SCORED, Phases, phases, speed_mps
from twin.streams import Table

if TYPE_CHECKING:
    from twin.trajectory.end import End

Array = NDArray[np.float64]
Scores: TypeAlias = dict[str, Any]
"""The tree of scores.json: numbers, text and None by name."""

SETTLE_S = 5.0
"""Without ploughing the first seconds are a start from standstill and are not scored [s]."""
SETTLE_M = 5.0
"""Distance after the plough is at full depth that is not scored [m]."""
LEAST_S = 1.0
"""Of a run that ended early, less than this is not scored [s]."""
SLOW_MPS = 0.3
"""Below this estimated speed an estimated slip is not worth showing [m/s]; scores count it."""
SMALLEST_TOTAL_M = 0.05
"""Totals smaller than this have no relative error [m]."""


def seconds(table: Table) -> Array:
    """Epochs of a table in seconds. Shape (n,)."""
    return np.asarray(table["epoch_ns"], np.float64) * 1e-9


def window_s(truth: Table, *, settle_s: float = SETTLE_S) -> tuple[float, float]:
    """First and last time that are scored [s], on the clock of `epoch_ns`.

    The window starts 5 m after the plough is at full depth, or `settle_s` after the first row if
    the machine does not plough. The window ends at the last row.

    Args:
        truth: table with `epoch_ns` [ns], `speed_mps` [m/s] and, if the machine ploughs,
            `ploughing`, which is true from the time of full depth.
        settle_s: time left out at the start of a run that does not plough [s].
    """
    time = seconds(truth)
    if len(time) == 0:
        return 0.0, 0.0
    start = _start_of_ploughing_s(truth, time)
    start = time[0] + settle_s if start is None else start
    return float(min(start, time[-1])), float(time[-1])


def scored_window_s(truth: Table, scenario: Thing) -> tuple[float, float]:
    """First and last time that are scored in a run of a scenario [s].

    `window_s` gives the window. The time left out at the start, `settle_s`, is zero if the scenario
    drives on a platform, or has signals but no machine.
    """
    course = getattr(scenario, "course", None)
    short = course is None or course.edge_m is not None
    return window_s(truth, settle_s=0.0) if short else window_s(truth)


def why_unscored(truth: Table, scenario: Thing, end: End | None) -> str | None:
    """Reason why a run that ended early has too little to score; None if a score is possible."""
    if end is None or not end.early:
        return None
    ploughs = getattr(scenario, "plough", None) is not None
    if ploughs and not np.any(truth["ploughing"]):
        return "it ended before the plough was at its full depth"
    first_s, last_s = scored_window_s(truth, scenario)
    if last_s - first_s >= LEAST_S:
        return None
    begins = "its start"
    if ploughs:
        begins = f"the first {SETTLE_M:g} m at full depth"
    elif scenario.course.edge_m is None:
        begins = f"the first {SETTLE_S:g} s"
    return f"it drove less than {LEAST_S:g} s beyond {begins}"


def _start_of_ploughing_s(truth: Table, time: Array) -> float | None:
    ploughing = truth.get("ploughing")
    if ploughing is None or not np.any(ploughing):
        return None
    first = int(np.argmax(ploughing))
    travelled = distance_m(truth)
    beyond = np.flatnonzero(travelled >= travelled[first] + SETTLE_M)
    return float(time[beyond[0]]) if len(beyond) else float(time[-1])


def moving(table: Table) -> Table:
    """Table with NaN as slip in the rows with a low speed, where noise dominates the slip."""
    if "slip" not in table or "speed_mps" not in table:
        return table
    with np.errstate(invalid="ignore"):
        slow = np.abs(table["speed_mps"]) < SLOW_MPS
    return {**table, "slip": np.where(slow, np.nan, table["slip"])}


def distance_m(truth: Table) -> Array:
    """Distance travelled since the first row: integral of |speed| by trapezoids [m]. Shape (n,)."""
    speed = np.nan_to_num(np.abs(truth["speed_mps"]))
    steps = 0.5 * (speed[1:] + speed[:-1]) * np.diff(seconds(truth))
    return np.concatenate([[0.0], np.cumsum(steps)])


def score(
    truth: Table | None,
    estimates: Mapping[str, Table],
    *,
    scenario: str,
    seed: int | None,
    window: tuple[float, float] | None = None,
    driven: Phases | None = None,
) -> Scores:
    """Scores of all estimators, in the form of scores.json.

    Args:
        truth: truth of a simulation, or reference of a log; None gives empty scores.
        estimates: estimator name -> table of estimates.
        scenario: name of the scenario.
        seed: random seed of the scenario; None for a log.
        window: first and last time that are scored [s]; default: result of `window_s`.
        driven: phases of the drive; default: result of `phases`.
    """
    head = {"scenario": scenario, "seed": seed}
    if not truth or len(truth["epoch_ns"]) == 0:
        return head | {"window_s": None, "truth": {}, "estimators": {n: {} for n in estimates}}
    span = window if window is not None else window_s(truth)
    driven = driven if driven is not None else phases(truth)
    return head | {
        "window_s": list(span),
        "driving_mps": DRIVING_MPS,
        "phase_rule": None if driven is None else driven.rule,
        "truth": truth_summary(truth, span),
        "estimators": {n: estimator_scores(truth, t, span, driven) for n, t in estimates.items()},
    }


def truth_summary(truth: Table, window: tuple[float, float]) -> dict[str, float | None]:
    """Means, standard deviations and totals of the truth in the window; None if unknown.

    Args:
        truth: truth of the run.
        window: first and last time [s].
    """
    part = _cut(truth, window)
    speed_mps, slip, draft_n, depth_m = (
        _finite(part.get(c)) for c in ("speed_mps", "slip", "draft_n", "depth_m")
    )
    mean_draft_n = _mean(draft_n)
    pulls = mean_draft_n is not None and abs(mean_draft_n) > 1.0
    return {
        "mean_speed_kmh": _scaled(_mean(speed_mps), 3.6),
        "slip_mean": _mean(slip),
        "slip_sd": _sd(slip),
        "draft_mean_kn": _scaled(mean_draft_n, 1e-3) if pulls else None,
        "draft_cv": _sd(draft_n) / mean_draft_n if pulls else None,  # type: ignore[operator]
        "depth_mean_m": _mean(depth_m) if pulls else None,
        "depth_sd_m": _sd(depth_m) if pulls else None,
        "distance_m": float(distance_m(part)[-1]) if len(speed_mps) else None,
        "sideslip_m": _total(part, "sideslip_m"),
        "sideslip_rear_m": _total(part, "sideslip_rear_m"),
    }


QUANTITIES = (
    ("slip", "slip", "slip_sd"),
    ("sideslip_angle_rad", "sideslip_rad", "sideslip_sd_rad"),
    ("sideslip_rear_angle_rad", "sideslip_rear_rad", ""),
    ("speed_mps", "speed_mps", ""),
)
"""Key of scores.json, and the estimates' columns of the value and of its standard deviation."""
AT_REST_TOO = ("speed_mps",)


def estimator_scores(
    truth: Table, estimates: Table, window: tuple[float, float], driven: Phases | None = None
) -> dict[str, Scores]:
    """Errors of slip, sideslip angles, speed and the sideslip totals of one estimator.

    The key `phases` holds the errors of each phase, if the phases are known. `n_slow` is the number
    of samples left out because machine and wheels are slower than 0.3 m/s.

    Args:
        truth: truth of the run.
        estimates: table of the estimator.
        window: first and last time that are scored [s].
        driven: phases of the drive; None if unknown.
    """
    part = _cut(estimates, window)
    epoch_ns = part["epoch_ns"]
    slow = is_slow(truth, epoch_ns)
    code = None if driven is None else driven.at(epoch_ns)
    found: dict[str, Scores] = {}
    by_phase: dict[str, Scores] = {}
    for key, column, sd in QUANTITIES:
        if column not in part or column not in truth:
            continue
        error, own_sd = errors(truth, part, column), part.get(sd)
        kept = np.ones(len(error), bool) if key in AT_REST_TOO else ~slow
        found[key] = _of(kept, error, own_sd) | {"n_slow": int(np.sum(~kept))}
        for name, phase in SCORED.items():
            if code is not None and (chosen := kept & ~slow & (code == phase)).any():
                by_phase.setdefault(name, {})[key] = _of(chosen, error, own_sd)
    for column in ("sideslip_m", "sideslip_rear_m"):
        if column in part and column in truth:
            found[column] = total_scores(truth, part, column)
    return found | ({"phases": by_phase} if by_phase else {})


def is_slow(truth: Table, epoch_ns: NDArray[np.int64]) -> NDArray[np.bool_]:
    """True at epochs [ns] where machine and wheels are slower than 0.3 m/s. Shape (n,)."""
    return at({**truth, "fastest": speed_mps(truth)}, "fastest", epoch_ns) < DRIVING_MPS


def _of(chosen: NDArray[np.bool_], error: Array, sd: Array | None) -> Scores:
    return error_scores(error[chosen], None if sd is None else sd[chosen])


def errors(truth: Table, estimates: Table, column: str) -> Array:
    """Estimate minus truth of a column, at the epochs of the estimates. Shape (n,).

    The error of an angle is wrapped to [-pi, pi) rad, because sideslip angles are near +pi or -pi
    when the machine drives in reverse.

    Args:
        truth: truth of the run.
        estimates: table of the estimator.
        column: name of the column in both tables.
    """
    if not column.endswith("_rad"):
        return np.asarray(estimates[column] - at(truth, column, estimates["epoch_ns"]))
    known = np.isfinite(truth[column])
    turned = np.full(len(known), np.nan)
    turned[known] = np.unwrap(truth[column][known])
    error = estimates[column] - at({**truth, column: turned}, column, estimates["epoch_ns"])
    beyond = np.abs(error) > np.pi  # what is not beyond keeps its bits
    return np.where(beyond, np.mod(error + np.pi, 2.0 * np.pi) - np.pi, error)


def at(table: Table, column: str, epoch_ns: NDArray[np.int64]) -> Array:
    """Values of a column at the epochs `epoch_ns` [ns], by linear interpolation. Shape (n,).

    The value is NaN outside the table and where a neighbouring row is NaN.
    """
    start = table["epoch_ns"][0]
    own = (table["epoch_ns"] - start).astype(np.float64)  # exact: below 2**53 ns = 104 days
    values: Array = np.interp(
        (epoch_ns - start).astype(np.float64),
        own,
        table[column].astype(np.float64),
        left=np.nan,
        right=np.nan,
    )
    return values


def error_scores(error: Array, sd: Array | None = None) -> Scores:
    """Statistics of an error e, and its consistency with the reported standard deviation sd.

        rmse = sqrt(mean e**2)   mae = mean |e|   max = max |e|   bias = mean e
        p999 = 0.999 quantile of |e|
        coverage_2sd = share of |e| <= 2 sd   (0.954 for a consistent Gaussian)
        nees_mean = mean (e / sd)**2          (1 for a consistent estimator)

    Args:
        error: estimate - truth. Shape (n,).
        sd: reported standard deviation, same unit. Shape (n,).
    """
    known = np.isfinite(error)
    e = error[known]
    counts = {"n": len(e), "n_nan": int(np.sum(~known))}
    if len(e) == 0:
        return dict.fromkeys(("rmse", "mae", "max", "bias", "p999")) | counts
    size = np.abs(e)
    result: Scores = {
        "rmse": float(np.sqrt(np.mean(e**2))),
        "mae": float(np.mean(size)),
        "max": float(np.max(size)),
        "bias": float(np.mean(e)),
        "p999": float(np.quantile(size, 0.999)),
        **counts,
    }
    return result if sd is None else result | _consistency(error, sd)


def _consistency(error: Array, sd: Array) -> dict[str, float | None]:
    known = np.isfinite(error) & np.isfinite(sd) & (sd > 0.0)
    if not np.any(known):
        return {"coverage_2sd": None, "nees_mean": None}
    ratio = error[known] / sd[known]
    return {
        "coverage_2sd": float(np.mean(np.abs(ratio) <= 2.0)),
        "nees_mean": float(np.mean(ratio**2)),
    }


def total_scores(truth: Table, estimates: Table, column: str) -> dict[str, float | None]:
    """Change of a running total [m] in the window: true, estimated, and relative error.

    rel_err = |est_m - true_m| / |true_m|, None if |true_m| < 0.05 m.

    est_m, true_m: last less first value [m], both between the same two epochs.
    """
    true = at(truth, column, estimates["epoch_ns"])
    rows = np.flatnonzero(np.isfinite(true) & np.isfinite(estimates[column]))
    if len(rows) < 2:
        return {"true_m": None, "est_m": None, "rel_err": None}
    first, last = rows[0], rows[-1]
    true_m = float(true[last] - true[first])
    est_m = float(estimates[column][last] - estimates[column][first])
    small = abs(true_m) < SMALLEST_TOTAL_M
    return {
        "true_m": true_m,
        "est_m": est_m,
        "rel_err": None if small else abs(est_m - true_m) / abs(true_m),
    }


def _cut(table: Table, window: tuple[float, float]) -> Table:
    first_ns, last_ns = (round(edge * 1e9) for edge in window)
    rows = (table["epoch_ns"] >= first_ns) & (table["epoch_ns"] <= last_ns)
    return {name: column[rows] for name, column in table.items()}


def _finite(column: NDArray[Any] | None) -> Array:
    if column is None:
        return np.empty(0)
    values = np.asarray(column, np.float64)
    return values[np.isfinite(values)]


def _mean(values: Array) -> float | None:
    return float(np.mean(values)) if len(values) else None


def _sd(values: Array) -> float | None:
    return float(np.std(values)) if len(values) else None


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else value * factor


def _total(part: Table, column: str) -> float | None:
    values = _finite(part.get(column))
    return float(values[-1] - values[0]) if len(values) else None
