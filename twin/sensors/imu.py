"""Inertial unit: three gyroscopes and three accelerometers, 200 Hz inside and 50 Hz out.

    felt       = scale misalignment (truth + engine vibration)          on the physics grid
    converted  = clip(mean of felt over 5 ms + bias + white, range)     200 Hz
    out        = round(every 4th of low-pass(converted), resolution)    50 Hz

The 200 Hz samples are *means* over 5 ms and not values picked at instants, as a strapdown unit
reports increments: a mean has nulls at 200, 400 ... Hz, exactly the bands that would fold onto the
low frequencies that are kept, and 5 ms need not be a multiple of the physics step.

A sample's epoch is the instant that it describes: the end of its last window, less half a window,
less the low-pass's delay at zero frequency. It arrives after the end of that window. The delay
grows with frequency: a sine at a third of the cut-off is 0.5 ms late (measured).

Model and symbols: IEEE Std 952 and 1293: y = (1 + S) x + b0 + b(t) + w.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import radians
from typing import TYPE_CHECKING, Annotated, NamedTuple

import numpy as np
from numpy.random import Generator

from twin.errors import BadInput, check_range
from twin.sensors.checks import Range, check_fields
from twin.sensors.filters import filtered, group_delay_s, low_pass, settled
from twin.sensors.noise import Array, GaussMarkov, advance, gauss_markov, generator
from twin.sensors.sampling import Averager, Stamps, arrivals, average, averager
from twin.sensors.vibration import Vibration, shake, start
from twin.streams import COLUMNS, Table

if TYPE_CHECKING:
    from twin.trajectory.trajectory import Trajectory

Vector = tuple[float, float, float]

STANDARD_GRAVITY_MPS2 = 9.80665
PEAK_OF_GAUSS_MARKOV = 0.6174
"""Highest Allan deviation of a Gauss-Markov process over its sd, reached at 1.89 correlation times:
sqrt((2/r) (1 - (3 - 4 exp(-r) + exp(-2 r)) / (2 r))) at r = 1.89."""


@dataclass(frozen=True, kw_only=True)
class Imu:
    """A MEMS unit of the MPU-92xx class; the data sheet's values, then the true errors."""

    rate_hz: Annotated[float, Range(1, 1000)] = 50.0
    """Output rate, Hz."""
    internal_rate_hz: Annotated[float, Range(1, 1000)] = 200.0
    """Conversion rate, Hz; a whole multiple of the output rate."""
    filter_order: Annotated[int, Range(4, 10)] = 4
    """Order of the Butterworth low-pass."""
    filter_cut_hz: Annotated[float, Range(0.1, 400)] = 15.0
    """-3 dB frequency of that low-pass, Hz; body modes are 1-7 Hz, engine orders from 12 Hz on."""
    latency_s: Annotated[float, Range(0, 1)] = 0.002
    """Time from the end of the last window to arrival, s; the filter's delay comes on top."""
    latency_jitter_s: Annotated[float, Range(0, 0.1)] = 0.0002
    """Random part of the latency: this times |N(0, 1)|, s."""
    gyro_noise_radps_rthz: Annotated[float, Range(0, 1)] = radians(0.005)
    """White noise N of the gyroscopes: Allan deviation N / sqrt(tau); angle random walk."""
    accel_noise_mps2_rthz: Annotated[float, Range(0, 10)] = 350e-6 * STANDARD_GRAVITY_MPS2
    """White noise N of the accelerometers, 300-400 ug/sqrt(Hz); velocity random walk."""
    gyro_instability_radps: Annotated[float, Range(0, 1)] = radians(0.0012)
    """Bias instability, the flat of the Allan deviation, rad/s."""
    accel_instability_mps2: Annotated[float, Range(0, 10)] = 50e-6 * STANDARD_GRAVITY_MPS2
    """Bias instability of the accelerometers, m/s2; assumed."""
    wander_tau_s: Annotated[float, Range(0.1, 1e5)] = 300.0
    """Correlation time of the wandering bias, s; 100-500."""
    gyro_bias_sd_radps: Annotated[float, Range(0, 1)] = radians(0.05)
    """sd of the turn-on bias, rad/s, after zeroing at standstill; 0.5 deg/s raw."""
    accel_bias_sd_mps2: Annotated[float, Range(0, 10)] = 0.01 * STANDARD_GRAVITY_MPS2
    """sd of the turn-on bias, m/s2; 10 mg calibrated, 50 mg raw."""
    scale_sd: Annotated[float, Range(0, 0.1)] = 1e-3
    """sd of the scale error of each axis, drawn once from the seed; assumed, calibrated unit."""
    mounting_sd_rad: Annotated[float, Range(0, 0.5)] = radians(0.2)
    """sd of each mounting angle, drawn once from the seed, rad; assumed, set with a square."""
    gyro_range_radps: Annotated[float, Range(0.1, 100)] = radians(250.0)
    """Full scale, rad/s; with 16 bits the resolution is range / 32768."""
    accel_range_mps2: Annotated[float, Range(10, 1000)] = 4.0 * STANDARD_GRAVITY_MPS2
    """Full scale, m/s2."""
    vibration_rms_mps2: Annotated[float, Range(0, 50)] = 0.5
    """Engine vibration on each axis before the filter, m/s2 rms; 0.5-2."""
    firing_order: Annotated[float, Range(0.5, 8)] = 3.0
    """Firings per turn of the engine; 3 for a four-stroke six-cylinder engine."""
    gyro_bias_radps: Annotated[Vector, Range(-1, 1)] = (0.0, 0.0, 0.0)
    """True bias, added to the random one, rad/s."""
    accel_bias_mps2: Annotated[Vector, Range(-10, 10)] = (0.0, 0.0, 0.0)
    """True bias, added to the random one, m/s2."""
    scale_error: Annotated[float, Range(-0.1, 0.1)] = 0.0
    """True scale error of every axis, added to the random ones."""
    mounting_error_rad: Annotated[Vector, Range(-0.5, 0.5)] = (0.0, 0.0, 0.0)
    """True roll, pitch and yaw of the unit in the body, added to the random ones, rad."""

    def __post_init__(self) -> None:
        check_fields("imu", self)
        check_range("imu.internal_rate_hz", self.internal_rate_hz, self.rate_hz, 1000)
        check_range("imu.filter_cut_hz", self.filter_cut_hz, 0.1, 0.4 * self.rate_hz)
        if self.internal_rate_hz % self.rate_hz:
            raise BadInput(
                f"imu.internal_rate_hz = {self.internal_rate_hz:g} is no whole multiple of "
                f"imu.rate_hz = {self.rate_hz:g}; {4 * self.rate_hz:g} would do"
            )

    @property
    def decimation(self) -> int:
        """Conversions per output sample."""
        return round(self.internal_rate_hz / self.rate_hz)


