"""Linear model predictive control of slip and depth, with draft and pull of the soil estimated."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from twin.control.controllers import MOST_RELIEF_M, Array, Gain, Seen, actions, draft_n

HORIZON, STEP_S = 10, 0.15
"""Steps of the prediction, and the length of each [s]; a decision holds for one."""
STIFFNESS = 7.0
"""k of the thrust's growth with slip (Brixius 1987: about 7 at a wheel number of 30)."""
HITCH_S, SLIP_S = 0.35, 0.25
"""Time constants of the depth behind its set point, and of the slip behind the depth [s]."""
DEPTH_SCALE_M, SLIP_SCALE = 0.03, 0.05
"""Errors that cost 1."""
SHALLOWEST_M, LEAST_SLIP = 0.08, 0.02
"""Below these, draft and pull are not estimated."""
ITERATIONS = 25
"""Of the projected gradient."""


class Predicted(NamedTuple):
    """What the controller remembers of each tractor (count,)."""

    wait_s: float
    set_m: Array
    """Depth set point over the trim."""
    draft_npm: Array
    """Draft per depth, estimated."""
    grip_n: Array
    """Pull at large slip, estimated: friction times load."""


@dataclass(frozen=True, kw_only=True)
class PredictiveSlip:
    """Quadratic programme over the depth set points u of the next 1.5 s, solved every 0.15 s.

        d' = (u - d) / 0.35 s      s' = (s(d) - s) / 0.25 s      s(d) = -ln(1 - c d / T) / k
        min sum ((s - s*) / 0.05)^2 w + ((d - d*) / 0.03 m)^2 + ((u - u_before) / 0.03 m)^2 r
        with d* - 0.15 m <= u <= d*, and s(d) linear about the depth now

    d is the depth, s the slip, * a target, ' the time derivative, u_before the last set point. The
    first u plus `trim_m` is applied. c = draft / depth [N/m] and T = draft / (1 - exp(-k s)), the
    pull at large slip [N], are low-passed estimates. w is 0 where the measured slip is below
    s* - 0.02, so slip that far below its target costs nothing.
    Source: Maciejowski 2002, Predictive Control with Constraints, chapters 2 and 3; thrust's form
    Brixius 1987.
    """

    throttle: Gain
    trim_m: Gain
    slip_weight: Gain
    """w."""
    move_weight: Gain
    """r."""
    learn_s: Gain
    """Time constant of both estimates [s]."""

    def init(self, count: int) -> Predicted:
        """At the full depth, on ground that is firm."""
        return Predicted(0.0, np.full(count, np.nan), np.full(count, 8e4), np.full(count, 5e4))

    def act(self, state: Predicted, seen: Seen, period_s: float) -> tuple[Predicted, Array]:
        """One period; a new plan every 0.15 s."""
        target_m = seen["depth_target_m"]
        set_m = np.where(np.isnan(state.set_m), target_m, state.set_m)
        draft_npm, grip_n = self._learned(state, seen, period_s)
        wait_s = state.wait_s - period_s
        if wait_s < 0.5 * period_s:
            set_m, wait_s = self._planned(seen, set_m, draft_npm, grip_n), STEP_S
        new = Predicted(wait_s, set_m, draft_npm, grip_n)
        return new, actions(self.throttle, set_m + self.trim_m)

    def _learned(self, state: Predicted, seen: Seen, period_s: float) -> tuple[Array, Array]:
        """Draft per depth and grip, as the last samples say."""
        draft, depth, slip = draft_n(seen), seen["depth_m"], seen["slip"]
        share = np.minimum(1.0, period_s / self.learn_s)
        tells = (depth > SHALLOWEST_M) & (slip > LEAST_SLIP) & (draft > 1e3)
        per_m = draft / np.maximum(depth, SHALLOWEST_M)
        grip = draft / -np.expm1(-STIFFNESS * np.maximum(slip, LEAST_SLIP))
        return (
            np.where(tells, state.draft_npm + share * (per_m - state.draft_npm), state.draft_npm),
            np.where(tells, state.grip_n + share * (grip - state.grip_n), state.grip_n),
        )

    def _planned(self, seen: Seen, before_m: Array, draft_npm: Array, grip_n: Array) -> Array:
        """The first depth set point of the best plan (count,)."""
        depth, target_m = np.maximum(seen["depth_m"], 0.0), seen["depth_target_m"]
        used = np.clip(draft_npm * depth / grip_n, 0.0, 0.95)
        settled = -np.log1p(-used) / STIFFNESS
        slope = draft_npm / grip_n / (1.0 - used) / STIFFNESS  # ds/dd where it is now
        free, of_set = _predictions(depth, seen["slip"], settled, slope)
        wanted = np.stack([target_m, seen["slip_target"]], axis=-1)[:, :, None]
        error = wanted - free  # (count, 2, HORIZON)
        over = seen["slip"] > seen["slip_target"] - 0.02
        weight = np.stack(
            [np.full(len(depth), DEPTH_SCALE_M**-2),
             np.where(over, self.slip_weight, 0.0) * SLIP_SCALE**-2], axis=-1,
        )  # fmt: skip
        weighted = of_set * weight[:, :, None, None]
        hessian = np.einsum("cqij,cqik->cjk", weighted, of_set)
        linear = -np.einsum("cqij,cqi->cj", weighted, error)
        moving = np.asarray(self.move_weight) * DEPTH_SCALE_M**-2 + np.zeros(len(depth))
        hessian += moving[:, None, None] * DIFFERENCES.T @ DIFFERENCES
        linear -= moving[:, None] * before_m[:, None] * DIFFERENCES[0]
        return bounded_minimum(hessian, linear, target_m - MOST_RELIEF_M, target_m, before_m)[:, 0]


