"""Values carried forward: a table that repeats a slow source's last value until the next comes.

A row that repeats the last value between two beats of the source is not a measurement. A row on the
beat is one, even if its value is the same. Ten copies of a value carry the information of one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twin.streams import Array

FEWEST_CHANGES = 5
LEAST_ROWS = 2.9
"""Rows a value must usually stand on to be called carried forward."""
SHARE = 0.85
"""Share of the changes that must fall on the source's beat."""


def measured(columns: Sequence[Array]) -> NDArray[np.bool_] | None:
    """Which rows are new measurements of a source whose values are carried forward.

    The rows from change to change are whole multiples of a beat of at least three rows. Where the
    value stays for longer, the source has measured the same again at every beat.

    Args:
        columns: values of one source, each of shape (n,).

    Returns:
        Shape (n,); None if the values are not carried forward: they change less than five times,
        on a beat below 2.9 rows, on no beat, or by steps of their resolution.
    """
    changed = np.zeros(len(columns[0]), bool)
    for column in columns:
        changed |= _changes(column)
    at = np.flatnonzero(changed)
    if len(at) < FEWEST_CHANGES or all(_counts_up(c) for c in columns):
        return None
    rows = np.diff(at).astype(np.float64)
    beat = float(np.median(rows[rows <= 1.5 * np.quantile(rows, 0.1)]))
    if beat < LEAST_ROWS:
        return None
    beats = np.maximum(np.round(rows / beat), 1.0)
    beat = float(rows.sum() / beats.sum())  # of a source and a table with clocks of their own
    off = np.abs(rows - beats * beat)
    if np.mean(off <= np.minimum(1.0 + 0.02 * rows, 0.25 * beat)) < SHARE:
        return None
    since = np.arange(len(changed)) - np.maximum.accumulate(
        np.where(changed, np.arange(len(changed)), 0)
    )
    due = since % max(round(beat), 1) == 0
    return np.asarray(changed | due)


def _changes(column: Array) -> NDArray[np.bool_]:
    """Where a value differs from that of the row before; a hole that stays is no change."""
    values = np.asarray(column, np.float64)
    changed = np.zeros(len(values), bool)
    same = (values[1:] == values[:-1]) | (np.isnan(values[1:]) & np.isnan(values[:-1]))
    changed[1:] = ~same
    return changed


def _counts_up(column: Array) -> bool:
    """Whether a column goes by its own resolution: then it stays because it is coarse."""
    step = np.abs(np.diff(np.asarray(column, np.float64)))
    step = step[np.isfinite(step) & (step > 0.0)]
    return not len(step) or float(np.median(step)) < 1.9 * float(step.min())
