"""The core of a calibration: parameters from residuals by Gauss-Newton, and their posterior.

    minimise  sum rho(e(u)) + sum ((u - m) / s)**2 / 2        low <= u <= high

with the logarithms u of the parameters, whitened residuals e, Huber's rho, and prior means m and sd
s. A step needs the residuals at u and beside it in each parameter: all at once, side by side. The
posterior is Laplace's: normal about the minimum, with the inverse of J' W J + 1/s**2.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from twin.calibration.noise import Noise, estimated, huber_weights, known, whitened
from twin.errors import TwinError

Array = NDArray[np.float64]

STEP = 1e-3
"""Difference of a logarithm over which a slope is taken."""
DAMPINGS = (0.0, 0.03, 1.0, 30.0)
"""Levenberg's dampings that are tried side by side."""
MOST_STEPS, ENOUGH = 12, 0.03
"""Steps at most, and the step over the posterior sd that ends them."""
ROUNDS = 4
"""So often the noise is estimated again from what the fit leaves."""
START_SHARE = 1.0
"""Sd of a random start over the prior's."""
NEAR = 1e-6
"""A parameter so near to its bound has hit it."""


class NotFitted(TwinError, ArithmeticError):
    """No start led to finite residuals."""


@dataclass(frozen=True)
class Prior:
    """What is believed before the log, by logarithms. Shapes (p,)."""

    names: tuple[str, ...]
    mean: Array
    sd: Array
    low: Array
    high: Array
    grades: tuple[str, ...]


class Model(Protocol):
    """What predicts the measurements of the rows that are fitted."""

    @property
    def measured(self) -> Array:
        """Shape (n, c)."""
        ...

    @property
    def time_s(self) -> Array:
        """Shape (n,)."""
        ...

    @property
    def covariance(self) -> Array | None:
        """Of each row's noise, (n, c, c); None where it has to be estimated."""
        ...

    @property
    def floor(self) -> Array:
        """Least sd of each channel, (c,)."""
        ...

    def foretold(self, values: Array) -> Array:
        """The channels in all rows for parameters (k, p): shape (k, n, c)."""
        ...


@dataclass(frozen=True)
class Fit:
    """What was found."""

    prior: Prior
    u: Array
    """Logarithms of the parameters at the minimum."""
    cov: Array
    """Of these logarithms, (p, p)."""
    noise: Noise
    residual: Array
    """Measured less predicted, (n, c)."""
    white: Array
    """The same, whitened."""
    slopes: Array
    """Change of the predicted channels with the logarithms, (n, c, p)."""
    cost: float
    misfit: float
    """Root mean square of the whitened residuals, by the noise that was measured."""
    costs: tuple[float, ...]
    """The minimum that each start found."""
    starts: Array
    """Where each of them ended. Shape (starts, p)."""

    @property
    def values(self) -> dict[str, float]:
        """The parameters at the minimum."""
        return dict(zip(self.prior.names, np.exp(self.u).tolist(), strict=True))

    @property
    def at_bound(self) -> NDArray[np.bool_]:
        """Which parameters have hit a bound."""
        near = np.minimum(self.u - self.prior.low, self.prior.high - self.u)
        return np.asarray(near < NEAR)


Remember = Callable[[str, Callable[[], Array]], Array]
"""Gives what was found under a key before a calibration was killed, or finds it."""


def fit(
    model: Model,
    prior: Prior,
    *,
    seed: int = 0,
    starts: int = 3,
    told: Callable[[str], None] = lambda what: None,
    remember: Remember = lambda key, find: find(),
) -> Fit:
    """The parameters that explain a log.

    Args:
        model: predicts what was measured.
        prior: what is believed before.
        seed: of the random starts.
        starts: how many; the first is the prior's mean.
        told: called with what is being done.
        remember: given (key, find), returns what is stored under `key`, else what `find()` gives,
            and stores it: the end of each start and of each round of the noise.

    Raises:
        NotFitted: no start gave finite residuals.
    """  # fmt: skip
    generator = np.random.default_rng(seed)
    spread = START_SHARE * prior.sd * generator.standard_normal((starts, len(prior.mean)))
    spread[0] = 0.0
    noise = _first_noise(model, prior)
    ends, costs = [], []
    for i, at in enumerate(np.clip(prior.mean + spread, prior.low, prior.high)):
        told(f"start {i + 1} of {starts}")
        end = remember(f"start-{i}", lambda at=at: _end(model, prior, noise, at))  # type: ignore[misc]
        ends.append(end[:-1])
        costs.append(float(end[-1]))
    if not np.isfinite(costs).any():
        raise NotFitted("no start of the calibration gave finite residuals")
    u = ends[int(np.nanargmin(costs))]
    for round_ in range(ROUNDS if model.covariance is None else 0):
        told(f"noise, round {round_ + 1}")
        residual = model.measured - model.foretold(np.exp(u)[None])[0]
        noise = estimated(residual, model.time_s, model.floor)
        u = remember(f"round-{round_}", lambda u=u, n=noise: _end(model, prior, n, u))[:-1]  # type: ignore[misc]
    return _posterior(model, prior, noise, u, costs, ends)


