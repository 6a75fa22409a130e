"""A learned policy as a controller: it adds to a PI what it has learned that is missing.

    action = clip(PI's action + reach * raw),  raw in [-1, 1] decided every `DECISION_S`

so that an untrained policy of zeros is the PI. Source of the form: Johannink et al. 2019, residual
reinforcement learning for robot control.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.control.controllers import PI, Controller, Seen, draft_n
from twin.control.fieldwork import FIELD_BASELINES
from twin.control.torques import TORQUE_BASELINES
from twin.control.traction import TRACTION_BASELINES
from twin.env.reward import SLIP_LIMIT

Array = NDArray[np.float64]

DECISION_S = 0.2
"""Time between two decisions of a policy [s]; what it adds holds in between."""
SMOOTHING_S = 1.0
"""Time constant of the slow slips a policy sees beside the slips [s]."""


def _at_work(seen: Seen, slow: Seen, slip: Array | float) -> list[Array]:
    """Slips about one, speeds, depth, draft, engine and throttle of a tractor that ploughs."""
    depth_m = np.maximum(seen["depth_m"], 0.0)
    return [
        (seen["slip"] - slip) / 0.1,
        (slow["slip"] - slip) / 0.1,
        seen["speed_mps"] / 2.0 - 0.8,
        seen["wheel_speed_mps"] / 2.0 - 0.8,
        (depth_m - seen["depth_target_m"]) / 0.05,
        draft_n(seen) / 2e4,
        seen["engine_radps"] / 50.0 - 3.2,
        seen["throttle"],
    ]


def plough_features(seen: Seen, slow: Seen) -> list[Array]:
    """Slip, speeds, depth, draft, engine and controls of Plough-v0."""
    target = seen["slip_target"]
    return [
        *_at_work(seen, slow, target),
        seen["lift_set_rad"] * 5.0,
        target * 5.0,
        seen["depth_target_m"] * 4.0,
    ]


def torque_features(seen: Seen, slow: Seen) -> list[Array]:
    """Slips, speeds and torques of WheelSlip-v0."""
    target = seen["slip_target"]
    wheels = ("slip_rl", "slip_rr")
    return [
        *((seen[wheel] - target) / 0.1 for wheel in wheels),
        *((slow[wheel] - target) / 0.1 for wheel in wheels),
        seen["speed_mps"] - 1.3,
        seen["wheel_speed_mps"] - 1.5,
        seen["torque_left"],
        seen["torque_right"],
        target * 5.0,
    ]


def field_features(seen: Seen, slow: Seen) -> list[Array]:
    """Slip, speeds, depth, draft, engine and levers of Plough-v1."""
    return [
        *_at_work(seen, slow, SLIP_LIMIT),
        seen["gear_kmh"] / 5.0 - 1.6,
        seen["lift_set_rad"] * 5.0,
        seen["mix"],
    ]


def traction_features(seen: Seen, slow: Seen) -> list[Array]:
    """Slips, speeds, torques and the line of WheelSlip-v1."""
    wheels = ("slip_rl", "slip_rr")
    return [
        *((seen[wheel] - 0.1) / 0.1 for wheel in wheels),
        *((slow[wheel] - 0.1) / 0.1 for wheel in wheels),
        seen["speed_mps"] - 1.3,
        seen["wheel_speed_mps"] - 1.5,
        seen["torque_left"],
        seen["torque_right"],
        seen["line_left_m"] / 0.2,
        seen["line_heading_rad"] / 0.1,
    ]


@dataclass(frozen=True)
class Task:
    """What a policy is for, and what it adds to."""

    base: Controller
    reach: tuple[float, ...]
    """Most that is added to each action."""
    features: Callable[[Seen, Seen], list[Array]]
    """Features that a policy sees, of entries that are in "estimate" and in "truth"."""
    size: int
    """Number of features."""
    slow: tuple[str, ...]
    """Entries that the policy also sees smoothed."""


CALM = PI(throttle=0.939, trim_m=-0.0426, kp_m=0.8, ki_mps=0.035)
"""A PI of about 0.3 times the tuned gain: it neither shakes the hitch nor lifts the plough further
on hopeless ground than a policy can put it down again."""

TASKS = {
    "Plough-v0": Task(CALM, (0.6, 0.5), plough_features, 11, ("slip",)),
    "WheelSlip-v0": Task(
        TORQUE_BASELINES["pi"],
        (0.1, 0.1),
        torque_features,
        9,
        ("slip_rl", "slip_rr"),
    ),
    "Plough-v1": Task(FIELD_BASELINES["pi"], (0.6, 0.4, 0.2, 0.4), field_features, 11, ("slip",)),
    "WheelSlip-v1": Task(
        TRACTION_BASELINES["pi"], (0.3, 0.3), traction_features, 10, ("slip_rl", "slip_rr")
    ),
}


@dataclass(frozen=True)
class Memory:
    """What a policy keeps between control steps."""

    base: Any
    slow: Mapping[str, Array] | None = None
    wait_s: float = 0.0
    raw: Array | None = None


def smoothed(
    task: Task, before: Mapping[str, Array] | None, seen: Seen, period_s: float
) -> dict[str, Array]:
    """The task's slow slips: through a first-order low-pass of `SMOOTHING_S`."""
    if before is None:
        return {name: np.array(seen[name]) for name in task.slow}
    share = period_s / SMOOTHING_S
    return {name: before[name] + share * (seen[name] - before[name]) for name in task.slow}


def features(task: Task, seen: Seen, slow: Mapping[str, Array]) -> NDArray[np.float32]:
    """What a policy sees, of order one, (count, size)."""
    columns = np.stack(task.features(seen, slow), axis=-1)
    return np.clip(columns, -10.0, 10.0).astype(np.float32)


def added(task: Task, actions: Array, raw: Array) -> Array:
    """A base's actions and what a policy adds, (count, 2) in [-1, 1]."""
    total = actions + np.array(task.reach) * np.clip(raw, -1.0, 1.0)
    return np.asarray(np.clip(total, -1.0, 1.0), dtype=np.float64)


@dataclass(frozen=True)
class Policy:
    """A model of stable-baselines3 that adds to a base every `DECISION_S`."""

    model: Any
    task: Task

    def init(self, count: int) -> Memory:
        """Nothing seen yet."""
        return Memory(self.task.base.init(count))

    def act(self, state: Memory, seen: Seen, period_s: float) -> tuple[Memory, Array]:
        """One control step; a decision where one is due."""
        slow = smoothed(self.task, state.slow, seen, period_s)
        base, actions = self.task.base.act(state.base, seen, period_s)
        raw, wait_s = state.raw, state.wait_s - period_s
        if raw is None or wait_s < 0.5 * period_s:
            decided, _ = self.model.predict(features(self.task, seen, slow), deterministic=True)
            raw, wait_s = np.asarray(decided, dtype=np.float64), DECISION_S
        return Memory(base, slow, wait_s, raw), added(self.task, actions, raw)
