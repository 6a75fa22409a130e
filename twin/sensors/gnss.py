"""Dual-antenna RTK GNSS: position, Doppler velocity, heading of the antenna baseline."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import hypot, pi, radians
from typing import TYPE_CHECKING, Annotated

import numpy as np
from numpy.random import Generator

from twin.compute.quaternion import cross, rotated
from twin.sensors.checks import Range, check_fields
from twin.sensors.doppler import NEVER_NS, axes, motion_left, velocity
from twin.sensors.fix import QUALITY, Mode, Outage, Timeline, active, check_outages, timeline
from twin.sensors.noise import (
    Array,
    GaussMarkov,
    Smooth,
    advance,
    advance_smooth,
    gauss_markov,
    generator,
    smooth,
)
from twin.sensors.sampling import Reader, arrivals, nothing, read, reader
from twin.streams import Table

if TYPE_CHECKING:
    from twin.trajectory.trajectory import Trajectory


@dataclass(frozen=True, kw_only=True)
class Gnss:
    """A receiver with two antennas; the data sheet's values, then the true errors and faults.

    Standard deviations are per horizontal axis; the vertical is `vertical_factor` times worse.
    """

    rate_hz: Annotated[float, Range(0.1, 100)] = 20.0
    """Output rate, Hz."""
    latency_s: Annotated[float, Range(0, 5)] = 0.05
    """Time from the epoch to arrival, s; 20 ms in a low-latency mode, up to 0.5 s synchronous."""
    latency_jitter_s: Annotated[float, Range(0, 1)] = 0.002
    """Random part of the latency: this times |N(0, 1)|, s."""
    white_sd_m: Annotated[float, Range(0, 10)] = 0.004
    """White part of a fixed position, m; 3-5 mm."""
    coloured_sd_m: Annotated[float, Range(0, 10)] = 0.0065
    """Coloured part of a fixed position, m; 5-8 mm. With the white part 8 mm, the rms of a
    UM980-class receiver near its base."""
    coloured_tau_s: Annotated[float, Range(0.01, 1e5)] = 60.0
    """Correlation time of the coloured part, s."""
    vertical_factor: Annotated[float, Range(0, 10)] = 2.0
    """Vertical error over horizontal error."""
    velocity_sd_mps: Annotated[float, Range(0, 10)] = 0.03
    """sd of the white noise of the Doppler velocity in motion, m/s; 0.02-0.04."""
    rest_velocity_sd_mps: Annotated[float, Range(0, 10)] = 0.0031
    """sd of the noise of the Doppler velocity at rest, m/s; at most that in motion is used.
    Measured: on a standing tractor, its engine off or on, a receiver shows a speed of 3.7 mm/s in
    the median and 9 mm/s in the 99th percentile: 1.18 and 3.03 sd of a Rayleigh distribution."""
    rest_velocity_tau_s: Annotated[float, Range(0.01, 1e5)] = 1.3
    """Correlation time of the velocity noise at rest, s; measured: a correlation of 0.47 at 1 s."""
    heading_sd_rad_m: Annotated[float, Range(0, 1)] = radians(0.2)
    """Noise of the heading times the length of the baseline, rad m; 0.1-0.2 deg at 1 m."""
    extrapolation_sd_mps: Annotated[float, Range(0, 1)] = 0.01
    """sd of the rate at which the error grows without corrections, m/s: 1 cm per second of age."""
    float_sd_m: Annotated[float, Range(0, 10)] = 0.35
    """sd of the error of a float solution, m; 0.2-0.5."""
    float_tau_s: Annotated[float, Range(0.01, 1e5)] = 60.0
    """Time constant T of the float error, s, 30-100; its correlation is (1 + t/T) exp(-t/T)."""
    single_sd_m: Annotated[float, Range(0, 100)] = 1.5
    """sd of the error of a single-point solution, m; 0.4-2.5."""
    single_tau_s: Annotated[float, Range(0.01, 1e5)] = 120.0
    """Time constant T of the single-point error, s. Measured on a parked tractor, each axis:
    0.16 m of change in 10 s and 0.6 m in 60 s."""
    masked_velocity_factor: Annotated[float, Range(1, 100)] = 3.0
    """Velocity noise with few satellites over that with all (assumed)."""
    satellites_main: Annotated[float, Range(0, 100)] = 28.0
    """Mean number of satellites used by the main antenna."""
    satellites_aux: Annotated[float, Range(0, 100)] = 26.0
    """Mean number of satellites used by the auxiliary antenna."""
    satellites_masked: Annotated[float, Range(0, 100)] = 6.0
    """Mean number of satellites used by a masked antenna."""
    heading_bias_rad: Annotated[float, Range(-0.5, 0.5)] = 0.0
    """True error of the baseline's mounting angle, rad."""
    heading_bias_sd_rad: Annotated[float, Range(0, 0.5)] = radians(0.1)
    """sd of a random error of that angle, drawn once from the seed and added, rad."""
    lever_arm_error_m: Annotated[tuple[float, float, float], Range(-5, 5)] = (0.0, 0.0, 0.0)
    """True position of the antennas less the one in the set-up, body axes, m."""
    outages: tuple[Outage, ...] = ()
    """Scheduled outages, in order and without overlap."""

    def __post_init__(self) -> None:
        check_fields("gnss", self)
        check_outages(self.outages)

    @property
    def position_sd_m(self) -> float:
        """sd of a fixed position per horizontal axis, white and coloured part together, m."""
        return hypot(self.white_sd_m, self.coloured_sd_m)


