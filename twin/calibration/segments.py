"""Which parts of a log are fitted: steady work, and driving empty; by a stated rule."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.logs.activity import EMPTY, WORKING, activity, stretches
from twin.streams import Table

LONGEST_S, SHORTEST_S = 12, 6
"""Length of a segment [s]."""
MOST_WORK, MOST_EMPTY = 8, 4
"""Segments of each kind, at most, so that a fit takes minutes."""
SETTLED_S = 4
"""Work counts from so long after it began: the plough is then at its depth [s]."""
BESIDE_S = 3
"""Driving empty counts from so long after it began until so long before it ends: it starts, and the
plough is lowered or lifted there [s]."""
STEADY_MPS2 = 0.08
"""Driving empty is steady where the wheels' speed changes by less a second."""
STRAIGHT_RADPS = 0.06
FULL_DEPTH = 0.9
"""Share of the usual depth that counts as at work."""
HELD_SHARE = 0.25
"""Share of the log's work, by time its last, that is never fitted."""
RULE = (
    f"Segments are {SHORTEST_S} to {LONGEST_S} s of steady work, from {SETTLED_S} s after it "
    f"began, at no less than {FULL_DEPTH:.0%} of the usual depth; and of driving empty and straight"
    f" in which the wheels' speed changes by less than {STEADY_MPS2:g} m/s a second, less "
    f"{BESIDE_S} s at both ends. At most "
    f"{MOST_WORK} and {MOST_EMPTY} of them, evenly over the log. The last {HELD_SHARE:.0%} of the "
    "work is held back."
)


@dataclass(frozen=True)
class Segment:
    """Rows of a log that are fitted, or held back, as one."""

    rows: slice
    working: bool
    held_back: bool = False


def segments(rows: Table) -> list[Segment]:
    """The segments of a log, in the order of time.

    Raises:
        BadInput: too little steady work.
    """
    doing = activity(rows)
    work = _pieces(_at_depth(rows, doing[WORKING]), SETTLED_S, 0)
    if len(work) < 2:
        lasts_s = sum(piece.stop - piece.start for piece in work)
        raise BadInput(
            f"the log has {lasts_s} s of steady work; {4 * LONGEST_S} s in a straight line, with "
            "the implement in the ground, would do"
        )
    first_held = min(max(1, round((1.0 - HELD_SHARE) * len(work))), len(work) - 1)
    held_from = work[first_held].start
    empty = _pieces(_steady(rows, doing[EMPTY]), BESIDE_S, BESIDE_S)
    fitted = [piece for piece in work if piece.start < held_from]
    after = [piece for piece in work if piece.start >= held_from]
    chosen = [Segment(piece, True) for piece in _spread(fitted, MOST_WORK)]
    chosen += [
        Segment(piece, False)
        for piece in _spread([p for p in empty if p.start < held_from], MOST_EMPTY)
    ]
    chosen += [Segment(piece, True, held_back=True) for piece in _spread(after, MOST_WORK)]
    return sorted(chosen, key=lambda s: s.rows.start)


def _at_depth(rows: Table, working: NDArray[np.bool_]) -> NDArray[np.bool_]:
    if "depth_m" not in rows or not working.any():
        return working
    usual_m = float(np.nanmedian(rows["depth_m"][working]))
    return np.asarray(working & (rows["depth_m"] > FULL_DEPTH * usual_m))


def _steady(rows: Table, empty: NDArray[np.bool_]) -> NDArray[np.bool_]:
    wheel = rows["wheel_speed_mps"]
    change = np.abs(np.gradient(wheel)) if len(wheel) > 1 else np.zeros(len(wheel))
    turning = np.abs(rows.get("yaw_rate_radps", np.zeros(len(wheel))))
    raised = rows["depth_m"] < 0.0 if "depth_m" in rows else np.ones(len(wheel), np.bool_)
    with np.errstate(invalid="ignore"):
        return np.asarray(
            empty & raised & (change < STEADY_MPS2) & ~(turning > STRAIGHT_RADPS) & (wheel > 0.5)
        )


def _pieces(chosen: NDArray[np.bool_], after: int, before: int) -> list[slice]:
    """Stretches of chosen rows, less their first and last, cut into equal pieces."""
    out = []
    for first, stop in stretches(chosen):
        first, stop = first + after, stop - before
        if stop - first < SHORTEST_S:
            continue
        count = max(1, round((stop - first) / LONGEST_S))
        edges = np.linspace(first, stop, count + 1).round().astype(int)
        out += [slice(int(a), int(b)) for a, b in itertools.pairwise(edges)]
    return out


def _spread(pieces: list[slice], most: int) -> list[slice]:
    """So many of the pieces at most, evenly."""
    if len(pieces) <= most:
        return pieces
    return [pieces[i] for i in np.linspace(0, len(pieces) - 1, most).round().astype(int)]
