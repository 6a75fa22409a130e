"""What tuned noises gain on the part of a log that they were not found on, by pairs of blocks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.compute.mean import mean
from twin.pipeline.estimating import Estimator, all_estimates
from twin.scores import hidden
from twin.scores.scores import at
from twin.streams import Setup, Streams, Table

Array = NDArray[np.float64]

HIDDEN_S = 10.0
"""For so long GNSS is hidden to score the speed that is foretold [s]."""
LEAST_PLACES = 8
"""From fewer hidden times or blocks no interval is made."""
REFERENCES = {"slip": "1", "sideslip_rad": "rad", "speed_mps": "m/s"}
"""What a log's reference may have -> its unit."""
BEFORE, AFTER = "before", "after"


@dataclass(frozen=True, kw_only=True)
class Gain:
    """An error before and after, and the change with its 95 % interval over paired blocks."""

    quantity: str
    unit: str
    before: float
    after: float
    change: float
    """after / before - 1 of an rms; after - before of a log density."""
    low: float
    high: float
    n: int
    """Pairs."""
    more_is_better: bool = False

    @property
    def verdict(self) -> str:
        """`better`, `worse`, or `no difference` where the interval has 0 in it or there is none."""
        if not (self.low > 0.0 or self.high < 0.0):
            return "no difference"
        return "better" if (self.low > 0.0) == self.more_is_better else "worse"


def density_gain(before: Array, after: Array, n: Array) -> Gain:
    """The gain of log density per measurement.

    Args:
        before, after: sums of each block.
        n: innovations in each block.
    """
    step = mean((after - before) / n)
    return Gain(
        quantity="log density of a measurement", unit="1",
        before=float(np.mean(before / n)), after=float(np.mean(after / n)),
        change=step.mean, low=step.low, high=step.high, n=step.n, more_is_better=True,
    )  # fmt: skip


def rms_gain(quantity: str, unit: str, before: Array, after: Array) -> Gain | None:
    """The change of an rms from mean squares of pairs; None from too few of them.

    after / before - 1 = sqrt(1 + mean(after^2 - before^2) / mean(before^2)) - 1
    """
    both = np.isfinite(before) & np.isfinite(after)
    if both.sum() < LEAST_PLACES or not before[both].any():
        return None
    base = float(np.mean(before[both]))
    step = mean(after[both] - before[both])
    change, low, high = (
        math.sqrt(max(1.0 + end / base, 0.0)) - 1.0 for end in (step.mean, step.low, step.high)
    )
    return Gain(
        quantity=quantity, unit=unit, before=math.sqrt(base),
        after=math.sqrt(float(np.mean(after[both]))), change=change, low=low, high=high, n=step.n,
    )  # fmt: skip


def foretold(
    pair: Mapping[str, Estimator], setup: Setup, streams: Streams, from_ns: int
) -> Gain | None:
    """The error of the speed foretold while GNSS is hidden, at places after an instant.

    Args:
        pair: the estimator BEFORE and AFTER.
        setup, streams: the whole log.
        from_ns: where the held-out part begins.
    """
    if "gnss" not in streams:
        return None
    squares: dict[str, list[Array]] = {BEFORE: [], AFTER: []}
    for starts in hidden.passes(setup, streams, HIDDEN_S):
        late = starts[starts >= from_ns]
        if not len(late):
            continue
        seen = hidden.without_gnss(streams, late, HIDDEN_S)
        for name, table in all_estimates(pair, setup, seen).tables.items():
            speed, _, _ = hidden.errors(setup, streams, table, late, HIDDEN_S)
            squares[name].append(speed**2)
    if not squares[BEFORE]:
        return None
    what = f"speed foretold {HIDDEN_S:g} s without GNSS"
    return rms_gain(what, "m/s", *(np.concatenate(squares[n]) for n in (BEFORE, AFTER)))


def of_reference(
    pair: Mapping[str, Estimator], setup: Setup, streams: Streams, reference: Table,
    edges_ns: NDArray[np.int64],
) -> Iterable[Gain]:  # fmt: skip
    """The errors against a log's own reference, by blocks of time."""
    told = {c: u for c, u in REFERENCES.items() if c in reference}
    if not told:
        return
    tables = all_estimates(pair, setup, streams).tables
    epoch_ns = reference["epoch_ns"]
    block = np.searchsorted(edges_ns, epoch_ns, side="right") - 1
    for column, unit in told.items():
        squares = []
        for name in (BEFORE, AFTER):
            known = column in tables[name]
            own = at(tables[name], column, epoch_ns) if known else np.full(len(epoch_ns), np.nan)
            squares.append((own - reference[column]) ** 2)
        both = np.isfinite(squares[0]) & np.isfinite(squares[1])
        both &= (block >= 0) & (block < len(edges_ns) - 1)
        if not both.any():
            continue
        n = np.bincount(block[both], minlength=len(edges_ns) - 1)
        sums = [np.bincount(block[both], s[both], len(edges_ns) - 1)[n > 0] for s in squares]
        gain = rms_gain(column, unit, *(s / n[n > 0] for s in sums))
        if gain is not None:
            yield gain
