"""All sensors of a machine: from a chunk of the trajectory to the samples that arrive in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from types import ModuleType
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from twin.errors import BadInput
from twin.sensors import camera, depth, gnss, ignition, imu, machine, own, wheels
from twin.sensors.camera import Camera
from twin.sensors.depth import Depth
from twin.sensors.faults import Fault, Held, fail
from twin.sensors.gnss import Gnss
from twin.sensors.imu import Imu
from twin.sensors.machine import Bus
from twin.sensors.own import Sensor, State
from twin.sensors.wheels import Wheels
from twin.streams import Streams, Table

if TYPE_CHECKING:
    from twin.trajectory.trajectory import Trajectory

Config = TypeVar("Config", Gnss, Imu, Wheels, Depth, Bus)
Fitted = Gnss | Imu | Wheels | Depth | Bus | Camera | Sensor

MODULES: dict[str, ModuleType] = {
    "gnss": gnss,
    "imu": imu,
    "wheels": wheels,
    "depth": depth,
    "machine": machine,
    "camera": camera,
}
"""Module of each stream; each has init(config, seed, start_ns) and sample(config, state, chunk).
Sensors of the user are in the module `own`."""


@dataclass(frozen=True, kw_only=True)
class Sensors:
    """The sensors of a machine; None leaves a sensor out."""

    gnss: Gnss | None = field(default_factory=Gnss)
    """Dual-antenna RTK receiver."""
    imu: Imu | None = field(default_factory=Imu)
    """Inertial unit."""
    wheels: Wheels | None = field(default_factory=Wheels)
    """Wheel encoders."""
    depth: Depth | None = field(default_factory=Depth)
    """Laser and inclinometer on the plough."""
    machine: Bus | None = field(default_factory=Bus)
    """The machine's CAN bus."""
    camera: Camera | None = None
    """Camera that looks down at the ground."""
    faults: tuple[Fault, ...] = ()
    """Scheduled faults of wires, counters and clocks."""
    ignition_off_s: ignition.Pairs = ()
    """Times without ignition: pairs of start, from the run's start, and duration [s]."""
    extra: tuple[Sensor, ...] = ()
    """Sensors of your own, on the command line as module:Name."""

    def __post_init__(self) -> None:
        streams = [sensor.stream for sensor in self.extra]
        if len(set(streams)) < len(streams):
            raise BadInput(f"sensors.extra: two of the streams {', '.join(streams)} are the same")
        ignition.check(self.ignition_off_s)
        self.fitted()

    def fitted(self) -> dict[str, Fitted]:
        """Configuration of each sensor that is not None, by stream."""
        shipped = {name: getattr(self, name) for name in MODULES}
        fitted = {name: config for name, config in shipped.items() if config is not None}
        if self.ignition_off_s and self.gnss is not None:
            every = ignition.outages(self.ignition_off_s, self.gnss.outages)
            fitted["gnss"] = replace(self.gnss, outages=every)
        return fitted | {sensor.stream: sensor for sensor in self.extra}


@dataclass(frozen=True, kw_only=True)
class SuiteState:
    """State of each sensor, and the samples that have not arrived yet.

    It holds random generators, which `sample` advances: to branch a run, deep-copy it first.
    """

    sensors: dict[str, State]
    waiting: dict[str, Table]
    start_ns: int = 0
    """Instant from which scheduled faults count."""
    held: Mapping[int, Held] = field(default_factory=dict)
    """States of the faults, by their number."""
    restarts: tuple[ignition.Restart, ...] = ()
    """Times without ignition."""
    switched: Mapping[str, ignition.Held] = field(default_factory=dict)
    """State of `ignition.switched`, by stream."""


def init(sensors: Sensors, seed: int, start_ns: int = 0) -> SuiteState:
    """State of all sensors at the start of a run.

    Args:
        sensors: the sensors of the machine.
        seed: seed of all noise terms and random errors; each sensor has generators of its own.
        start_ns: instant of the first sample; scheduled faults count from it.
    """
    fitted = sensors.fitted().items()
    states = {n: MODULES.get(n, own).init(c, seed, start_ns) for n, c in fitted}
    plan = ignition.restarts(sensors.ignition_off_s, seed, start_ns)
    return SuiteState(sensors=states, waiting={}, start_ns=start_ns, restarts=plan)