class Scales(NamedTuple):
    """Numbers of the data sheet for the six channels, gyroscopes first; each of shape (6,)."""

    white_sd: Array
    """sd of the white noise of a conversion."""
    limit: Array
    """Full scale."""
    step: Array
    """Resolution."""


@dataclass(frozen=True, kw_only=True)
class ImuState:
    """State of the unit, and the errors drawn for this run; gyroscopes come first."""

    start_ns: int
    arrival_ns: int
    averager: Averager
    vibration: Vibration
    sections: Array
    """The low-pass, shape (sections, 6)."""
    memory: Array | None
    """State of the low-pass; None before the first conversion."""
    delay_ns: int
    """Time from the epoch of a sample to the end of its last window."""
    scales: Scales
    felt_from_body: Array
    """Scale and mounting: (1 + S_i) R_ij, shape (2, 3, 3) for gyroscopes and accelerometers."""
    turn_on: Array
    """Turn-on bias, shape (6,)."""
    wander: GaussMarkov
    white: Generator
    latency: Generator


def init(config: Imu, seed: int, start_ns: int) -> ImuState:
    """State of the unit at the start of a run; the drawn errors depend on the seed alone."""
    turn_on = generator(seed, "imu", "turn-on").standard_normal(6)
    true_bias = np.array([*config.gyro_bias_radps, *config.accel_bias_mps2])
    instability = _both(config.gyro_instability_radps, config.accel_instability_mps2)
    density = _both(config.gyro_noise_radps_rthz, config.accel_noise_mps2_rthz)
    limit = _both(config.gyro_range_radps, config.accel_range_mps2)
    sections = low_pass(config.filter_order, config.filter_cut_hz, config.internal_rate_hz)
    return ImuState(
        start_ns=start_ns,
        arrival_ns=start_ns,
        averager=averager(start_ns, config.internal_rate_hz, 6),
        vibration=start(generator(seed, "imu", "vibration")),
        sections=sections,
        delay_ns=delay_ns(config, sections),
        scales=Scales(density * np.sqrt(config.internal_rate_hz), limit, limit / 32768.0),
        memory=None,
        felt_from_body=_felt_from_body(config, seed),
        turn_on=true_bias + turn_on_sd(config) * turn_on,
        wander=gauss_markov(
            generator(seed, "imu", "wander"),
            instability / PEAK_OF_GAUSS_MARKOV,
            config.wander_tau_s,
        ),
        white=generator(seed, "imu", "white"),
        latency=generator(seed, "imu", "latency"),
    )