def _first_noise(model: Model, prior: Prior) -> Noise:
    if model.covariance is not None:
        return known(model.covariance)
    residual = model.measured - model.foretold(np.exp(prior.mean)[None])[0]
    return replace(estimated(residual, model.time_s, model.floor), tau_s=0.0)


def _end(model: Model, prior: Prior, noise: Noise, u: Array) -> Array:
    """Where Gauss-Newton ends, and the cost there."""
    cost = np.inf
    for _ in range(MOST_STEPS):
        foretold, slopes = _with_slopes(model, u, prior)
        weight, cost = _weights(model, prior, noise, foretold, u)
        if not np.isfinite(cost):
            return np.append(u, np.inf)
        matrix, push = _normal(model, prior, noise, foretold, slopes, u, weight)
        tried = np.array([_step(prior, matrix, push, u, d) for d in DAMPINGS])
        reached = np.array(
            [
                _weights(model, prior, noise, f, t)[1]
                for f, t in zip(model.foretold(np.exp(tried)), tried, strict=True)
            ]
        )
        best = int(np.argmin(np.where(np.isfinite(reached), reached, np.inf)))
        if not reached[best] < cost:
            break
        moved = np.abs(tried[best] - u) / np.sqrt(np.diag(np.linalg.inv(matrix)))
        u, cost = tried[best], float(reached[best])
        if moved.max() < ENOUGH:
            break
    return np.append(u, cost)


def beside(u: Array, sign: Array | float = 1.0) -> Array:
    """Parameters at u and a step from it in each, by logarithms: shape (1 + p, p)."""
    return np.vstack([u[None], u + np.diag(np.broadcast_to(sign, u.shape) * STEP)])


def _with_slopes(model: Model, u: Array, prior: Prior) -> tuple[Array, Array]:
    """Predicted channels (n, c), and their change with each parameter (n, c, p)."""
    sign = np.where(u + STEP > prior.high, -1.0, 1.0)
    found = model.foretold(np.exp(beside(u, sign)))
    slopes = (found[1:] - found[0]) / (sign * STEP)[:, None, None]
    return found[0], np.moveaxis(slopes, 0, -1)


def _weights(
    model: Model, prior: Prior, noise: Noise, foretold: Array, u: Array
) -> tuple[Array, float]:
    """Huber's weights, and the cost."""
    white = whitened(noise, model.measured - foretold, model.time_s)
    weight = huber_weights(white)
    size = np.abs(white)
    rho = np.where(weight >= 1.0, 0.5 * white**2, size * 2.0 - 2.0)
    return weight, float(rho.sum() + 0.5 * np.sum(((u - prior.mean) / prior.sd) ** 2))


def _normal(
    model: Model, prior: Prior, noise: Noise, foretold: Array, slopes: Array, u: Array,
    weight: Array,
) -> tuple[Array, Array]:  # fmt: skip
    """Matrix and right-hand side of Gauss-Newton's equations."""
    white = weight * whitened(noise, model.measured - foretold, model.time_s)
    moved = whitened(noise, np.moveaxis(slopes, -1, 0), model.time_s) * weight
    jacobian = moved.reshape(len(u), -1)
    matrix = jacobian @ jacobian.T + np.diag(prior.sd**-2.0)
    return matrix, jacobian @ white.ravel() - (u - prior.mean) / prior.sd**2


def _step(prior: Prior, matrix: Array, push: Array, u: Array, damping: float) -> Array:
    """A damped step within the bounds; what would leave them is held, and the rest solved again."""
    free = np.ones(len(u), np.bool_)
    new = u.copy()
    for _ in range(len(u)):
        if not free.any():
            break
        held = np.flatnonzero(~free)
        part = matrix[np.ix_(free, free)] + damping * np.diag(prior.sd[free] ** -2.0)
        right = push[free] - matrix[np.ix_(free, held)] @ (new[held] - u[held])
        new[free] = u[free] + np.linalg.solve(part, right)
        beyond = free & ((new < prior.low) | (new > prior.high))
        new = np.clip(new, prior.low, prior.high)
        if not beyond.any():
            break
        free &= ~beyond
    return new


def _posterior(
    model: Model, prior: Prior, noise: Noise, u: Array, costs: Sequence[float],
    ends: Sequence[Array],
) -> Fit:  # fmt: skip
    foretold, slopes = _with_slopes(model, u, prior)
    residual = model.measured - foretold
    white = whitened(noise, residual, model.time_s)
    bent = huber_weights(white) * white
    freedom = max(bent.size - len(u), 1)
    misfit = float(np.sqrt(np.sum(bent**2) / freedom))
    if model.covariance is not None and misfit > 1.0:  # what the model cannot explain is noise, too
        noise = noise.scaled(misfit)
    weight, cost = _weights(model, prior, noise, foretold, u)
    matrix, _ = _normal(model, prior, noise, foretold, slopes, u, weight)
    cov = np.asarray(np.linalg.inv(matrix), np.float64)
    return Fit(
        prior=prior, u=u, cov=cov, noise=noise, residual=residual, white=white,
        slopes=slopes, cost=cost, misfit=misfit, costs=tuple(costs), starts=np.array(ends),
    )  # fmt: skip
