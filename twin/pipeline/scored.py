"""The scores of a result: every estimator against the truth, the bound, and how it ended."""

from __future__ import annotations

from dataclasses import asdict

from twin.pipeline.result import Result
from twin.plugins.lookup import attribute
from twin.scores import scores
from twin.scores.log_table import protocol_spans_ns
from twin.streams import Table

BOUND = "estimators.bounds:bound"
"""The bound is found by name: this package knows no estimator."""


def run_scores(result: Result) -> scores.Scores:
    """Scores of a simulated run inside the window of its scenario."""
    scenario, truth = result.scenario, result.truth
    assert scenario is not None, "a run has its scenario"
    unscored = scores.why_unscored(truth, scenario, result.end)
    scored = truth if unscored is None else None
    window = scores.scored_window_s(truth, scenario)
    table = scores.score(
        scored, result.estimates, scenario=scenario.name, seed=scenario.seed, window=window
    )
    return table | {
        "zero_slip": zero_slip(result),
        "bound": None if scored is None else bound(result, scored, window),
        "ended": result.ended,
        "end": None if result.end is None else result.end.plain(),
        "unscored": unscored,
        "notes": list(result.notes),
    }


def log_scores(result: Result) -> scores.Scores:
    """Scores against the log's reference, none without one; then the log's own statistics.

    Scores are split by phase: that of the reference where it has `phase` or `depth_m`, else the
    activity found in the log. The statistics are those of `result.found`, the notes and where slip
    is zero.
    """
    from twin.pipeline.drive import phases_of  # slow to import, and a run needs it not

    known = {"phase", "depth_m"} & set(result.truth)
    told = result.truth and not known
    spans_ns = protocol_spans_ns(result.found)
    driven = phases_of(result.streams, result.estimates, spans_ns) if told else None
    table = scores.score(
        result.truth, result.estimates, scenario=result.name, seed=None, driven=driven
    )
    own = {"zero_slip": zero_slip(result), "notes": list(result.notes)}
    return table | dict(result.found) | own


def zero_slip(result: Result) -> str | None:
    """Where slip is zero, as `twin.streams.ZERO_SLIPS` calls it; None without wheels."""
    wheels = result.setup.wheels
    return None if wheels is None else wheels.zero_slip


def bound(result: Result, truth: Table, window_s: tuple[float, float]) -> dict[str, float] | None:
    """Smallest errors that the sensors allow, by name; None where the window is too short."""
    try:
        found = asdict(attribute("bound", BOUND)(result.setup, result.streams, truth, window_s))
    except ValueError:
        return None
    return {name: float(value) for name, value in found.items() if value == value}
