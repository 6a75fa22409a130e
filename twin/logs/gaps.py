"""Gaps in time: found and reported, never filled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.streams import Array

GAP_STEPS = 2.5
"""A step of more median steps than this is a gap."""
LEAST_S = 0.5
"""A shorter step changes no estimate."""
_TOLD = 5


def gap_notes(name: str, epoch_ns: NDArray[np.int64]) -> list[str]:
    """A note for each step of more than 2.5 median steps and 0.5 s; after five, how many more."""
    step_ns = np.diff(epoch_ns)
    if len(step_ns) < 2:
        return []
    longest_ns = max(GAP_STEPS * float(np.median(step_ns)), LEAST_S * 1e9)
    at = np.flatnonzero(step_ns > longest_ns)
    notes = [f"{name}: gap of {step_ns[i] * 1e-9:.1f} s at row {i + 2}" for i in at[:_TOLD]]
    if len(at) > _TOLD:
        longest = f"the longest {step_ns[at].max() * 1e-9:.1f} s"
        notes.append(f"{name}: {len(at) - _TOLD} more gaps, {longest}")
    return notes


def between(
    at_s: Array, time_s: Array, values: Array, longest_s: float = 0.0
) -> NDArray[np.float64]:
    """Linear interpolation; NaN outside the samples and within a gap.

    A step of up to `longest_s` is no gap, however short the others are.
    """
    found: NDArray[np.float64] = np.interp(at_s, time_s, values, left=np.nan, right=np.nan)
    if len(time_s) > 2:
        step_s = np.diff(time_s)
        right = np.clip(np.searchsorted(time_s, at_s), 1, len(time_s) - 1)
        gap = step_s[right - 1] > max(GAP_STEPS * float(np.median(step_s)), longest_s)
        found[gap & (at_s != time_s[right]) & (at_s != time_s[right - 1])] = np.nan
    return found
