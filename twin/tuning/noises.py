"""Which noises can be tuned, their present values, and how far these may be off."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput, UnknownName
from twin.pipeline.tuned import FACTORS, Noises
from twin.plugins.lookup import Thing
from twin.scenario.fields import value
from twin.streams import Setup, Streams

PRIOR_FACTOR = {"measured": 1.2, "published": 2.0, "derived": 3.0, "assumed": 10.0}
"""Grade of a value -> the factor by which it is off by one standard deviation of the prior."""
BOUND_SD = 3.0
"""No value is changed by more than this many standard deviations of the prior."""


@dataclass(frozen=True, kw_only=True)
class Noise:
    """A noise that may be tuned; its logarithm is off by a normal error."""

    name: str
    """Field of the estimator by dotted path, or name in `FACTORS`."""
    before: float
    """The value; 1 for a factor."""
    grade: str
    """Of `PRIOR_FACTOR`."""
    is_factor: bool = False
    """Whether it multiplies an sd that the data sheet or the stream states."""

    @property
    def prior_sd(self) -> float:
        """sd of the error's logarithm."""
        return math.log(PRIOR_FACTOR[self.grade])

    @property
    def bound(self) -> float:
        """Most by which the logarithm is moved."""
        return BOUND_SD * self.prior_sd


def noises_of(name: str, estimator: Thing, setup: Setup, streams: Streams) -> list[Noise]:
    """The noises of an estimator on a log: its own fields, and those of the sensors in the log.

    Args:
        name: what messages call the estimator.
        estimator: its `tunable` maps fields to grades; without, the sensors' noises alone count.
        setup, streams: the log.

    Raises:
        UnknownName: a grade or a field is none.
        BadInput: a field's value is no number above 0.
    """
    found = []
    tunable: Mapping[str, str] = getattr(estimator, "tunable", {})
    for path, grade in tunable.items():
        if grade not in PRIOR_FACTOR:
            raise UnknownName(f"grade of '{path}' of estimator '{name}'", grade, PRIOR_FACTOR)
        before = value(estimator, path)
        if not (isinstance(before, int | float) and before > 0.0):
            raise BadInput(f"estimator '{name}': {path} = {before} is no number above 0 to tune")
        found.append(Noise(name=path, before=float(before), grade=grade))
    for factor, (sensor, _, column) in FACTORS.items():
        told = getattr(setup, sensor) is not None or column in streams.tables.get(sensor, {})
        if sensor in streams and told and _counts(factor, streams):
            found.append(Noise(name=factor, before=1.0, grade="published", is_factor=True))
    return found


def _counts(factor: str, streams: Streams) -> bool:
    """Whether the log has what the factor is about."""
    if factor == "wheel_speed":
        return any(c.startswith("speed_") for c in streams["wheels"])
    if factor == "gnss_heading":
        return bool(np.isfinite(streams.column("gnss", "heading_rad").astype(float)).any())
    if factor == "gnss_position":
        return bool(np.isfinite(streams.column("gnss", "east_m").astype(float)).any())
    return True


def moved(noises: Sequence[Noise], logs: NDArray[np.float64]) -> Noises:
    """The noises multiplied by exp(logs); those that stay are left out."""
    there = [(n, n.before * math.exp(by)) for n, by in zip(noises, logs, strict=True) if by != 0.0]
    return Noises(
        values={n.name: to for n, to in there if not n.is_factor},
        factors={n.name: to for n, to in there if n.is_factor},
    )