DIFFERENCES = np.eye(HORIZON) - np.eye(HORIZON, k=-1)
"""Of consecutive set points; the first is that to the one before."""


def _predictions(depth: Array, slip: Array, settled: Array, slope: Array) -> tuple[Array, Array]:
    """Depth and slip over the horizon: without any set point, and by each of them.

    Returns:
        Shapes (count, 2, HORIZON) and (count, 2, HORIZON, HORIZON).
    """
    keep_d, keep_s = np.exp(-STEP_S / HITCH_S), np.exp(-STEP_S / SLIP_S)
    count = len(depth)
    free = np.empty((count, 2, HORIZON))
    of_set = np.zeros((count, 2, HORIZON, HORIZON))
    now_d, now_s, by_d, by_s = depth, slip, np.zeros((count, HORIZON)), np.zeros((count, HORIZON))
    for i in range(HORIZON):
        now_d, by_d = keep_d * now_d, keep_d * by_d
        by_d[:, i] += 1.0 - keep_d
        towards = settled + slope * (now_d - depth)
        now_s = keep_s * now_s + (1.0 - keep_s) * towards
        by_s = keep_s * by_s + (1.0 - keep_s) * slope[:, None] * by_d
        free[:, 0, i], free[:, 1, i] = now_d, now_s
        of_set[:, 0, i], of_set[:, 1, i] = by_d, by_s
    return free, of_set


def bounded_minimum(hessian: Array, linear: Array, low: Array, high: Array, start: Array) -> Array:
    """Minimum of u'Hu/2 + g'u within low <= u <= high, by Nesterov's projected gradient.

    Args:
        hessian: H, positive definite (count, n, n).
        linear: g (count, n).
        low, high: the same for all n (count,).
        start: where to begin (count,).
    """
    step = 1.0 / np.abs(hessian).sum(axis=-1).max(axis=-1)[:, None]
    last = now = np.repeat(start[:, None], linear.shape[1], axis=1)
    for i in range(ITERATIONS):
        ahead = now + i / (i + 3.0) * (now - last)
        gradient = np.einsum("cij,cj->ci", hessian, ahead) + linear
        last, now = now, np.clip(ahead - step * gradient, low[:, None], high[:, None])
    return np.asarray(now)
