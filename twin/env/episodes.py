"""What a single environment and a vector of them share: tractors, observations, rewards, stalls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from twin import registry
from twin.env import observations, reward
from twin.env.fleet import Fleet
from twin.env.grounds import Ground, lies
from twin.env.instruments import Instruments
from twin.env.starts import Starts, start_throttle
from twin.errors import BadInput, UnknownName, check_range
from twin.machine.build import build
from twin.scenario import Course, Plough, Scenario
from twin.sensors.machine import Bus, fuel_lph

Array = NDArray[np.float64]

ACTIONS = ("throttle", "hitch")
KNOWN = ("slip", "depth_m", "speed_mps", "draft_n", "traction_efficiency")
STALL_MPS, STALL_S = 0.05, 1.0
"""Slower than this for this long is a stall."""


class Episodes:
    """Tractors that plough, each in an episode of its own; nothing here knows of time limits."""

    def __init__(
        self,
        observation: str,
        estimator: str,
        depth_m: float,
        slip_target: float,
        nsim: int = 1,
        nthread: int = 1,
    ) -> None:
        if observation not in observations.MODES:
            raise UnknownName("observation", observation, observations.MODES)
        check_range("slip_target", slip_target, 0.02, 0.4)
        self.depth_m, self.slip_target = float(depth_m), float(slip_target)
        scenario = Scenario(
            name="Plough-v0",
            plough=Plough(depth_m=self.depth_m),
            course=Course(approach_m=1.0),  # the last furrow is there from the start
        )
        machine = build(scenario)
        numbers = machine.numbers
        self.width_m = numbers["plough.bodies"] * numbers["plough.body_width_m"]
        self.fleet, self.lies = Fleet(machine, nsim, nthread), lies(self.depth_m)
        self.starts = Starts(machine, seen=observation != "truth", nthread=nthread)
        self.starts.of(self.lies)
        self.instruments: list[Instruments] = []
        if observation != "truth":
            wanted = registry.load("estimator", estimator) if observation == "estimate" else None
            self.instruments = [Instruments(machine, wanted) for _ in range(nsim)]
        self.entries = observations.MODES[observation]
        self.observation_space = observations.space(self.entries)
        self.action_space = Box(-1.0, 1.0, (len(ACTIONS),), np.float32)
        self.actions, self.standing_s = np.zeros((nsim, len(ACTIONS))), np.zeros(nsim)

    def begin(self, ids: Sequence[int], grounds: Sequence[Ground]) -> None:
        """Begin the episodes of some tractors."""
        starts = self.starts.of([ground.lie for ground in grounds])
        self.fleet.restore(ids, starts, grounds)
        self.standing_s[ids] = 0.0
        self.actions[ids] = start_throttle(self.fleet.machine), -1.0
        if self.instruments:
            for i, start, ground in zip(ids, starts, grounds, strict=True):
                if start.approach is not None:
                    self.instruments[i].begin(ground.noise_seed, start.approach)

    def advance(self, actions: Array) -> NDArray[np.bool_]:
        """Drive all for one control step, actions (nsim, 2) in [-1, 1]; which have stalled."""
        self.actions = actions
        records = self.fleet.drive(actions, record=bool(self.instruments))
        for i, instruments in enumerate(self.instruments):
            if records is not None:
                instruments.advance([{k: v[i : i + 1] for k, v in records.items()}])
        slow = self.fleet.speed_mps() < STALL_MPS
        self.standing_s = np.where(slow, self.standing_s + self.fleet.period_s, 0.0)
        stalled: NDArray[np.bool_] = self.standing_s >= STALL_S
        return stalled

    def rewards(self, true: Mapping[str, Array]) -> tuple[Array, dict[str, Array]]:
        """Rewards of the control step (nsim,), and their terms as `reward_<term>`."""
        terms = reward.terms(true, self.width_m, self.depth_m, self.slip_target)
        total = np.zeros(len(self.actions))
        for value in terms.values():
            total = total + value
        return total, {f"reward_{name}": value for name, value in terms.items()}

    def observe(self, true: Mapping[str, Array], ids: Any = slice(None)) -> NDArray[np.float32]:
        """What the controller of each tractor, or of some, sees now, (nsim, entries)."""
        values: Mapping[str, Any] = true
        if self.instruments:
            chosen = np.arange(len(self.instruments))[ids]
            each = [self.instruments[i].values() for i in chosen]
            values = {name: np.array([one[name] for one in each]) for name in each[0]}
        task: dict[str, Any] = {
            "throttle": self.actions[ids, 0],
            "lift_set_rad": self.fleet.lift_rad[ids],
            "slip_target": self.slip_target,
            "depth_target_m": self.depth_m,
        }
        count = len(task["throttle"])
        return observations.pack({**values, **task}, self.entries, self.observation_space, count)

    def info(self, true: Mapping[str, Array]) -> dict[str, Array]:
        """What is true now and worth knowing of each tractor, each of shape (nsim,)."""
        rate_m2ps = reward.work_rate_m2ps(true, self.width_m, self.depth_m)
        power_w = true["engine_torque_nm"] * true["engine_radps"]
        return {
            **{name: true[name] for name in KNOWN},
            "work_rate_haph": rate_m2ps * 0.36,
            "fuel_lph": fuel_lph(power_w, Bus().rated_power_w),
        }


def checked(action: Any, batch: tuple[int, ...]) -> Array:
    """Actions as numbers within [-1, 1], (*batch, 2).

    Raises:
        BadInput: one that cannot be meant.
    """
    shape = (*batch, len(ACTIONS))
    wanted = f"{len(ACTIONS)} numbers in [-1, 1]: {', '.join(ACTIONS)}"
    try:
        taken = np.asarray(action, dtype=np.float64)
    except (TypeError, ValueError):
        raise BadInput(f"action {action!r} is not {wanted}") from None
    if taken.shape != shape:
        raise BadInput(f"action has shape {taken.shape}, not {shape}; give {wanted}")
    if not np.isfinite(taken).all():
        place = tuple(np.argwhere(~np.isfinite(taken))[0].tolist())
        where, name = ", ".join(map(str, place)), ACTIONS[place[-1]]
        raise BadInput(f"action[{where}] ({name}) = {taken[place]} is not finite; give {wanted}")
    return np.minimum(np.maximum(taken, -1.0), 1.0)
