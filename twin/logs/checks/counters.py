"""Encoder counts that go on rising where a counter has wrapped or begun again."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

SPAN = 0.9
"""A counter that wraps has run over at least this share of its range."""
JUMP = 20.0
"""A step of more than this many of the largest usual ones is none that the wheel made."""


def unwrapped(
    counts: NDArray[np.float64],
) -> tuple[NDArray[np.int64], NDArray[np.bool_], list[str]]:
    """Counts without wraps and restarts, which samples are spikes, and notes. All finite.

    n'_k = n'_k-1 + d - M round(d / M),   d = n_k - n_k-1,   M = 2^i > max n - min n

    After a restart the wheel is taken to have turned as it did before.
    """
    spike = _spikes(counts)
    good = counts[~spike]
    step = np.diff(good)
    if not len(step):
        return counts.astype(np.int64), spike, []
    usual = np.quantile(np.abs(step), 0.99) if len(step) > 20 else np.median(np.abs(step))
    notes: list[str] = []
    span = float(good.max() - good.min())
    modulus = 2.0 ** max(int(np.ceil(np.log2(span + 1.0))), 1)
    folded = step - modulus * np.round(step / modulus)
    wraps = (folded != step) & (np.abs(folded) <= 3.0 * _small(step, modulus) + 2.0)
    if wraps.any() and span >= SPAN * modulus and np.mean(wraps) < 0.34:
        step = np.where(wraps, folded, step)
        notes.append(
            f"a counter of {int(np.log2(modulus))} bits unwrapped {int(wraps.sum())} times"
        )
        usual = np.quantile(np.abs(step), 0.99)
    jumps = np.abs(step) > JUMP * max(usual, 1.0)
    if jumps.any() and np.mean(jumps) < 0.1:
        before = np.maximum.accumulate(np.where(jumps, -1, np.arange(len(step))))
        step = np.where(jumps, np.where(before >= 0, step[np.maximum(before, 0)], 0.0), step)
        notes.append(f"a counter that begins anew {int(jumps.sum())} times goes on as it was")
    whole = np.zeros(len(counts), np.int64)
    whole[~spike] = (good[0] + np.concatenate([[0.0], np.cumsum(step)])).astype(np.int64)
    return whole, spike, notes


def _small(step: NDArray[np.float64], modulus: float) -> float:
    """The largest usual step of those that are no wraps."""
    small = np.abs(step[np.abs(step) <= 0.5 * modulus])
    return float(np.quantile(small, 0.99)) if len(small) else 0.0


def _spikes(counts: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Single samples that go away and come back at once."""
    spike = np.zeros(len(counts), bool)
    if len(counts) < 5:
        return spike
    step = np.diff(counts)
    usual = max(float(np.median(np.abs(step))), 1.0)
    there, back = step[:-1], step[1:]
    spike[1:-1] = (
        (np.abs(there) > 10.0 * usual)
        & (np.abs(back) > 10.0 * usual)
        & (np.abs(there + back) <= 6.0 * usual)
    )
    return spike
