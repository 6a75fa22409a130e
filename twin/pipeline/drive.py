"""Statistics of a recorded drive for scores.json: activities, area and fuel, highest slips."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict

import numpy as np

from twin.io.plain import Plain
from twin.logs.activity import (
    EMPTY,
    STANDING,
    TURNING,
    UNKNOWN,
    WORKING,
    Activity,
    activity,
)
from twin.logs.job import Implement
from twin.logs.summary import area, highest_slip, shares
from twin.logs.timeline import SECOND_NS, timeline
from twin.scores.phases import Phases
from twin.streams import Array, Streams, Table
from twin.trajectory.phase import Phase


def findings(
    streams: Streams,
    estimates: Mapping[str, Table],
    implement: Implement | None,
    no_work_ns: Sequence[tuple[int, int]] = (),
) -> dict[str, Plain]:
    """Statistics of a drive, with the slip of the first estimator that gives a slip.

    Args:
        streams: measurements of the drive.
        estimates: estimator name -> table of estimates.
        implement: implement, as the column map describes it; None if unknown.
        no_work_ns: first and last epochs [ns] of time spans that are known to be no work.

    Returns:
        drive: estimator, start and span, the rule of the activities, their shares, the area, the
            stretches with the highest slip; None where nothing was measured.
        work_slip: estimator -> spread of its slip at work; absent where no work was found.
    """
    shown = shown_estimator(estimates)
    rows = timeline(streams, estimates.get(shown or ""))
    if not len(rows["epoch_ns"]):
        return {"drive": None}
    done = activity(rows, no_work_ns)
    width_m = None if implement is None else implement.width_m
    took = None if width_m is None else area(rows, done, width_m)
    start_ns = int(rows["epoch_ns"][0]) - SECOND_NS // 2
    found: dict[str, Plain] = {
        "drive": {
            "estimator": shown,
            "start_ns": start_ns,
            "span_s": float(rows["epoch_ns"][-1] - start_ns) * 1e-9 + 0.5,
            "rule": done.rule,
            "shares": [asdict(share) for share in shares(rows, done)],
            "width_m": width_m,
            "implement": None if implement is None else implement.name,
            "area": None if took is None else asdict(took),
            "high": [asdict(stretch) for stretch in highest_slip(rows, done)],
        }
    }
    if done[WORKING].any():
        found["work_slip"] = {
            name: spread(slip_at_work(table, rows, done)) for name, table in estimates.items()
        }
    return found


PHASE_OF = {
    WORKING: Phase.WORK,
    TURNING: Phase.TURN,
    EMPTY: Phase.ROAD,
    STANDING: Phase.STOP,
    UNKNOWN: UNKNOWN,
}
"""Activity of a log -> phase of a drive."""


def phases_of(
    streams: Streams,
    estimates: Mapping[str, Table],
    no_work_ns: Sequence[tuple[int, int]] = (),
) -> Phases | None:
    """The activities of a log as phases of a drive; None where nothing was measured."""
    rows = timeline(streams, estimates.get(shown_estimator(estimates) or ""))
    if not len(rows["epoch_ns"]):
        return None
    done = activity(rows, no_work_ns)
    code = np.array([PHASE_OF[of] for of in done.code.tolist()], np.int64)
    rule = f"phases are the log's activities: {done.rule[0].lower()}{done.rule[1:].rstrip('.')}"
    return Phases(rows["epoch_ns"] - SECOND_NS // 2, code, rule)


def shown_estimator(estimates: Mapping[str, Table]) -> str | None:
    """Name of the first estimator with a finite slip in any row; None if no estimator has one."""
    giving = (n for n, t in estimates.items() if "slip" in t and np.isfinite(t["slip"]).any())
    return next(giving, None)


def slip_at_work(estimate: Table, rows: Table, done: Activity) -> Array:
    """Slips [-] of an estimator in the seconds of work. Shape (n,); empty without a slip.

    Args:
        estimate: table of the estimator.
        rows: table of the drive with one row for each second.
        done: activity in each row of `rows`.
    """
    if "slip" not in estimate:
        return np.empty(0)
    seconds = rows["epoch_ns"][done[WORKING]] // SECOND_NS
    return np.asarray(estimate["slip"])[np.isin(estimate["epoch_ns"] // SECOND_NS, seconds)]


def spread(slip: Array) -> dict[str, float | int | None]:
    """Median, 5 % quantile, 95 % quantile and number of the finite slips [-]; None without any."""
    known = slip[np.isfinite(slip)]
    if not len(known):
        return {"median": None, "p05": None, "p95": None, "n": 0}
    p05, median, p95 = (float(q) for q in np.quantile(known, (0.05, 0.5, 0.95)))
    return {"median": median, "p05": p05, "p95": p95, "n": len(known)}
