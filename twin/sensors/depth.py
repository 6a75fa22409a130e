"""Working depth: a laser range finder on the plough frame, and an inclinometer beside it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import radians
from typing import TYPE_CHECKING, Annotated

import numpy as np
from numpy.random import Generator

from twin.sensors.checks import Range, check_fields
from twin.sensors.noise import GaussMarkov, advance, gauss_markov, generator
from twin.sensors.sampling import Reader, arrivals, nothing, read, reader
from twin.streams import Table

if TYPE_CHECKING:
    from twin.trajectory.trajectory import Trajectory


@dataclass(frozen=True, kw_only=True)
class Depth:
    """Laser and inclinometer; the data sheet's values, then the true errors."""

    rate_hz: Annotated[float, Range(1, 500)] = 50.0
    """Output rate, Hz."""
    laser_sd_m: Annotated[float, Range(0, 0.1)] = 0.003
    """White noise of the range, m; 1 to 3 mm for industrial triangulation and time of flight."""
    clod_sd_m: Annotated[float, Range(0, 0.1)] = 0.004
    """sd of the surface under the laser spot about the mean ground, m; makes 5-10 mm of depth error
    together with the inclinometer."""
    clod_length_m: Annotated[float, Range(1e-3, 10)] = 0.1
    """Correlation length of that surface along the path, m; assumed, the size of a clod."""
    inclinometer_sd_rad: Annotated[float, Range(0, 0.1)] = radians(0.2)
    """White noise of the inclination, rad; 0.1-0.3 deg."""
    latency_s: Annotated[float, Range(0, 1)] = 0.005
    """Time from measuring to arrival, s."""
    latency_jitter_s: Annotated[float, Range(0, 0.1)] = 0.0005
    """Random part of the latency: this times |N(0, 1)|, s."""
    laser_bias_m: Annotated[float, Range(-0.5, 0.5)] = 0.0
    """True error of the range, m."""
    inclination_bias_rad: Annotated[float, Range(-0.2, 0.2)] = 0.0
    """True error of the inclinometer's mounting, rad."""

    def __post_init__(self) -> None:
        check_fields("depth", self)


@dataclass(frozen=True, kw_only=True)
class DepthState:
    """State of the depth sensor."""

    reader: Reader
    arrival_ns: int
    clods: GaussMarkov
    laser: Generator
    inclinometer: Generator
    latency: Generator


def init(config: Depth, seed: int, start_ns: int) -> DepthState:
    """State of the depth sensor at the start of a run."""
    return DepthState(
        reader=reader(start_ns, config.rate_hz),
        arrival_ns=start_ns,
        clods=gauss_markov(
            generator(seed, "depth", "clods"), config.clod_sd_m, config.clod_length_m
        ),
        laser=generator(seed, "depth", "laser"),
        inclinometer=generator(seed, "depth", "inclinometer"),
        latency=generator(seed, "depth", "latency"),
    )


def sample(config: Depth, state: DepthState, chunk: Trajectory) -> tuple[DepthState, Table]:
    """Samples of laser range and inclination in the chunk.

        laser       = true range + bias + clods(path) + white
        inclination = true inclination + bias + white

    clods is a Gauss-Markov process along the path: it is constant while the machine stands.
    """
    names = ("laser_m", "inclination_rad", "velocity_w")
    position, epoch_ns, at = read(state.reader, chunk, names)
    if not len(epoch_ns):
        return replace(state, reader=position), nothing("laser_m", "inclination_rad")
    count = len(epoch_ns)
    east, north = at["velocity_w"][:, 0], at["velocity_w"][:, 1]
    driven_m = np.sqrt(east * east + north * north) / config.rate_hz
    clods, clod_m = advance(state.clods, driven_m)
    laser_m = at["laser_m"] + config.laser_bias_m + clod_m[:, 0]
    laser_m = laser_m + config.laser_sd_m * state.laser.standard_normal(count)
    tilt_noise = config.inclinometer_sd_rad * state.inclinometer.standard_normal(count)
    scatter = np.abs(state.latency.standard_normal(count))
    delay_s = config.latency_s + config.latency_jitter_s * scatter
    last_ns, arrival_ns = arrivals(state.arrival_ns, epoch_ns, delay_s)
    table: Table = {
        "epoch_ns": epoch_ns,
        "arrival_ns": arrival_ns,
        "laser_m": laser_m,
        "inclination_rad": at["inclination_rad"] + config.inclination_bias_rad + tilt_noise,
    }
    return replace(state, reader=position, arrival_ns=last_ns, clods=clods), table
