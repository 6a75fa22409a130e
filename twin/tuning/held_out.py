"""What tuned noises gain on the part of a log that they were not found on, by pairs of blocks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.compute.mean import mean
from twin.pipeline.estimating import Estimator, all_estimates
from twin.scores import hidden
from twin.scores.scores import at
from twin.streams import Setup, Streams, Table
from twin.tuning.stages import RECEIVER, total

Array = NDArray[np.float64]

HIDDEN_S = 10.0
"""Time for which GNSS is hidden to score the predicted speed [s]."""
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
    decides: bool = True
    """Whether the verdict hangs on it; a reference, which few logs have, decides nothing."""

    @property
    def verdict(self) -> str:
        """`better`, `worse`, or `no difference` where the interval has 0 in it or there is none."""
        if not (self.low > 0.0 or self.high < 0.0):
            return "no difference"
        return "better" if (self.low > 0.0) == self.more_is_better else "worse"


def density_gain(quantity: str, before: Array, after: Array, n: Array) -> Gain:
    """The gain of log density per measurement.

    Args:
        quantity: what it is called.
        before, after: sums of each block.
        n: innovations in each block.
    """
    step = mean((after - before) / n)
    return Gain(
        quantity=quantity, unit="1",
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


def verdict(gains: Iterable[Gain]) -> str:
    """`better` where the log density is better and no measure of the speed is worse."""
    density, *others = (gain.verdict for gain in gains if gain.decides)
    return "worse" if "worse" in others else density


@dataclass(frozen=True)
class HeldOut:
    """The part of a log that decides."""

    setup: Setup
    streams: Streams
    """The whole log."""
    reference: Table
    """May be empty."""
    edges_ns: NDArray[np.int64]
    """Where the part's blocks begin, and the last one ends."""
    innovations: Table
    """Of the estimator before; their numbers by block are what sums are divided by."""

    def densities(self, before: Mapping[str, Array], after: Mapping[str, Array]) -> Iterator[Gain]:
        """The gain of density of all innovations, and of the receiver's alone.

        Args:
            before, after: sensor -> sums by block.
        """
        epoch_ns, sensor = self.innovations["epoch_ns"], self.innovations["sensor"]
        n = np.histogram(epoch_ns, self.edges_ns)[0]
        yield density_gain("log density of a measurement", total(before), total(after), n)
        if RECEIVER in before and RECEIVER in after:
            n = np.histogram(epoch_ns[sensor == RECEIVER], self.edges_ns)[0]
            if n.all():
                what = "the same of GNSS speed"
                yield density_gain(what, before[RECEIVER], after[RECEIVER], n)

    def errors(self, before: Estimator, after: Estimator) -> Iterator[Gain]:
        """The gain of the speed predicted without GNSS, and against a reference."""
        pair = {BEFORE: before, AFTER: after}
        ahead = self._predicted(pair)
        if ahead is not None:
            yield ahead
        yield from self._of_reference(pair)

    def _predicted(self, pair: Mapping[str, Estimator]) -> Gain | None:
        """The error of the speed predicted while GNSS is hidden."""
        if "gnss" not in self.streams:
            return None
        squares: dict[str, list[Array]] = {BEFORE: [], AFTER: []}
        for starts in hidden.passes(self.setup, self.streams, HIDDEN_S):
            late = starts[starts >= self.edges_ns[0]]
            if not len(late):
                continue
            seen = hidden.without_gnss(self.streams, late, HIDDEN_S)
            for name, table in all_estimates(pair, self.setup, seen).tables.items():
                speed, _, _ = hidden.errors(self.setup, self.streams, table, late, HIDDEN_S)
                squares[name].append(speed**2)
        if not squares[BEFORE]:
            return None
        what = f"speed predicted {HIDDEN_S:g} s without GNSS"
        return rms_gain(what, "m/s", *(np.concatenate(squares[n]) for n in (BEFORE, AFTER)))

    def _of_reference(self, pair: Mapping[str, Estimator]) -> Iterator[Gain]:
        """The errors against the log's own reference, by blocks of time."""
        told = {c: u for c, u in REFERENCES.items() if c in self.reference}
        if not told:
            return
        tables = all_estimates(pair, self.setup, self.streams).tables
        epoch_ns, blocks = self.reference["epoch_ns"], len(self.edges_ns) - 1
        block = np.searchsorted(self.edges_ns, epoch_ns, side="right") - 1
        for column, unit in told.items():
            if not all(column in table for table in tables.values()):
                continue
            squares = [
                (at(tables[name], column, epoch_ns) - self.reference[column]) ** 2
                for name in (BEFORE, AFTER)
            ]
            both = np.isfinite(squares[0]) & np.isfinite(squares[1])
            both &= (block >= 0) & (block < blocks)
            n = np.bincount(block[both], minlength=blocks)
            means = [np.bincount(block[both], s[both], blocks)[n > 0] / n[n > 0] for s in squares]
            gain = rms_gain(f"{column} against the reference", unit, *means)
            if gain is not None:
                yield replace(gain, decides=False)
