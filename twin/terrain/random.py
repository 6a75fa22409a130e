"""Ground made from a seed: roughness with the spectrum of ISO 8608, and patches of another soil.

Both are sums of waves on a grid (inverse Fourier transforms), so they repeat without a seam.
"""

from __future__ import annotations

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from twin.scenario.field import ROUGHNESS

Array = NDArray[np.float64]

CELL_M = 0.1
"""Distance between nodes of the heights [m]."""
LONGEST_M, SHORTEST_M = 50.0, 0.8
"""Longest and shortest waves [m]: no hills, and none that vanishes under a tyre's contact."""
BORDER = 0.1
"""Share of itself over which the border of a patch passes from one soil to the other."""


def rough_heights(roughness_class: str, shape: tuple[int, int], rng: Generator) -> Array:
    """Heights whose spectrum along any line is that of an ISO 8608 class [m].

    G_d(n) = G_d(n0) (n / n0)**-2       n0 = 0.1 cycles/m, between the longest wave and the shortest

    An isotropic surface with the density Phi(k) = G_d(n0) n0**2 / (4 k**3) over both wave numbers
    has it: 2 Phi integrated over the wave number across. Waves are made larger by what the splines
    over the nodes take from them.

    Args:
        roughness_class: one of twin.scenario.ROUGHNESS.
        shape: rows and columns, CELL_M apart.
        rng: phases and amplitudes.
    """
    across, along = np.fft.fftfreq(shape[0], CELL_M), np.fft.rfftfreq(shape[1], CELL_M)  # cycles/m
    k = np.hypot(across[:, None], along[None, :])
    within = (k >= 1.0 / LONGEST_M) & (k <= 1.0 / SHORTEST_M)
    scale = ROUGHNESS[roughness_class] * 0.1**2 / 4.0
    density = np.where(within, scale / np.where(within, k, 1.0) ** 3, 0.0)
    lost = (np.sinc(across * CELL_M)[:, None] * np.sinc(along * CELL_M)[None, :]) ** 3
    return _waves(np.sqrt(density) / lost, shape, CELL_M, rng)


def mixture(
    share: float, length_m: float, shape: tuple[int, int], cell_m: float, rng: Generator
) -> Array:
    """Patches of another soil: 1 inside, 0 outside, a border between; their mean is `share`.

    Where a smooth random surface exceeds its quantile.

    Args:
        share: share of the area that the other soil covers.
        length_m: size of a patch: correlation length of the surface [m].
        shape, cell_m: of the grid.
        rng: of the surface.
    """
    across, along = np.fft.fftfreq(shape[0], cell_m), np.fft.rfftfreq(shape[1], cell_m)
    square = across[:, None] ** 2 + along[None, :] ** 2
    surface = _waves(np.exp(-(np.pi**2) * square * (0.5 * length_m) ** 2), shape, cell_m, rng)
    level = np.quantile(surface, 1.0 - share)
    return np.asarray(np.clip((surface - level) / (BORDER * surface.std()) + 0.5, 0.0, 1.0))


def _waves(amplitude: Array, shape: tuple[int, int], cell_m: float, rng: Generator) -> Array:
    """A random surface whose two-sided density over wave numbers is `amplitude`**2."""
    white = np.fft.rfft2(rng.standard_normal(shape))  # its density is cell_m**2 everywhere
    whole = np.fft.irfft2(white * amplitude / cell_m, s=shape, norm="forward")
    return np.asarray(whole * (1.0 / (shape[0] * shape[1])))
