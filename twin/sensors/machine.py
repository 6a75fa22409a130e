"""The machine's CAN bus, and transducers read through it, with the bus's resolutions."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi
from typing import TYPE_CHECKING, Annotated

import numpy as np
from numpy.random import Generator

from twin.sensors.checks import Range, check_fields
from twin.sensors.noise import Array, generator
from twin.sensors.sampling import Reader, arrivals, nothing, read, reader
from twin.streams import Table

if TYPE_CHECKING:
    from twin.trajectory.trajectory import Trajectory

STEER_STEP_RAD = 1.0 / 1024.0
"""Resolution of a steering angle on the bus, rad (SAE J1939-71, angle slots)."""
HITCH_STEP = 0.004
"""Resolution of a hitch position, fraction of the travel (ISO 11783-7, 0.4 % per bit)."""
ENGINE_STEP_RADPS = 0.125 * 2.0 * pi / 60.0
"""Resolution of the engine speed, rad/s (SAE J1939-71 SPN 190, 0.125 1/min per bit)."""
LOAD_STEP = 0.01
"""Resolution of the engine's load, fraction (SAE J1939-71 SPN 92, 1 % per bit)."""
FUEL_STEP_LPH = 0.05
"""Resolution of the fuel rate, L/h (SAE J1939-71 SPN 183)."""
DRAFT_STEP_N = 10.0
"""Resolution of the draft pin, N (assumed, 16 bits over some hundred kN)."""
TORQUE_STEP_NM = 1.0
"""Resolution of the axle torque transducer, N m (assumed)."""


@dataclass(frozen=True, kw_only=True)
class Bus:
    """Messages of the bus: the data sheet's values, then the true errors."""

    rate_hz: Annotated[float, Range(0.1, 100)] = 10.0
    """Rate of the messages, Hz; J1939 sends engine messages every 10 to 100 ms."""
    latency_s: Annotated[float, Range(0, 1)] = 0.01
    """Time from measuring to arrival, s."""
    latency_jitter_s: Annotated[float, Range(0, 0.1)] = 0.002
    """Random part of the latency: this times |N(0, 1)|, s."""
    reference_torque_nm: Annotated[float, Range(1, 10_000)] = 600.0
    """Engine torque at an engine load of 1, N m (SPN 544)."""
    lower_link_m: Annotated[float, Range(0.05, 2)] = 0.9
    """Length of the lower links, m: height of the hitch points = length sin(lift angle)."""
    steer_sd_rad: Annotated[float, Range(0, 0.1)] = 0.002
    """Noise of the steering angle sensor, rad."""
    draft_pin_sd_n: Annotated[float, Range(0, 1e4)] = 150.0
    """Noise of the draft pin, N; about 0.2 % of its range."""
    axle_torque_sd_nm: Annotated[float, Range(0, 1e4)] = 30.0
    """Noise of the axle torque transducer, N m."""
    engine_sd_radps: Annotated[float, Range(0, 10)] = 0.084
    """Noise of the engine speed while the engine turns, rad/s: 0.8 rpm, measured on the bus of a
    John Deere 5055E at an even 1228 rpm without load (github.com/TractorHacking/CAN-data)."""
    steer_bias_rad: Annotated[float, Range(-0.2, 0.2)] = 0.0
    """True zero error of the steering angle sensor, rad."""
    draft_pin_scale_error: Annotated[float, Range(-0.2, 0.2)] = 0.0
    """True relative scale error of the draft pin."""

    def __post_init__(self) -> None:
        check_fields("machine", self)


@dataclass(frozen=True, kw_only=True)
class BusState:
    """State of the bus."""

    reader: Reader
    arrival_ns: int
    steer: Generator
    draft: Generator
    torque: Generator
    engine: Generator
    latency: Generator


def init(config: Bus, seed: int, start_ns: int) -> BusState:
    """State of the bus at the start of a run."""
    return BusState(
        reader=reader(start_ns, config.rate_hz),
        arrival_ns=start_ns,
        steer=generator(seed, "machine", "steer"),
        draft=generator(seed, "machine", "draft"),
        torque=generator(seed, "machine", "torque"),
        engine=generator(seed, "machine", "engine"),
        latency=generator(seed, "machine", "latency"),
    )


COLUMNS = (
    "steer_rad", "hitch_rad", "draft_n", "axle_torque_nm", "engine_radps", "engine_torque_nm",
    "fuel_lph",
)  # fmt: skip


GIVEN = (
    "steer_rad", "hitch_m", "draft_pin_n", "axle_torque_nm", "engine_radps", "engine_load",
    "fuel_lph",
)  # fmt: skip


def sample(config: Bus, state: BusState, chunk: Trajectory) -> tuple[BusState, Table]:
    """Messages of the chunk: each quantity with its noise, rounded to the bus's resolution.

    hitch_m       = lower_link sin(hitch_rad)
    engine_load   = engine torque / reference torque, in [0, 1.25]
    engine_radps  = max(0, speed + noise) while the engine turns, 0 while it stands
    """
    position, epoch_ns, at = read(state.reader, chunk, COLUMNS)
    if not len(epoch_ns):
        return replace(state, reader=position), nothing(*GIVEN)
    count = len(epoch_ns)
    steer = config.steer_bias_rad + config.steer_sd_rad * state.steer.standard_normal(count)
    draft = config.draft_pin_sd_n * state.draft.standard_normal(count)
    torque = config.axle_torque_sd_nm * state.torque.standard_normal(count)
    engine = config.engine_sd_radps * state.engine.standard_normal(count)
    scatter = np.abs(state.latency.standard_normal(count))
    delay_s = config.latency_s + config.latency_jitter_s * scatter
    last_ns, arrival_ns = arrivals(state.arrival_ns, epoch_ns, delay_s)
    pin_n = at["draft_n"] * (1.0 + config.draft_pin_scale_error)
    load = np.clip(at["engine_torque_nm"] / config.reference_torque_nm, 0.0, 1.25)
    hitch_m = config.lower_link_m * np.sin(at["hitch_rad"])
    turning_radps = at["engine_radps"]
    engine_radps = np.where(turning_radps > 0.0, np.maximum(turning_radps + engine, 0.0), 0.0)
    table: Table = {
        "epoch_ns": epoch_ns,
        "arrival_ns": arrival_ns,
        "steer_rad": _rounded(at["steer_rad"] + steer, STEER_STEP_RAD),
        "hitch_m": _rounded(hitch_m, HITCH_STEP * config.lower_link_m),
        "draft_pin_n": _rounded(pin_n + draft, DRAFT_STEP_N),
        "axle_torque_nm": _rounded(at["axle_torque_nm"] + torque, TORQUE_STEP_NM),
        "engine_radps": _rounded(engine_radps, ENGINE_STEP_RADPS),
        "engine_load": _rounded(load, LOAD_STEP),
        "fuel_lph": _rounded(at["fuel_lph"], FUEL_STEP_LPH),
    }
    return replace(state, reader=position, arrival_ns=last_ns), table


def _rounded(value: Array, step: float) -> Array:
    rounded: Array = np.rint(value / step) * step
    return rounded
