"""Single samples that stand apart from all their neighbours by more than a tractor can move."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.streams import Array

NEIGHBOURS = 3
"""On each side of a sample."""
GAP_S = 5.0
"""A step after which what was before says nothing of what comes."""
ALLOWED: dict[str, tuple[float, float]] = {
    "gnss": (0.5, 1.5), "wheels": (0.7, 3.0), "position": (5.0, 15.0),
}  # fmt: skip
"""Kind -> how far a sample may stand apart, and how much more for each second between samples:
ground speed [m/s, m/s2], wheel speed, which may also spin up [m/s, m/s2], position [m, m/s]."""


def spikes(values: Array, time_s: Array, kind: str) -> NDArray[np.bool_]:
    """Which samples are spikes, shape (n,).

    |x_i - median(x_i-3 .. x_i+3)| > a + b dt + 2 (spread of the neighbours without their extremes)
    """
    found = np.zeros(len(values), bool)
    finite = np.isfinite(values)
    whole = bool(finite.all())
    known = np.arange(len(values)) if whole else np.flatnonzero(finite)
    if len(known) <= 2 * NEIGHBOURS:
        return found
    x, t = (values, time_s) if whole else (values[known], time_s[known])
    apart, per_s = ALLOWED[kind]
    step_s = float(np.median(np.diff(t)))
    rough = np.zeros(len(x), bool)
    rough[1:] = np.abs(np.diff(x)) > apart + per_s * step_s
    at = np.unique(np.concatenate([np.flatnonzero(rough), np.flatnonzero(rough) - 1]))
    if not len(at):
        return found
    ends = np.concatenate([[0], np.flatnonzero(np.diff(t) > GAP_S) + 1, [len(x)]])
    piece = np.searchsorted(ends, at, side="right") - 1
    long = ends[piece + 1] - ends[piece] > 2 * NEIGHBOURS
    for i, j in zip(at[~long], piece[~long], strict=True):
        found[known[i]] = (
            _apart(x[ends[j] : ends[j + 1]], int(i - ends[j])) > apart + per_s * step_s
        )
    at, piece = at[long], piece[long]
    if not len(at):
        return found
    # at the ends of a piece, all neighbours are on one side
    first = np.clip(at - NEIGHBOURS, ends[piece], ends[piece + 1] - 2 * NEIGHBOURS - 1)
    index = first[:, None] + np.arange(2 * NEIGHBOURS + 1)
    others = index[index != at[:, None]].reshape(len(at), 2 * NEIGHBOURS)
    near = np.sort(x[others], axis=1)
    spread, middle = near[:, -2] - near[:, 1], np.median(near, axis=1)
    far = np.abs(x[at] - middle) > apart + per_s * step_s + 2.0 * spread
    found[known[at[far]]] = True
    return found


def _apart(piece: Array, at: int) -> float:
    """How far a sample of a short piece is from all others, less twice what they spread."""
    others = np.delete(piece, at)
    if len(others) < 3:
        return 0.0
    return float(abs(piece[at] - np.median(others)) - 2.0 * np.ptp(others))