def sample(sensors: Sensors, state: SuiteState, chunk: Trajectory) -> tuple[SuiteState, Streams]:
    """The samples that arrive by the end of the chunk.

    A sample of this chunk that arrives later is returned with a later chunk, so nobody who reads
    the streams during the run sees a sample early. Samples and their order do not depend on how
    the run is cut into chunks.
    """
    states, waiting, arrived, held = {}, {}, {}, state.held
    switched = dict(state.switched)
    now_ns = int(chunk.epoch_ns[-1]) if len(chunk) else None
    for name, config in sensors.fitted().items():
        states[name], table = MODULES.get(name, own).sample(config, state.sensors[name], chunk)
        if sensors.faults:
            table, held = fail(sensors.faults, name, table, state.start_ns, held)
        if state.restarts:
            imu_sd = imu.turn_on_sd(sensors.imu or Imu())
            known = switched.get(name, {})
            table, switched[name] = ignition.switched(state.restarts, name, table, imu_sd, known)
        before = state.waiting.get(name)
        if before is not None and len(before["epoch_ns"]):
            table = {c: np.concatenate([before[c], v]) for c, v in table.items()}
        arrived[name], waiting[name] = _parted(table, now_ns)
    after = replace(state, sensors=states, waiting=waiting, held=held, switched=switched)
    if sensors.camera is None:
        return after, Streams(arrived)
    frames = camera.frames(sensors.camera, states["camera"], arrived["camera"])
    arrived["camera"] = camera.stream_table(arrived["camera"])  # the poses are true ones
    return after, Streams(arrived, frames)


def _parted(table: Table, now_ns: int | None) -> tuple[Table, Table]:
    """What has arrived by now, and what is still on its way."""
    count = 0
    if now_ns is not None and len(table["arrival_ns"]):
        count = int(np.searchsorted(table["arrival_ns"], now_ns, side="right"))
    nothing = {c: v[:0] for c, v in table.items()}
    if count == 0:
        return nothing, table
    if count == len(table["arrival_ns"]):
        return table, nothing
    return {c: v[:count] for c, v in table.items()}, {c: v[count:] for c, v in table.items()}


def faults_from(sensors: Sensors, start_s: float) -> Sensors:
    """The sensors with faults, outages and ignition times later by `start_s`."""
    if start_s == 0.0:
        return sensors
    faults = tuple(replace(f, start_s=f.start_s + start_s) for f in sensors.faults)
    off_s = tuple((at_s + start_s, duration_s) for at_s, duration_s in sensors.ignition_off_s)
    sensors = replace(sensors, faults=faults, ignition_off_s=())
    if sensors.gnss is None:
        return replace(sensors, ignition_off_s=off_s)
    outages = tuple(replace(o, start_s=o.start_s + start_s) for o in sensors.gnss.outages)
    moved = replace(sensors.gnss, outages=outages)
    return replace(sensors, gnss=moved, ignition_off_s=off_s)


ERRORS = ("_sd", "noise", "instability", "jitter", "latency", "vibration")
"""Parts of the names of fields that make a sensor noisy or late."""


def ideal() -> Sensors:
    """Sensors without noise, calibration errors, latency or vibration, and without a camera.

    Sample rates and resolutions are unchanged. The IMU keeps its low-pass filter, and its samples
    arrive late by the delay of this filter. Wheel encoders start at a random phase.
    """
    return Sensors(
        gnss=_quiet(Gnss()),
        imu=_quiet(Imu()),
        wheels=_quiet(Wheels()),
        depth=_quiet(Depth()),
        machine=_quiet(Bus()),
    )


def _quiet(config: Config) -> Config:
    names = [f.name for f in fields(config) if any(part in f.name for part in ERRORS)]
    changes: Mapping[str, State] = dict.fromkeys(names, 0.0)
    return replace(config, **changes)
