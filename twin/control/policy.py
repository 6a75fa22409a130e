"""A learned policy as a controller: what it sees, how often it decides, and how it is loaded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.control.controllers import Seen, actions
from twin.errors import BadInput

Array = NDArray[np.float64]

DECISION_S = 0.2
"""Time between two decisions of a policy [s]; its actions hold in between."""
SMOOTHING_S = 1.0
"""Time constant of the slow slip a policy sees beside the slip [s]."""
THROTTLE, DEEPEST_M, RELIEF_M = (0.0, 1.0), 0.02, 0.20
"""What a policy's actions in [-1, 1] span: throttle, and the depth set point about the target."""
FEATURES = (
    "slip_error", "slow_slip_error", "speed", "wheel_speed", "depth_error", "engine_speed",
    "throttle", "lift_set", "slip_target", "depth_target",
)  # fmt: skip
"""What a policy sees; all of it stands in the observations "estimate" and "truth" alike."""


@dataclass(frozen=True)
class Memory:
    """What a policy keeps between control steps."""

    slow_slip: Array | None = None
    wait_s: float = 0.0
    actions: Array | None = None


def slow(before: Array | None, seen: Seen, period_s: float) -> Array:
    """Slip through a first-order low-pass of `SMOOTHING_S`."""
    slip = seen["slip"]
    if before is None:
        return np.array(slip)
    return np.asarray(before + (slip - before) * period_s / SMOOTHING_S)


def features(seen: Seen, slow_slip: Array) -> NDArray[np.float32]:
    """What a policy sees, of order one, (count, FEATURES)."""
    target, depth_m = seen["slip_target"], np.maximum(seen["depth_m"], 0.0)
    columns = (
        (seen["slip"] - target) / 0.1,
        (slow_slip - target) / 0.1,
        seen["speed_mps"] / 2.0 - 0.8,
        seen["wheel_speed_mps"] / 2.0 - 0.8,
        (depth_m - seen["depth_target_m"]) / 0.05,
        seen["engine_radps"] / 50.0 - 3.2,
        seen["throttle"],
        seen["lift_set_rad"] * 5.0,
        target * 5.0,
        seen["depth_target_m"] * 4.0,
    )
    return np.clip(np.stack(columns, axis=-1), -10.0, 10.0).astype(np.float32)


def meant(raw: NDArray[Any], seen: Seen) -> Array:
    """The environment's actions of a policy's: throttle, and depth about its target."""
    raw = np.clip(np.asarray(raw, dtype=np.float64), -1.0, 1.0)
    low, high = THROTTLE
    throttle = low + 0.5 * (raw[:, 0] + 1.0) * (high - low)
    offset_m = -RELIEF_M + 0.5 * (raw[:, 1] + 1.0) * (DEEPEST_M + RELIEF_M)
    return actions(throttle, seen["depth_target_m"] + offset_m)


@dataclass(frozen=True)
class Policy:
    """A model of stable-baselines3 that decides every `DECISION_S`."""

    model: Any

    def init(self, count: int) -> Memory:
        """Nothing seen yet."""
        return Memory()

    def act(self, state: Memory, seen: Seen, period_s: float) -> tuple[Memory, Array]:
        """One control step; a decision where one is due."""
        slow_slip, wait_s = slow(state.slow_slip, seen, period_s), state.wait_s - period_s
        taken = state.actions
        if taken is None or wait_s < 0.5 * period_s:
            raw, _ = self.model.predict(features(seen, slow_slip), deterministic=True)
            taken, wait_s = meant(raw, seen), DECISION_S
        return Memory(slow_slip, wait_s, taken), taken


def load(file: Path) -> Policy:
    """A policy saved by stable-baselines3 that sees the `FEATURES`.

    Raises:
        BadInput: stable-baselines3 is not installed, or the file is no such policy.
    """
    try:
        import stable_baselines3
    except ImportError:
        raise BadInput(
            f"--policy {file} needs stable-baselines3: pip install 'tractor-twin[rl]'"
        ) from None
    if not file.is_file():
        raise BadInput(f"--policy {file}: there is no such file")
    algorithms: Mapping[str, Any] = {
        n: getattr(stable_baselines3, n) for n in ("PPO", "SAC", "TD3", "A2C")
    }
    for algorithm in algorithms.values():
        try:
            model = algorithm.load(file, device="cpu")
        except Exception:  # a file of another algorithm fails in a way of its own
            continue
        if model.observation_space.shape == (len(FEATURES),):
            return Policy(model)
        raise BadInput(
            f"--policy {file}: sees {model.observation_space.shape}, not the {len(FEATURES)} "
            "features of twin.control.policy"
        )
    raise BadInput(f"--policy {file}: no policy of {', '.join(algorithms)}")
