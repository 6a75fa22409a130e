"""Tracks of the IMA-PKF paper's simulation, and the disturbances in them, as functions of time.

The tracks are not printed; these are three kinds that a ploughing tractor might leave.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

Array = NDArray[np.float64]

DURATION_S = 30.0
CENTRES_S, CENTRE_SD_S = (6.0, 10.0, 15.0, 20.0, 25.0), 0.5
"""Means of the disturbances' times; their spread is not printed."""
AMPLITUDE_MPS, FREQUENCY_HZ, LENGTH_S = (0.4, 0.8), (4.5, 5.5), 0.2
RIPPLE_HZ = {"smooth": (), "medium": (0.7, 1.2), "rough": (0.7, 1.2, 1.9, 2.5)}
BURSTS, BURST_RISE_S = 8, 0.15
"""Bursts of slip on a rough track."""

Track = Literal["smooth", "medium", "rough"]


def track(kind: Track, rng: Generator) -> tuple[Callable[[Array], Array], Callable[[Array], Array]]:
    """Wheel speed 1.3-2.9 m/s and slip .06-.29 as functions of time."""
    phase = rng.uniform(0.0, 2.0 * np.pi, 4)
    ripples = [(hz, *rng.uniform(0.0, 2.0 * np.pi, 2)) for hz in RIPPLE_HZ[kind]]
    at = np.sort(rng.uniform(2.0, DURATION_S - 2.0, BURSTS)) if kind == "rough" else np.empty(0)

    def wheel(t: Array) -> Array:
        slow = 0.45 * np.sin(0.5 * t + phase[0]) + 0.2 * np.sin(1.4 * t + phase[1])
        ripple = sum(0.05 / hz * np.sin(2 * np.pi * hz * t + a) for hz, a, _ in ripples)
        return np.asarray(2.1 + slow + ripple)

    def slip(t: Array) -> Array:
        slow = 0.07 * np.sin(0.6 * t + phase[2]) + 0.03 * np.sin(1.3 * t + phase[3])
        ripple = sum(0.01 / hz * np.sin(2 * np.pi * hz * t + b) for hz, _, b in ripples)
        bursts = sum(0.04 * np.exp(-0.5 * ((t - when) / BURST_RISE_S) ** 2) for when in at)
        return np.asarray(0.175 + slow + ripple + bursts)

    return wheel, slip


def disturbances(kind: str, rng: Generator) -> Callable[[Array], Array]:
    """Sum of the trial's five pulses as a function of time [m/s].

    lobe:   A sin(pi f tau),  0 <= tau < 1/f    one half-sine, 0.18-0.22 s long
    cycle:  A sin(2 pi f tau),  0 <= tau < 0.2 s
    """
    starts = rng.normal(CENTRES_S, CENTRE_SD_S)
    amplitudes = rng.uniform(*AMPLITUDE_MPS, len(starts)) * rng.choice((-1.0, 1.0), len(starts))
    frequencies = rng.uniform(*FREQUENCY_HZ, len(starts))

    def pulses(t: Array) -> Array:
        total = np.zeros_like(t)
        for start, amplitude, hz in zip(starts, amplitudes, frequencies, strict=True):
            tau = t - start
            if kind == "lobe":
                wave, length = np.sin(np.pi * hz * tau), 1.0 / hz
            else:
                wave, length = np.sin(2.0 * np.pi * hz * tau), LENGTH_S
            total += amplitude * wave * ((tau >= 0.0) & (tau < length))
        return total if kind != "none" else np.zeros_like(t)

    return pulses


def slope(f: Callable[[Array], Array], t: Array) -> Array:
    """Derivative by central differences [1/s of f]."""
    return np.asarray((f(t + 1e-4) - f(t - 1e-4)) / 2e-4)