COLOURED = ("fixed", "rest", "satellites")
SMOOTH = ("float", "single")
WHITE = ("white", "velocity", "heading", "latency")


@dataclass(frozen=True, kw_only=True)
class GnssState:
    """State of the receiver, and the errors drawn for this run."""

    start_ns: int
    reader: Reader
    arrival_ns: int
    timeline: Timeline
    heading_bias_rad: float
    coloured: dict[str, GaussMarkov]
    smooth: dict[str, Smooth]
    moved_ns: int
    """Time of the last motion of the antenna."""
    white: dict[str, Generator]


def init(config: Gnss, seed: int, start_ns: int) -> GnssState:
    """State of the receiver at the start of a run, in fixed mode; draws recovery times."""
    each = axes(config)
    processes = {
        "fixed": (config.coloured_sd_m * each, config.coloured_tau_s),
        "float": (config.float_sd_m * each, config.float_tau_s),
        "single": (config.single_sd_m * each, config.single_tau_s),
        "satellites": (np.full(2, 1.0), 60.0),
        "rest": (each, config.rest_velocity_tau_s),
    }
    drawn = float(generator(seed, "gnss", "heading bias").standard_normal())
    return GnssState(
        start_ns=start_ns,
        reader=reader(start_ns, config.rate_hz),
        arrival_ns=start_ns,
        timeline=timeline(
            config.outages, config.extrapolation_sd_mps * each, generator(seed, "gnss", "faults")
        ),
        heading_bias_rad=config.heading_bias_rad + config.heading_bias_sd_rad * drawn,
        coloured={n: gauss_markov(generator(seed, "gnss", n), *processes[n]) for n in COLOURED},
        smooth={n: smooth(generator(seed, "gnss", n), *processes[n]) for n in SMOOTH},
        moved_ns=NEVER_NS,
        white={n: generator(seed, "gnss", n) for n in WHITE},
    )


COUNTED = ("quality", "satellites_main", "satellites_aux")
GIVEN = (
    "east_m", "north_m", "up_m", "quality", "position_sd_m", "v_east_mps", "v_north_mps",
    "v_up_mps", "velocity_sd_mps", "heading_rad", "heading_sd_rad", *COUNTED[1:],
)  # fmt: skip
NAMES = (
    "antenna_main_w", "antenna_main_velocity_w", "antenna_aux_w", "world_from_body", "gyro_b",
)  # fmt: skip


