"""Noises of sensors first, then those of the filter, as the part that is learnt from has them.

A filter's model is never exact. What it gains where most innovations are, fifty a second of an
accelerometer, may cost it the speed. So the filter's own values are found from the innovations
of the receiver's speed; values that do not change these are found from all innovations.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.tuning.noises import Noise
from twin.tuning.search import Prior, changes, search

Array = NDArray[np.float64]
Densities = Callable[[Array], Mapping[str, Array]]
"""Logarithms of factors on the noises, (k,) -> sensor -> log density by block, (n,)."""

RECEIVER = "gnss"
"""Sensor whose innovations are those of the ground speed."""
UNTOUCHED = 1e-3
"""Change of the receiver's log density below which a value has nothing to do with the speed."""


@dataclass(frozen=True, kw_only=True)
class Stages:
    """Logarithms of factors on the noises, (k,), as the learnt part has them."""

    sensors: Array
    """With the sensors' noises alone moved."""
    all: Array
    """With the filter's own moved as well."""
    sd: Array
    """NaN where it is not known."""
    flat: NDArray[np.bool_]
    """The likelihood hardly depends on it."""
    starts: tuple[float, ...]
    """Log density that each search reached."""


def total(sums: Mapping[str, Array]) -> Array:
    """Log density of all sensors, by block."""
    return np.asarray(np.sum([*sums.values()], axis=0))


def stages(densities: Densities, noises: Sequence[Noise], seed: int) -> Stages:
    """Noises of sensors by all innovations, then those of the filter by the receiver's alone."""
    known = _once(densities)

    def everything(x: Array) -> Array:
        return total(known(x))

    def receiver(x: Array) -> Array:
        sums = known(x)
        return sums[RECEIVER] if RECEIVER in sums else total(sums)

    prior = Prior(
        sd=np.array([n.prior_sd for n in noises]), bound=np.array([n.bound for n in noises])
    )
    of_sensors = np.array([n.is_factor for n in noises], bool)
    start = np.zeros(len(noises))
    sensors = search(everything, prior, of_sensors, start, paired=False, seed=seed)
    motion = search(receiver, prior, ~of_sensors, sensors.x, paired=True, seed=seed)
    untouched = ~changes(receiver, prior, ~of_sensors, motion.x, UNTOUCHED)
    others = search(everything, prior, ~of_sensors & untouched, motion.x, paired=True, seed=seed)
    done = (sensors, motion, others)
    sd = np.max([np.nan_to_num(f.sd, nan=0.0) for f in done], axis=0)
    return Stages(
        sensors=sensors.x,
        all=others.x,
        sd=np.where(sd > 0.0, sd, np.nan),
        flat=np.all([f.flat for f in done], axis=0),
        starts=tuple(end for f in done for end in f.starts),
    )


def _once(densities: Densities) -> Densities:
    """The densities, computed once for each point."""
    known: dict[bytes, Mapping[str, Array]] = {}

    def looked_up(x: Array) -> Mapping[str, Array]:
        key = np.asarray(x, np.float64).tobytes()
        if key not in known:
            known[key] = densities(x)
        return known[key]

    return looked_up
