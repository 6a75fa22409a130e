"""Engine-order vibration: acceleration that a running engine adds at an accelerometer."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.random import Generator

from twin.sensors.noise import Array
from twin.sensors.sampling import Stamps

FIRING_SHARE = 0.8
"""Share of the rms at the firing order; the rest is at the first order: 0.8^2 + 0.6^2 = 1."""
FIRST_SHARE = 0.6
IDLE_RADPS = 60.0
"""Engine speed below which the vibration falls in proportion to the speed, rad/s."""


@dataclass(frozen=True, kw_only=True)
class Vibration:
    """State of the crankshaft."""

    crank_rad: float
    epoch_ns: Stamps
    """Epoch of the last row, shape (0,) or (1,)."""
    engine_radps: Array
    """Engine speed at that row, shape (0,) or (1,)."""
    phase_rad: Array
    """Phase of each order (firing, first) on each axis, shape (2, 3)."""


def start(rng: Generator) -> Vibration:
    """State at the start of a run: crank angle 0, phases of the axes drawn from `rng`."""
    return Vibration(
        crank_rad=0.0,
        epoch_ns=np.empty(0, np.int64),
        engine_radps=np.empty(0),
        phase_rad=rng.uniform(0.0, 2.0 * pi, (2, 3)),
    )


def shake(
    state: Vibration, epoch_ns: Stamps, engine_radps: Array, rms_mps2: float, firing_order: float
) -> tuple[Vibration, Array]:
    """Acceleration [m/s^2] that the engine adds on each axis, shape (n, 3), on the physics grid.

    crank = integral of the engine's speed (trapezoid)
    a_j   = sqrt(2) rms (0.8 sin(firing_order crank + p_j) + 0.6 sin(crank + q_j))
    """
    grid_ns = np.concatenate([state.epoch_ns, epoch_ns])
    speed = np.concatenate([state.engine_radps, np.asarray(engine_radps, float)])
    pieces = 0.5 * (speed[1:] + speed[:-1]) * (np.diff(grid_ns) * 1e-9)
    turned = np.add.accumulate(np.concatenate([[state.crank_rad], pieces]))
    crank_rad = turned[len(state.epoch_ns) :][: len(epoch_ns)]
    strength = np.sqrt(2.0) * rms_mps2 * np.minimum(np.abs(engine_radps) / IDLE_RADPS, 1.0)
    crank_rad = crank_rad[:, None]
    firing = np.sin(np.mod(firing_order * crank_rad + state.phase_rad[0], 2.0 * pi))
    first = np.sin(np.mod(crank_rad + state.phase_rad[1], 2.0 * pi))
    added = strength[:, None] * (FIRING_SHARE * firing + FIRST_SHARE * first)
    after = Vibration(
        crank_rad=float(turned[-1]),
        epoch_ns=grid_ns[-1:].copy(),
        engine_radps=speed[-1:].copy(),
        phase_rad=state.phase_rad,
    )
    return after, added
