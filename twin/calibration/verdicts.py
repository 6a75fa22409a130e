"""Verdict of a log on each parameter: identified, weak or not identified."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from twin.calibration.fitting import Fit
from twin.calibration.known import known

IDENTIFIED, WEAK, NOT = "identified", "weak", "not identified"
MOST_IDENTIFIED, MOST_WEAK = 1.0 / 3.0, 0.9
"""Posterior over prior sd up to which a parameter is identified, and weak."""
LEAST_SURE = 0.15
"""One that is known no better than this, relative, is weak whatever the prior was."""
TOGETHER = 0.8
"""Correlation from which only the combination of two is known."""
NORMAL_95 = 1.96
FAR = 3.0
"""A parameter so many prior sd from what was believed is improbable."""


@dataclass(frozen=True)
class Told:
    """A parameter with its 95 % interval."""

    name: str
    unit: str
    value: float
    low: float
    high: float
    prior: float
    prior_low: float
    prior_high: float
    verdict: str
    settles: str
    at_bound: bool


def told(fit: Fit) -> list[Told]:
    """What was found of every parameter."""
    out = []
    sds = np.sqrt(np.diag(fit.cov))
    for i, name in enumerate(fit.prior.names):
        u, sd, mean, believed = fit.u[i], sds[i], fit.prior.mean[i], fit.prior.sd[i]
        share = sd / believed
        verdict = IDENTIFIED if share <= MOST_IDENTIFIED else WEAK if share <= MOST_WEAK else NOT
        if verdict == IDENTIFIED and sd > LEAST_SURE:
            verdict = WEAK
        ends = np.exp([u - NORMAL_95 * sd, u + NORMAL_95 * sd])
        before = np.exp([mean - NORMAL_95 * believed, mean + NORMAL_95 * believed])
        out.append(Told(
            name, known(name).unit, float(np.exp(u)), float(ends[0]), float(ends[1]),
            float(np.exp(mean)), float(before[0]), float(before[1]), verdict, known(name).settles,
            bool(fit.at_bound[i]),
        ))  # fmt: skip
    return out


def together(fit: Fit) -> list[str]:
    """Pairs of which the log gives only the combination, in words."""
    sds = np.sqrt(np.diag(fit.cov))
    correlation = fit.cov / np.outer(sds, sds)
    found = []
    for i, j in zip(*np.triu_indices(len(sds), 1), strict=True):
        if abs(correlation[i, j]) >= TOGETHER:
            one, other = (known(fit.prior.names[k]) for k in (i, j))
            found.append(
                f"{one.about} and {other.about} only together: correlation {correlation[i, j]:+.2f}"
            )
    return found


def misfit_note(fit: Fit) -> str:
    """What is said of residuals that are larger than the noise; empty where they are not."""
    if fit.misfit <= 1.3:
        return ""
    return (
        f"the model misses the log by {fit.misfit:.1f} times its noise: something else is in the "
        "log, or the soil law is another; the intervals are widened by as much"
    )


def far_notes(fit: Fit) -> list[str]:
    """What is said of parameters that are far from what was believed before."""
    away = (fit.u - fit.prior.mean) / fit.prior.sd
    return [
        f"{name} is {abs(z):.1f} sd from what was believed: the file is of another machine, or the "
        "soil law is another, and the parameter bends to it"
        for name, z in zip(fit.prior.names, away, strict=True)
        if abs(z) > FAR and not name.startswith("log.")
    ]
