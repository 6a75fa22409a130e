"""Random terms of the sensors: one generator each, so results do not depend on the chunks."""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator, SeedSequence
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def generator(seed: int, sensor: str, term: str) -> Generator:
    """The random generator of one noise term, independent of the generators of all other terms.

    Keys are hashes of the names, so a new term does not change the others.
    """
    key = (zlib.crc32(sensor.encode()), zlib.crc32(term.encode()))
    return np.random.default_rng(SeedSequence(seed, spawn_key=key))


@dataclass(frozen=True, kw_only=True)
class GaussMarkov:
    """A first-order Gauss-Markov process of m components, in time or along a path."""

    sd: Array
    """Stationary standard deviation, shape (m,)."""
    scale: float
    """Correlation time [s] or correlation length [m]."""
    last: Array
    """Present value, shape (m,)."""
    rng: Generator


def gauss_markov(rng: Generator, sd: ArrayLike, scale: float) -> GaussMarkov:
    """A process that starts in its stationary distribution."""
    spread = np.atleast_1d(np.asarray(sd, float))
    last = spread * rng.standard_normal(len(spread))
    return GaussMarkov(sd=spread, scale=scale, last=last, rng=rng)


def advance(process: GaussMarkov, step: Array) -> tuple[GaussMarkov, Array]:
    """The process after each step.

        phi_k = exp(-step_k / scale)
        x_k   = phi_k x_{k-1} + sd sqrt(1 - phi_k^2) w_k

    Exact for any step, so the statistics do not depend on the sampling rate.

    Args:
        process: the process at the last sample before.
        step: elapsed time [s] or distance [m] before each sample, shape (n,).

    Returns:
        The process at the last sample, and its values, shape (n, m).
    """
    phi = np.exp(-step / process.scale)
    white = process.rng.standard_normal((len(step), len(process.sd)))
    drive = np.sqrt(1.0 - phi * phi)[:, None] * process.sd * white  # (n, m)
    values = np.empty_like(drive)
    for j, last in enumerate(process.last.tolist()):
        values[:, j] = _recurrence(last, phi.tolist(), drive[:, j].tolist())
    if len(values):
        last = values[-1].copy()
        process = GaussMarkov(sd=process.sd, scale=process.scale, last=last, rng=process.rng)
    return process, values


def _recurrence(x: float, phi: list[float], drive: list[float]) -> list[float]:
    out = []
    for p, w in zip(phi, drive, strict=True):
        x = p * x + w
        out.append(x)
    return out


@dataclass(frozen=True, kw_only=True)
class Smooth:
    """A Gauss-Markov process after a low-pass with the same time constant: a smooth curve."""

    raw: GaussMarkov
    last: Array
    """Present value of the low-pass, shape (m,)."""


def smooth(rng: Generator, sd: ArrayLike, scale: float) -> Smooth:
    """A process that starts in its stationary distribution."""
    raw = gauss_markov(rng, sd, scale)
    own = raw.sd * rng.standard_normal(len(raw.sd))
    return Smooth(raw=raw, last=0.5 * (raw.last + own))


def advance_smooth(process: Smooth, step: Array) -> tuple[Smooth, Array]:
    """The process after each of n equal steps `step` (n,).

        y_k = phi y_{k-1} + (1 - phi) u_k,   phi = exp(-step / scale),   u: `advance`
        x_k = y_k (1 + phi) / sqrt(1 + phi^2)

    x has the standard deviation of u, and for steps far below the scale T the correlation
    (1 + t/T) exp(-t/T): in a short time it changes in proportion to t, where u does by sqrt(t).

    Returns:
        The process at the last sample, and its values, shape (n, m).
    """
    raw, values = advance(process.raw, step)
    phi = np.exp(-step / process.raw.scale)
    drive = (1.0 - phi)[:, None] * values
    for j, last in enumerate(process.last.tolist()):
        values[:, j] = _recurrence(last, phi.tolist(), drive[:, j].tolist())
    last = values[-1].copy() if len(values) else process.last
    return Smooth(raw=raw, last=last), ((1.0 + phi) / np.sqrt(1.0 + phi * phi))[:, None] * values
