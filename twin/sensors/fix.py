"""Solution mode of the GNSS receiver at each instant of a run, given its scheduled outages.

    corrections lost:  fixed -> extrapolated (10 s) -> float (20 s) -> single | float -> fixed
    sky masked:        fixed -> float (20 s) -> single | float -> fixed
    sky blocked:       fixed -> none | single (1 s) -> float -> fixed

where | is the end of the outage, and the last float lasts 5 to 30 s, drawn once per outage from the
seed. So for one seed the mode is a function of time.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from twin.errors import BadInput, check_range

Array = NDArray[np.float64]

Kind = Literal["corrections", "mask", "mask-aux", "block"]
KINDS = ("corrections", "mask", "mask-aux", "block")

EXTRAPOLATED_S = 10.0
"""Time for which a receiver extrapolates its last corrections, s."""
FLOAT_S = 20.0
"""Time for which it then keeps a float solution, s; errors are metres at an age of 30 s."""
SINGLE_S = 1.0
"""Time from the end of a blocked sky to the first float solution, s."""
REFIX_S = (5.0, 30.0)
"""Shortest and longest time from corrections' return to a fixed solution, s."""


class Mode(IntEnum):
    """How the position was solved."""

    FIXED = 0
    EXTRAPOLATED = 1
    FLOAT = 2
    SINGLE = 3
    NONE = 4


QUALITY = np.array([4, 4, 5, 1, 0], np.int64)
"""NMEA GGA quality by mode; while it extrapolates, a receiver still reports fixed."""


@dataclass(frozen=True, kw_only=True)
class Outage:
    """A scheduled fault of GNSS reception."""

    start_s: float
    """Start of the outage, from the start of the run, s."""
    duration_s: float
    """Duration of the outage, s."""
    kind: Kind = "corrections"
    """corrections: the link to the base is lost; mask: foil over both antennas; mask-aux: over
    the auxiliary one; block: no satellite at all."""

    def __post_init__(self) -> None:
        check_range("outage.start_s", self.start_s, 0, 1e6)
        check_range("outage.duration_s", self.duration_s, 0.01, 1e6)
        if self.kind not in KINDS:
            raise BadInput(f"outage.kind = {self.kind!r} is none of {', '.join(KINDS)}")

    @property
    def end_s(self) -> float:
        """End of the outage, from the start of the run, s."""
        return self.start_s + self.duration_s


@dataclass(frozen=True, kw_only=True)
class Timeline:
    """The k phases of a run, each with one mode."""

    start_s: Array
    """Start of each phase, from the start of the run; ascending, the first is -inf. Shape (k,)."""
    mode: NDArray[np.int64]
    """`Mode` of each phase. Shape (k,)."""
    drift_mps: Array
    """Rate at which the extrapolated error grows, east north up. Shape (k, 3)."""

    def at(self, time_s: Array) -> tuple[NDArray[np.int64], Array, Array]:
        """Mode, age of the mode [s] and drift [m/s] at each time; shapes (n,), (n,), (n, 3)."""
        segment = np.searchsorted(self.start_s, time_s, side="right") - 1
        age_s = np.where(segment > 0, time_s - np.maximum(self.start_s[segment], -1e9), 0.0)
        return self.mode[segment], age_s, self.drift_mps[segment]


def check_outages(outages: Sequence[Outage]) -> None:
    """Raise BadInput unless the outages are in order and do not overlap."""
    for before, after in pairwise(outages):
        if after.start_s < before.end_s:
            raise BadInput(
                f"the outage at {after.start_s:g} s starts before the one at "
                f"{before.start_s:g} s ends ({before.end_s:g} s); put them one after the other"
            )


def timeline(outages: Sequence[Outage], drift_sd_mps: Array, rng: Generator) -> Timeline:
    """The modes of a run; a new outage ends the recovery from the last one.

    One re-fix time and one drift are drawn from `rng` per outage, whatever its kind. `drift_sd_mps`
    is the sd of the drift, east north up, (3,).
    """
    segments: list[tuple[float, Mode, Array]] = [(-np.inf, Mode.FIXED, np.zeros(3))]
    for outage in outages:
        refix_s = float(rng.uniform(*REFIX_S))
        drift_mps = drift_sd_mps * rng.standard_normal(3)
        if outage.kind == "mask-aux":
            continue
        segments = [s for s in segments if s[0] < outage.start_s]
        segments += [(t, mode, drift_mps) for t, mode in _sequence(outage, refix_s)]
    return Timeline(
        start_s=np.array([s[0] for s in segments]),
        mode=np.array([s[1] for s in segments], np.int64),
        drift_mps=np.array([s[2] for s in segments]),
    )


def _sequence(outage: Outage, refix_s: float) -> Iterator[tuple[float, Mode]]:
    """When each mode of one fault begins."""
    stages = {
        "corrections": ((0.0, Mode.EXTRAPOLATED), (EXTRAPOLATED_S, Mode.FLOAT),
                        (EXTRAPOLATED_S + FLOAT_S, Mode.SINGLE)),
        "mask": ((0.0, Mode.FLOAT), (FLOAT_S, Mode.SINGLE)),
        "block": ((0.0, Mode.NONE),),
    }[outage.kind]  # fmt: skip
    for offset_s, mode in stages:
        if offset_s < outage.duration_s:
            yield outage.start_s + offset_s, mode
    end_s = outage.end_s
    if outage.kind == "corrections" and outage.duration_s <= EXTRAPOLATED_S:
        yield end_s, Mode.FIXED  # the ambiguities were never lost
        return
    if outage.kind == "block":
        yield end_s, Mode.SINGLE
        end_s += SINGLE_S
    yield end_s, Mode.FLOAT
    yield end_s + refix_s, Mode.FIXED


def active(outages: Sequence[Outage], kinds: Sequence[Kind], time_s: Array) -> NDArray[np.bool_]:
    """Whether an outage of one of the kinds is in force at each of n times. Shape (n,)."""
    inside = np.zeros(len(time_s), bool)
    for outage in outages:
        if outage.kind in kinds:
            inside |= (time_s >= outage.start_s) & (time_s < outage.end_s)
    return inside
