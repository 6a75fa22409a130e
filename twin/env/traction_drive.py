"""The motors of WheelSlip-v1: their lag, a speed loop around each, and a draft that changes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from twin.compute.compiled import law
from twin.physics import block
from twin.physics.block import Field
from twin.physics.ground import random_field
from twin.simulation.controls import within
from twin.simulation.records import Records

Array = NDArray[np.float64]

LAG_S = 0.05
"""Time constant of a motor's torque [s]; assumed."""
FASTEST_RADPS = 12.0
"""Wheel speed that a speed action of 1 asks for: about 2.4 m/s [rad/s]."""
SPEED_GAIN_SPRAD, SPEED_GAIN_PRAD = 0.15, 0.6
"""Gains of the speed loop: torque action per error, and per error and second; assumed."""
DRAFT_CV, DRAFT_LENGTH_M = 0.25, 4.0
"""Variation of the draft with place, and the distance of independent values [m]; assumed."""
LEAST_SHARE = 0.2
"""Draft of the lightest places over the mean."""
DRAFT_SEED = 404
"""Added to the field's seed, so that the draft varies by itself."""


@law
def drive_motors(
    asked: Array, spin: Array, speed: bool, held: Array, torques: Array, dt_s: float
) -> None:
    """Torques of both motors, as shares of the largest, one control step on.

        torque:  u = action
        speed:   e = 12 rad/s (action + 1) / 2 - w        u = clip(k e + held, -1, 1)
        torque' = torque + (u - torque) (1 - exp(-dt / 0.05 s))

    `held`, the integral of the error, stands still where u is at its limit.

    Args:
        asked: the actions (nsim, 2).
        spin: speeds of the wheels (nsim, 2) [rad/s].
        speed: whether the actions are speeds.
        held: read and written (nsim, 2).
        torques: read and written (nsim, 2).
        dt_s: the interval.
    """
    share = 1.0 - math.exp(-dt_s / LAG_S)
    for i in range(len(asked)):
        for k in range(2):
            wanted = asked[i, k]
            if speed:
                error = 0.5 * (wanted + 1.0) * FASTEST_RADPS - spin[i, k]
                free = SPEED_GAIN_SPRAD * error + held[i, k]
                wanted = within(-1.0, free, 1.0)
                if wanted == free:
                    held[i, k] += SPEED_GAIN_PRAD * error * dt_s
            torques[i, k] += share * (wanted - torques[i, k])


@law
def local_draft(blocks: Array, seen: Records, mean: Array, here: Array) -> None:
    """F of D497 where each implement is.

    F = F_mean max(0.2, 1 + 0.25 f(s, t)), f a random field of mean 0 and variance 1

    Args:
        blocks: the parameter blocks (nsim, size).
        seen: Observations of the drivers (nsim,).
        mean: F_mean (nsim,).
        here: written (nsim,).
    """
    for i in range(len(mean)):
        seed = blocks[i, block.FIELD + Field.SEED] + DRAFT_SEED
        s_m = seen[i].along_m + blocks[i, block.FIELD + Field.ORIGIN_S_M]
        t_m = seen[i].left_m + blocks[i, block.FIELD + Field.ORIGIN_T_M]
        varied = 1.0 + DRAFT_CV * random_field(seed, s_m, t_m, DRAFT_LENGTH_M)
        here[i] = mean[i] * max(LEAST_SHARE, varied)
