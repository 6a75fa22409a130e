"""The receiver's Doppler velocity, in motion and at rest."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from twin.sensors.fix import active
from twin.sensors.noise import Array
from twin.sensors.sampling import Stamps
from twin.streams import Table

if TYPE_CHECKING:
    from twin.sensors.gnss import Gnss

REST_MPS = 0.05
"""An antenna that is slower than this stands, m/s (assumed: the slowest speed of a slip)."""
FADE_S = 0.5
"""Time in which the noise of motion fades after a stop, s. Measured: a speed of 12 mm/s in the
median 1 s after the wheels stopped, and nothing above the noise of rest after 3 s."""
NEVER_NS = -(2**62)


def axes(config: Gnss) -> Array:
    """Errors of east, north and up over that of a horizontal axis."""
    return np.array([1.0, 1.0, config.vertical_factor])


def motion_left(moved_ns: int, epoch_ns: Stamps, velocity_w: Array) -> tuple[int, Array]:
    """When the antenna moved last, and how much of motion's noise is left, shape (n,).

    1 while the antenna's horizontal speed is at least 0.05 m/s, and exp(-t / 0.5 s) after it.
    """
    moves = velocity_w[:, 0] ** 2 + velocity_w[:, 1] ** 2 >= REST_MPS**2
    seen_ns = np.concatenate([[moved_ns], np.where(moves, epoch_ns, NEVER_NS)])
    last_ns = np.maximum.accumulate(seen_ns)[1:]
    return int(last_ns[-1]), np.exp(-(epoch_ns - last_ns) * 1e-9 / FADE_S)


def velocity(
    config: Gnss, time_s: Array, velocity_w: Array, motion: Array, white: Array, rest: Array
) -> Table:
    """Doppler velocity of the main antenna; needs no corrections, suffers with few satellites.

        truth + motion sd white + (1 - motion) min(rest sd, sd) coloured

    The reported sd is that of motion, also at rest: receivers are cautious (assumed).
    """
    masked = active(config.outages, ("mask",), time_s)
    factor = np.where(masked, config.masked_velocity_factor, 1.0)
    factor = np.where(active(config.outages, ("block",), time_s), np.nan, factor)
    sd_mps = config.velocity_sd_mps * factor
    rest_sd_mps = min(config.rest_velocity_sd_mps, config.velocity_sd_mps) * factor
    moving = (motion * sd_mps)[:, None] * axes(config) * white
    measured = velocity_w + (moving + ((1.0 - motion) * rest_sd_mps)[:, None] * rest)
    return {
        "v_east_mps": measured[:, 0],
        "v_north_mps": measured[:, 1],
        "v_up_mps": measured[:, 2],
        "velocity_sd_mps": sd_mps,
    }
