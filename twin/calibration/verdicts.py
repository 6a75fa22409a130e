"""What a log tells of each parameter, and what it tells only of several together."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from twin.calibration.fitting import Fit
from twin.calibration.known import known

IDENTIFIED, WEAK, NOT = "identified", "weak", "not identified from this log"
MOST_OF_PRIOR = {IDENTIFIED: 1.0 / 3.0, WEAK: 0.8}
"""A verdict -> posterior over prior sd, at most."""
TOGETHER = 0.8
"""Two parameters whose correlation is larger are only told together."""
SD_95 = 1.96


@dataclass(frozen=True, kw_only=True)
class Found:
    """One parameter."""

    name: str
    value: float
    low: float
    """The 95 % interval, exp(u -+ 1.96 sd)."""
    high: float
    verdict: str
    unit: str
    prior: float
    prior_low: float
    prior_high: float
    grade: str
    """Of the prior."""
    at_bound: bool
    settles: str
    """The measurement that would tell it, where the log does not."""


@dataclass(frozen=True, kw_only=True)
class Together:
    """Two parameters that the log tells only together."""

    names: tuple[str, str]
    correlation: float

    def __str__(self) -> str:
        one, other = (known(name).about for name in self.names)
        settles = known(self.names[0]).settles
        return (
            f"{one} and {other} only together: correlation {self.correlation:+.2f}; {settles} "
            "would part them"
        )


def found(fit: Fit) -> tuple[Found, ...]:
    """The verdict on each parameter of a fit."""
    prior, sd = fit.prior, np.sqrt(np.diag(fit.cov))
    out = []
    for i, name in enumerate(prior.names):
        about = known(name)
        out.append(
            Found(
                name=name,
                value=math.exp(fit.u[i]),
                unit=about.unit,
                low=math.exp(fit.u[i] - SD_95 * sd[i]),
                high=math.exp(fit.u[i] + SD_95 * sd[i]),
                verdict=verdict(float(sd[i] / prior.sd[i])),
                prior=math.exp(prior.mean[i]),
                prior_low=math.exp(prior.mean[i] - SD_95 * prior.sd[i]),
                prior_high=math.exp(prior.mean[i] + SD_95 * prior.sd[i]),
                grade=prior.grades[i],
                at_bound=bool(fit.at_bound[i]),
                settles=about.settles,
            )
        )
    return tuple(out)


def verdict(of_prior: float) -> str:
    """The verdict on a posterior sd over the prior's."""
    return next((v for v, most in MOST_OF_PRIOR.items() if of_prior <= most), NOT)


def together(fit: Fit) -> Iterator[Together]:
    """Pairs of parameters that are only told together, the strongest first."""
    sd = np.sqrt(np.diag(fit.cov))
    correlation = fit.cov / np.outer(sd, sd)
    pairs = [(i, j) for i in range(len(sd)) for j in range(i)]
    for i, j in sorted(pairs, key=lambda pair: -abs(correlation[pair])):
        if abs(correlation[i, j]) > TOGETHER:
            names = (fit.prior.names[i], fit.prior.names[j])
            yield Together(names=names, correlation=float(correlation[i, j]))