def sample(config: Gnss, state: GnssState, chunk: Trajectory) -> tuple[GnssState, Table]:
    """Samples of position, velocity and heading in the chunk.

    Every noise term is drawn at every epoch whatever the mode, so an outage changes no sample
    outside itself and its recovery.
    """
    position, epoch_ns, at = read(state.reader, chunk, NAMES)
    if not len(epoch_ns):
        return replace(state, reader=position), nothing(*GIVEN, whole=COUNTED)
    time_s: Array = (epoch_ns - state.start_ns) * np.float64(1e-9)
    count = len(epoch_ns)
    coloured, smooths, colours = {}, {}, {}
    step_s = np.full(count, 1.0 / config.rate_hz)
    for name in COLOURED:
        coloured[name], colours[name] = advance(state.coloured[name], step_s)
    for name in SMOOTH:
        smooths[name], colours[name] = advance_smooth(state.smooth[name], step_s)
    draws = {n: state.white[n].standard_normal((count, 3)) for n in WHITE}

    error_m = np.asarray(config.lever_arm_error_m, np.float64)
    arm_w = rotated(at["world_from_body"], error_m)
    swing_w = rotated(at["world_from_body"], cross(at["gyro_b"], error_m))
    delay_s = config.latency_s + config.latency_jitter_s * np.abs(draws["latency"][:, 0])
    last_ns, arrival_ns = arrivals(state.arrival_ns, epoch_ns, delay_s)
    table: Table = {"epoch_ns": epoch_ns, "arrival_ns": arrival_ns}
    table |= _position(config, state, time_s, at["antenna_main_w"] + arm_w, colours, draws["white"])
    velocity_w = at["antenna_main_velocity_w"] + swing_w
    moved_ns, motion = motion_left(state.moved_ns, epoch_ns, velocity_w)
    table |= velocity(config, time_s, velocity_w, motion, draws["velocity"], colours["rest"])
    baseline_w = at["antenna_aux_w"] - at["antenna_main_w"]
    table |= _heading(config, state, time_s, baseline_w, draws["heading"][:, 0])
    table |= _satellites(config, time_s, colours["satellites"])
    after = replace(
        state,
        reader=position,
        arrival_ns=last_ns,
        coloured=coloured,
        smooth=smooths,
        moved_ns=moved_ns,
    )
    return after, table


def _position(
    config: Gnss,
    state: GnssState,
    time_s: Array,
    antenna_w: Array,
    colours: dict[str, Array],
    white: Array,
) -> Table:
    """Position of the main antenna.

    fixed         truth + white + coloured
    extrapolated  the same + drift age
    float, single truth + white + that mode's own coloured error
    none          NaN
    """
    mode, age_s, drift_mps = state.timeline.at(time_s)
    extrapolated = mode == Mode.EXTRAPOLATED
    kept_s = np.where(extrapolated, age_s, 0.0)
    modes = [mode == Mode.FLOAT, mode == Mode.SINGLE, mode == Mode.NONE]
    errors_m = [colours["float"], colours["single"], np.full_like(white, np.nan)]
    fixed_m = colours["fixed"] + drift_mps * kept_s[:, None]
    coloured_m = np.select([m[:, None] for m in modes], errors_m, fixed_m)
    position_w = antenna_w + config.white_sd_m * axes(config) * white + coloured_m
    known_m = np.hypot(config.coloured_sd_m, config.extrapolation_sd_mps * kept_s)
    sd_m = np.select(modes, [config.float_sd_m, config.single_sd_m, np.nan], known_m)
    return {
        "east_m": position_w[:, 0],
        "north_m": position_w[:, 1],
        "up_m": position_w[:, 2],
        "quality": QUALITY[mode],
        "position_sd_m": np.hypot(config.white_sd_m, sd_m),
    }


def _heading(
    config: Gnss, state: GnssState, time_s: Array, baseline_w: Array, white: Array
) -> Table:
    """Direction from the main to the auxiliary antenna in the horizontal plane, in (-pi, pi].

        heading = atan2(north, east) + bias + (sd / length) white

    Relative between the two antennas, so it needs no corrections, but both must see the sky.
    """
    east, north, up = baseline_w[:, 0].copy(), baseline_w[:, 1].copy(), baseline_w[:, 2]
    length_m = np.sqrt(east * east + north * north + up * up)
    seen = ~active(config.outages, ("mask", "mask-aux", "block"), time_s) & (length_m > 1e-3)
    sd_rad = np.where(seen, config.heading_sd_rad_m / np.where(seen, length_m, 1.0), np.nan)
    heading_rad = np.arctan2(north, east) + state.heading_bias_rad + sd_rad * white
    return {"heading_rad": wrap(heading_rad), "heading_sd_rad": sd_rad}


def _satellites(config: Gnss, time_s: Array, colour: Array) -> Table:
    """Satellites used by each antenna: a slowly varying whole number about its mean."""
    blocked = active(config.outages, ("block",), time_s)
    masked = (
        active(config.outages, ("mask",), time_s),
        active(config.outages, ("mask", "mask-aux"), time_s),
    )
    counts: Table = {}
    for j, name in enumerate(("satellites_main", "satellites_aux")):
        mean = np.where(masked[j], config.satellites_masked, getattr(config, name))
        used = np.where(blocked, 0.0, np.maximum(np.rint(mean + colour[:, j]), 0.0))
        counts[name] = used.astype(np.int64)
    return counts


def wrap(angle_rad: Array) -> Array:
    """The angle in (-pi, pi]."""
    wrapped: Array = pi - np.mod(pi - angle_rad, 2.0 * pi)
    return wrapped