def sample(config: Imu, state: ImuState, chunk: Trajectory) -> tuple[ImuState, Table]:
    """Samples of angular rate and specific force in the chunk; see the module for the law."""
    vibration, felt = _felt(config, state, chunk)
    windows, end_ns, means, number = average(state.averager, chunk.epoch_ns, felt)
    wander, converted = _converted(config, state, means)
    memory, smooth = state.memory, converted
    if len(converted):
        first = settled(state.sections, converted[0]) if memory is None else memory
        memory, smooth = filtered(state.sections, first, converted)
    epoch_ns = end_ns - state.delay_ns
    out = (number % config.decimation == 0) & (epoch_ns >= state.start_ns)
    last_ns, table = _output(config, state, epoch_ns[out], end_ns[out], smooth[out])
    after = replace(
        state,
        arrival_ns=last_ns,
        averager=windows,
        vibration=vibration,
        memory=memory,
        wander=wander,
    )
    return after, table


def delay_ns(config: Imu, sections: Array) -> int:
    """Time from the epoch of a sample to the end of its last window, ns."""
    half_window_s = 0.5 / config.internal_rate_hz
    return round((half_window_s + group_delay_s(sections, config.internal_rate_hz)) * 1e9)


def _felt(config: Imu, state: ImuState, chunk: Trajectory) -> tuple[Vibration, Array]:
    """Rates and forces along the unit's own axes, with vibration, shape (n, 6)."""
    gyro_b, accel_b = np.asarray(chunk["gyro_b"], float), np.asarray(chunk["imu_accel_b"], float)
    vibration = state.vibration
    if "engine_radps" in chunk.columns:
        vibration, added = shake(
            vibration,
            chunk.epoch_ns,
            chunk["engine_radps"],
            config.vibration_rms_mps2,
            config.firing_order,
        )
        accel_b = accel_b + added
    parts = [
        m[:, 0] * x[:, :1] + m[:, 1] * x[:, 1:2] + m[:, 2] * x[:, 2:3]
        for m, x in zip(state.felt_from_body, (gyro_b, accel_b), strict=True)
    ]
    return vibration, np.concatenate(parts, axis=1)


def _converted(config: Imu, state: ImuState, means: Array) -> tuple[GaussMarkov, Array]:
    """Conversions: means + turn-on bias + wandering bias + white of sd N sqrt(rate), clipped."""
    count = len(means)
    limit = state.scales.limit
    wander, bias = advance(state.wander, np.full(count, 1.0 / config.internal_rate_hz))
    white = state.scales.white_sd * state.white.standard_normal((count, 6))
    return wander, np.clip(means + state.turn_on + bias + white, -limit, limit)


def _output(
    config: Imu, state: ImuState, epoch_ns: Stamps, end_ns: Stamps, smooth: Array
) -> tuple[int, Table]:
    """Samples rounded to the resolution, and their stamps."""
    step = state.scales.step
    rounded = np.rint(smooth / step) * step
    scatter = np.abs(state.latency.standard_normal(len(epoch_ns)))
    delay_s = config.latency_s + config.latency_jitter_s * scatter
    last_ns, arrival_ns = arrivals(state.arrival_ns, end_ns, delay_s)
    table: Table = {"epoch_ns": epoch_ns, "arrival_ns": arrival_ns}
    table |= {name: rounded[:, j] for j, name in enumerate(COLUMNS["imu"])}
    return last_ns, table


def _felt_from_body(config: Imu, seed: int) -> Array:
    """(1 + S) R^T with R = Rz(yaw) Ry(pitch) Rx(roll), the unit's attitude in the body."""
    angles = generator(seed, "imu", "mounting").standard_normal(3)
    roll, pitch, yaw = np.asarray(config.mounting_error_rad) + config.mounting_sd_rad * angles
    cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (np.cos, np.sin))
    body_from_unit = np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
    drawn = generator(seed, "imu", "scale").standard_normal((2, 3))
    scale = 1.0 + config.scale_error + config.scale_sd * drawn
    felt: Array = scale[:, :, None] * body_from_unit.T
    return felt


def turn_on_sd(config: Imu) -> Array:
    """sd of the turn-on bias of the six channels, gyroscopes first, shape (6,)."""
    return _both(config.gyro_bias_sd_radps, config.accel_bias_sd_mps2)


def _both(gyro: float, accel: float) -> Array:
    return np.repeat([gyro, accel], 3).astype(float)
