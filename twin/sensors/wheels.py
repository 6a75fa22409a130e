"""Wheel encoders: cumulative ticks of quadrature-decoded incremental encoders."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated

import numpy as np
from numpy.random import Generator

from twin.sensors.checks import Range, check_fields
from twin.sensors.noise import Array, generator
from twin.sensors.sampling import Reader, arrivals, nothing, read, reader
from twin.streams import WHEELS, Table

if TYPE_CHECKING:
    from twin.trajectory.trajectory import Trajectory

TICKS = tuple(f"ticks_{wheel}" for wheel in WHEELS)


@dataclass(frozen=True, kw_only=True)
class Wheels:
    """An encoder on each wheel; the data sheet's values, then the true errors."""

    rate_hz: Annotated[float, Range(1, 500)] = 50.0
    """Rate at which the counters are read, Hz."""
    lines: Annotated[int, Range(1, 100_000)] = 1000
    """Lines per turn; 10 ... 2000 for an Omron E6B2-CWZ6C."""
    decoding: Annotated[int, Range(1, 4)] = 4
    """Counts per line: 1, 2 or 4 edges of the two channels."""
    latency_s: Annotated[float, Range(0, 1)] = 0.005
    """Time from reading to arrival, s."""
    latency_jitter_s: Annotated[float, Range(0, 0.1)] = 0.0005
    """Random part of the latency: this times |N(0, 1)|, s."""
    read_jitter_s: Annotated[float, Range(0, 5e-3)] = 20e-6
    """sd of the true time of reading about the stated epoch, s."""
    radius_error: Annotated[tuple[float, float, float, float], Range(-0.2, 0.2)] = (
        0.0, 0.0, 0.0, 0.0,
    )  # fmt: skip
    """True error of the rolling radius of fl fr rl rr: true = nominal (1 + error)."""
    radius_error_sd: Annotated[float, Range(0, 0.05)] = 0.005
    """sd of a random error, added for each wheel, drawn once from the seed: wear and pressure."""

    def __post_init__(self) -> None:
        check_fields("wheels", self)

    @property
    def counts_per_turn(self) -> int:
        """Counts in one turn of a wheel."""
        return self.lines * self.decoding


@dataclass(frozen=True, kw_only=True)
class WheelsState:
    """State of the encoders, and the errors drawn for this run."""

    reader: Reader
    arrival_ns: int
    phase_rad: Array
    """Angle of each wheel at the zero of its counter, shape (4,)."""
    radius_error: Array
    """True relative error of each rolling radius, shape (4,)."""
    read_jitter: Generator
    latency: Generator


def init(config: Wheels, seed: int, start_ns: int) -> WheelsState:
    """State of the encoders at the start of a run; the drawn errors depend on the seed alone."""
    drawn = generator(seed, "wheels", "radius").standard_normal(4)
    return WheelsState(
        reader=reader(start_ns, config.rate_hz),
        arrival_ns=start_ns,
        phase_rad=generator(seed, "wheels", "phase").uniform(0.0, 2.0 * np.pi, 4),
        radius_error=np.asarray(config.radius_error) + config.radius_error_sd * drawn,
        read_jitter=generator(seed, "wheels", "read jitter"),
        latency=generator(seed, "wheels", "latency"),
    )


def sample(config: Wheels, state: WheelsState, chunk: Trajectory) -> tuple[WheelsState, Table]:
    """Samples of the tick counters in the chunk.

        turned = angle + rate jitter
        ticks  = floor((turned / (1 + radius_error) + phase) counts_per_turn / 2 pi)

    A wheel whose true radius is larger than the nominal by the factor (1 + error) turns that much
    less over the same distance. Dividing the angle gives the ticks of such a wheel without a change
    of the physics: nominal radius times turned angle is then short of the true travel by
    (1 + error). The change of the radius with load is in the trajectory already.
    """
    names = ("wheel_angle_rad", "wheel_rate_radps")
    position, epoch_ns, at = read(state.reader, chunk, names)
    if not len(epoch_ns):
        return replace(state, reader=position), nothing(*TICKS, whole=TICKS)
    count = len(epoch_ns)
    jitter_s = config.read_jitter_s * state.read_jitter.standard_normal(count)
    turned_rad = at["wheel_angle_rad"] + at["wheel_rate_radps"] * jitter_s[:, None]
    angle_rad = turned_rad / (1.0 + state.radius_error) + state.phase_rad  # (n, 4)
    ticks = np.floor(angle_rad * (config.counts_per_turn / (2.0 * np.pi))).astype(np.int64)
    scatter = np.abs(state.latency.standard_normal(count))
    delay_s = config.latency_s + config.latency_jitter_s * scatter
    last_ns, arrival_ns = arrivals(state.arrival_ns, epoch_ns, delay_s)
    table: Table = {"epoch_ns": epoch_ns, "arrival_ns": arrival_ns}
    table |= {name: ticks[:, j] for j, name in enumerate(TICKS)}
    return replace(state, reader=position, arrival_ns=last_ns), table
