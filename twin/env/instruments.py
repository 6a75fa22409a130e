"""What a controller on a tractor has: the latest samples of its sensors, and an estimate."""

from __future__ import annotations

import math
from collections.abc import Sequence

from twin import sensors
from twin.machine.build import Machine
from twin.machine.geometry import geometry
from twin.pipeline.estimating import Estimator
from twin.simulation.columns import Record, Recorder
from twin.streams import COLUMNS, ESTIMATES, WHEELS, Streams, Table
from twin.trajectory.trajectory import Trajectory

ESTIMATED = ESTIMATES[1:]


class Instruments:
    """The sensors of one tractor and, where there is one, an estimator behind them."""

    def __init__(self, machine: Machine, estimator: Estimator | None) -> None:
        self.machine, self.estimator = machine, estimator
        self.config = machine.scenario.sensors
        self.setup = sensors.setup(self.config, geometry(machine))

    def begin(self, seed: int, approach: Trajectory) -> None:
        """Switch on, and look at the approach, so that every sensor has spoken."""
        self.switch_on(seed)
        self.recorder.normal = approach["ground_normal_w"][0]
        self.recorder.steps = len(approach)
        self._see(approach)

    def switch_on(self, seed: int) -> None:
        """Begin with the machine's own ground, at its first instant; nothing is seen yet."""
        self.recorder = Recorder(self.machine)
        self.state = sensors.init(self.config, seed)
        self.memory = self.estimator.init(self.setup) if self.estimator else None
        self.latest = {f"{s}.{c}": 0.0 for s, columns in COLUMNS.items() for c in columns}
        self.latest |= dict.fromkeys(ESTIMATED, 0.0)
        self.counted: dict[str, int] = {}
        self.gnss_ns = 0

    def advance(self, record: Record) -> None:
        """Take in what was recorded of one control step."""
        self._see(self.recorder.sensed(record))

    def values(self) -> dict[str, float]:
        """The latest known value of everything, by `sensor.column` or by the estimate's column."""
        setup, latest = self.setup.depth, self.latest
        out = dict(latest)
        if setup is not None:
            range_m, angle = latest["depth.laser_m"], latest["depth.inclination_rad"]
            out["depth_m"] = setup.zero_m - range_m * math.cos(angle)
        for name in ("engine_radps", "engine_load", "draft_pin_n", "hitch_m"):
            out[name] = latest[f"machine.{name}"]
        now_ns = self.recorder.steps * self.recorder.step_ns
        out["gnss.age_s"] = (now_ns - self.gnss_ns) * 1e-9
        return out

    def _see(self, chunk: Trajectory) -> None:
        self.state, streams = sensors.sample(self.config, self.state, chunk)
        for sensor, table in streams.tables.items():
            columns = [c for c in COLUMNS.get(sensor, ()) if c in table]
            self._hold(table, columns, f"{sensor}.")
        self._count(streams)
        if "gnss" in streams and len(streams["gnss"]["epoch_ns"]):
            self.gnss_ns = int(streams["gnss"]["epoch_ns"][-1])
        if self.estimator is not None:
            self.memory, estimates = self.estimator.run(self.memory, streams)
            self._hold(estimates, [c for c in ESTIMATED if c in estimates], "")

    def _hold(self, table: Table, columns: Sequence[str], prefix: str) -> None:
        """Keep the last row; a value that is not known leaves the one before."""
        if not len(table["epoch_ns"]):
            return
        for column in columns:
            value = float(table[column][-1])
            if math.isfinite(value):
                self.latest[prefix + column] = value

    def _count(self, streams: Streams) -> None:
        """Turn the encoders' cumulative counts into counts of this control step."""
        if "wheels" not in streams:
            return
        for column in (f"ticks_{wheel}" for wheel in WHEELS):
            table = streams["wheels"]
            if column not in table:
                continue
            counts = table[column]
            if column not in self.counted:  # the approach is many control steps long
                self.counted[column] = int(counts[-2]) if len(counts) > 1 else 0
            now = int(counts[-1]) if len(counts) else self.counted[column]
            self.latest[f"wheels.{column}"] = float(now - self.counted[column])
            self.counted[column] = now
