"""The GNSS receiver's Doppler velocity, in motion and at rest."""

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
"""Speed below which an antenna is at rest, m/s (assumed: the slowest speed with a defined slip)."""
FADE_S = 0.5
"""Time constant with which the noise of motion decays after a stop, s. Measured: a speed of 12 mm/s
in the median 1 s after the wheels stopped, and nothing above the noise at rest after 3 s."""
NEVER_NS = -(2**62)


def axes(config: Gnss) -> Array:
    """Ratio of the errors of east, north and up to the error of a horizontal axis. Shape (3,)."""
    return np.array([1.0, 1.0, config.vertical_factor])


def motion_left(moved_ns: int, epoch_ns: Stamps, velocity_w: Array) -> tuple[int, Array]:
    """Time of the last motion of the antenna, and the share of motion noise at each epoch.

    The share is 1 while the antenna's horizontal speed is at least 0.05 m/s, then exp(-t / 0.5 s).

    Args:
        moved_ns: time of the last motion before the first epoch.
        epoch_ns: epochs, (n,).
        velocity_w: true velocity of the antenna in world axes [m/s], (n, 3).

    Returns:
        time of the last motion [ns], share of motion noise, (n,).
    """
    moves = velocity_w[:, 0] ** 2 + velocity_w[:, 1] ** 2 >= REST_MPS**2
    seen_ns = np.concatenate([[moved_ns], np.where(moves, epoch_ns, NEVER_NS)])
    last_ns = np.maximum.accumulate(seen_ns)[1:]
    return int(last_ns[-1]), np.exp(-(epoch_ns - last_ns) * 1e-9 / FADE_S)


def velocity(
    config: Gnss, time_s: Array, velocity_w: Array, motion: Array, white: Array, rest: Array
) -> Table:
    """Doppler velocity of the main antenna: columns of the `gnss` stream.

        truth + motion sd white + (1 - motion) min(rest sd, sd) coloured

    It needs no corrections; sd is larger with few satellites. The reported sd is that in motion,
    also at rest: receivers are cautious (assumed).

    Args:
        config: the receiver.
        time_s: time from the start of the run, (n,).
        velocity_w: true velocity of the antenna in world axes [m/s], (n, 3).
        motion: share of motion noise by `motion_left`, (n,).
        white: standard normal draws, (n, 3).
        rest: coloured, of unit sd on the horizontal axes, (n, 3).
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
