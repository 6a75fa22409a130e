"""Record the episodes of an environment for the rerun viewer."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, SupportsFloat

import numpy as np
from gymnasium import Env, Wrapper
from numpy.typing import NDArray

from twin import sensors, viz
from twin.env.infos import Infos
from twin.env.single import Observation, SingleEnv
from twin.io.atomic import made
from twin.io.run_folder import Record
from twin.machine.geometry import geometry
from twin.scenario import Scenario
from twin.simulation.build import build
from twin.simulation.columns import Recorder
from twin.streams import ESTIMATES, Streams, Table
from twin.trajectory.trajectory import Trajectory
from twin.truth import truth

TOWED = ("draft_n", "axle_torque_nm")
"""What an electric tractor's callback does not know of, and its fleet does."""


class Recording(Wrapper[Observation, NDArray[np.float32], Observation, NDArray[np.float32]]):
    """Writes each episode as `episode_<number>.rrd`: the tractor on its ground, slip, reward.

    ```
    env = Recording(gymnasium.make("twin.env:Plough-v0"), Path("episodes"))
    ```

    An episode is written when it ends, or at the next reset or `close` if it has not ended.
    """

    def __init__(self, env: Env[Observation, NDArray[np.float32]], directory: Path) -> None:
        """Args: env: Plough-v0 or WheelSlip-v0 with one tractor. directory: created if missing."""
        super().__init__(env)
        self.single: SingleEnv = env.unwrapped  # type: ignore[assignment]
        self.single.episodes.fleet.sensed = True  # all of the sensors are written
        self.directory, self.number = directory, 0
        self.moments: list[Infos] = []

    def reset(self, **arguments: Any) -> tuple[Observation, Infos]:
        """As the environment's."""
        self._write()
        observation, info = super().reset(**arguments)
        self._keep(observation, {})
        return observation, info

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[Observation, SupportsFloat, bool, bool, Infos]:
        """As the environment's."""
        observation, reward, terminated, truncated, info = super().step(action)
        self._keep(observation, info)
        if terminated or truncated:
            self._write()
        return observation, reward, terminated, truncated, info

    def close(self) -> None:
        """As the environment's."""
        self._write()
        super().close()

    def _keep(self, observation: Observation, info: Infos) -> None:
        """What this instant looks like."""
        episodes = self.single.episodes
        fleet = episodes.fleet
        moment: Infos = {name: float(value[0]) for name, value in episodes.values_of(TOWED).items()}
        moment |= {"sensordata": fleet.sensordata[0].copy(), "userdata": fleet.slots[0].copy()}
        moment |= zip(episodes.actions_named, episodes.actions[0], strict=True)
        moment |= {name: info.get(name, 0.0) for name in episodes.rewarded}
        seen = zip(self.single.entries, observation, strict=True)
        moment |= {f"seen.{entry.name}": float(value) for entry, value in seen}
        self.moments.append(moment)

    def _write(self) -> None:
        """Write what was kept as an episode; nothing of one in which nothing happened."""
        kept, self.moments = self.moments, []
        if len(kept) < 2:
            return
        columns = {name: np.array([moment[name] for moment in kept]) for name in kept[0]}
        machine = self.single.episodes.fleet.machine
        scenario = self._scenario()
        table = self._truth(columns)
        clock = {"epoch_ns": table["epoch_ns"]}
        estimate = {n: columns[f"seen.{n}"] for n in ESTIMATES if f"seen.{n}" in columns}
        chosen = (*self.single.episodes.actions_named, *(n for n in columns if "reward_" in n))
        shown = build(replace(machine.scenario, field=scenario.field), looks=True, settle=False)
        with made(self.directory):
            viz.record(
                Record(
                    scenario=scenario,
                    setup=sensors.setup(machine.scenario.sensors, geometry(machine)),
                    streams=Streams({}),
                    truth=table,
                    estimates={"seen": clock | estimate} if "slip_sd" in estimate else {},
                ),
                self.directory / f"episode_{self.number}.rrd",
                model=shown.model,
                ground=viz.Ground(world_from_ground=shown.world_from_ground),
                control=clock | {name: columns[name] for name in chosen},
            )
        self.number += 1

    def _truth(self, columns: Table) -> Table:
        """Truth at every control step."""
        episodes = self.single.episodes
        recorder = Recorder(episodes.fleet.machine)
        recorder.normal = episodes.fleet.world_from_ground[0, :, 2]
        record = {name: columns[name][None] for name in ("sensordata", "userdata")}
        close = recorder.trajectory([record])  # as if of consecutive physics steps
        apart = Trajectory(np.arange(len(close), dtype=np.int64) * truth.PERIOD_NS, close.columns)
        table = truth.sample(apart, geometry(episodes.fleet.machine).driven)
        return truth.integrate(table, None) | {name: columns[name] for name in TOWED}

    def _scenario(self) -> Scenario:
        """The machine's scenario on the episode's ground."""
        episodes = self.single.episodes
        start, ground = episodes.begun[0]
        patches = tuple(replace(p, start_m=start.along_m + p.start_m) for p in ground.patches)
        return replace(
            episodes.fleet.machine.scenario,
            soil=ground.soil,
            field=replace(ground.shape.field(), patches=patches),
            seed=ground.pattern_seed,
        )
