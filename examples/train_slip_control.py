"""Learn slip control with SAC or PPO, on two cores in under ten minutes.

    pip install '.[rl]'
    python examples/train_slip_control.py --env Plough-v0 --out plough.zip
    twin compare-controllers --env Plough-v0 --controllers pi,plough.zip

The policy learns what to add to a PI, by what it is ahead of the tuned PI, which drove over the
same training grounds before. Both see the truth there, blurred as the estimate was; the estimator
itself, which is many times slower, the policy meets first on the grounds that compare.
"""

import argparse
import time
from dataclasses import dataclass

import numpy as np
import torch
from gymnasium.spaces import Box
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.utils import LinearSchedule
from stable_baselines3.common.vec_env import VecEnv, VecMonitor

from twin.control import policy
from twin.control.trials import ENVIRONMENTS, TRAINING

SCALE, STALL = 5.0, 30.0
"""Factor on the rewards, and what a stall loses besides."""


@dataclass(frozen=True)
class Blur:
    """What an estimate is off by, as it was on training grounds."""

    bias: dict
    """Mean and sd of what stays for a whole episode."""
    sd: dict
    """sd of what comes and goes."""
    late: int = 0
    """Control steps it is late by."""
    kept: float = 0.0
    """Share of what comes and goes that is left after a control step."""


BLURS = {
    "Plough-v0": Blur(
        bias={"slip": (0.0015, 0.004), "depth_m": (-0.003, 0.0055)},
        sd={
            "slip": 0.006, "speed_mps": 0.009, "wheel_speed_mps": 0.016, "depth_m": 0.005,
            "draft_n": 1240.0,
        },
        late=2,
        kept=0.7,
    ),
    "WheelSlip-v0": Blur(
        bias={},
        sd={
            "slip": 0.007, "slip_rl": 0.015, "slip_rr": 0.015, "speed_mps": 0.02,
            "wheel_speed_mps": 0.01, "draft_n": 1000.0,
        },
    ),
}  # fmt: skip


class Blurred:
    """The truth of many tractors as a blur shows it."""

    def __init__(self, blur, count, noise):
        self.blur, self.count, self.noise = blur, count, noise
        self.past, self.bias = [], {name: np.zeros(count) for name in blur.bias}
        self.drift = {name: np.zeros(count) for name in blur.sd}

    def step(self, true):
        """What is seen a control step later."""
        self.past = [*self.past, true][-1 - self.blur.late :]
        fresh = np.sqrt(1.0 - self.blur.kept**2)
        for name, sd in self.blur.sd.items():
            new = fresh * sd * self.noise.standard_normal(self.count)
            self.drift[name] = self.blur.kept * self.drift[name] + new
        return self.seen()

    def begin(self, true, which):
        """What is seen where episodes begin, and by the others as before."""
        for name, (mean, sd) in self.blur.bias.items():
            drawn = mean + sd * self.noise.standard_normal(self.count)
            self.bias[name] = np.where(which, drawn, self.bias[name])
        self.past = [
            {name: np.where(which, true[name], value) for name, value in earlier.items()}
            for earlier in self.past or [true]
        ]
        return self.seen()

    def seen(self):
        seen = dict(self.past[-1])
        for name, off in self.drift.items():
            seen[name] = self.past[0][name] + off
        for name, off in self.bias.items():
            seen[name] = seen[name] + off
        return seen


def named(env, observation):
    """Observations of many tractors by their entries' names."""
    names = [entry.name for entry in env.entries]
    return dict(zip(names, observation.T.astype(float), strict=True))


def periods(env):
    """Length of a control step, and how many a decision lasts."""
    period_s = env.episodes.fleet.period_s
    return period_s, round(policy.DECISION_S / period_s)


def earned(env, controller, seeds, blurred, decisions):
    """Mean reward of a controller on each ground in the time of each decision."""
    period_s, repeat = periods(env)
    alive, total = np.ones(env.num_envs, dtype=bool), np.zeros((env.num_envs, decisions))
    observation, _ = env.reset(seed=seeds)
    state, seen = controller.init(env.num_envs), blurred.begin(named(env, observation), alive)
    for step in range(decisions * repeat):
        state, actions = controller.act(state, seen, period_s)
        observation, reward, stalled, _, _ = env.step(actions.astype(np.float32))
        alive &= ~stalled
        total[:, step // repeat] += np.where(alive, reward, 0.0) / repeat
        seen = blurred.step(named(env, observation))
    return total


class Grounds(VecEnv):
    """Tractors on training grounds, rewarded by what they are ahead of the tuned PI there.

    A step is one decision of the policy. The ground weighs ten times as heavily on the reward as
    anything a policy does; it falls out of the difference to what the PI earned on it.
    """

    def __init__(self, name, tractors, grounds, steps, seed):
        kind, baselines = ENVIRONMENTS[name]
        self.noise = np.random.default_rng(seed)
        self.seeds = TRAINING + 1000 * seed + np.arange(grounds)
        self.steps, self.task = steps, policy.TASKS[name]
        blurred = Blurred(BLURS[name], grounds, self.noise)
        before = kind(grounds, observation="truth")
        self.par = earned(before, baselines["pi"], self.seeds.tolist(), blurred, steps)
        self.env = kind(tractors, observation="truth", autoreset_mode="DISABLED")
        self.blurred = Blurred(BLURS[name], tractors, self.noise)
        self.period_s, self.repeat = periods(self.env)
        seen = Box(-10.0, 10.0, (self.task.size,), np.float32)
        super().__init__(tractors, seen, Box(-1.0, 1.0, (2,), np.float32))

    def reset(self):
        n = self.num_envs
        self.age, self.on = np.zeros(n, dtype=int), np.zeros(n, dtype=int)
        self.length = self.noise.integers(1, self.steps + 1, size=n)  # not all end at once
        self.base, self.slow = self.task.base.init(n), None
        self._begin(np.ones(n, dtype=bool))
        return self._features()

    def step_async(self, actions):
        self.wanted = actions

    def step_wait(self):
        n = self.num_envs
        gained, stalled = np.zeros(n), np.zeros(n, dtype=bool)
        par = self.par[self.on, self.age]
        last = np.zeros((n, self.task.size), dtype=np.float32)
        for _ in range(self.repeat):
            self.base, action = self.task.base.act(self.base, self.seen, self.period_s)
            action = policy.added(self.task, action, self.wanted)
            observation, reward, stands, _, _ = self.env.step(action.astype(np.float32))
            gained += np.where(stalled, 0.0, reward) / self.repeat
            stalled |= stands
            self._see(self.blurred.step(named(self.env, observation)))
            self._again(stands, last)
        self.age += ~stalled
        late = self.age >= self.length
        self._again(late, last)
        infos = [{} for _ in range(n)]
        for i in np.flatnonzero(late | stalled):
            infos[i] = {"terminal_observation": last[i], "TimeLimit.truncated": bool(late[i])}
        worth = SCALE * (gained - par) - np.where(stalled, STALL, 0.0)
        return self._features(), worth.astype(np.float32), late | stalled, infos

    def _again(self, which, last):
        """New grounds for some tractors, and what was seen last on the old ones."""
        if which.any():
            last[which] = self._features()[which]
            self.length[which] = self.steps
            self._begin(which)

    def _begin(self, which):
        self.on[which] = self.noise.integers(len(self.seeds), size=which.sum())
        self.age[which] = 0
        observation, _ = self.env.reset(
            seed=self.seeds[self.on].tolist(), options={"reset_mask": which}
        )
        self.base = np.where(which, self.task.base.init(self.num_envs), self.base)
        self._see(self.blurred.begin(named(self.env, observation), which), which)

    def _see(self, seen, fresh=None):
        self.seen = seen
        if fresh is None or self.slow is None:
            self.slow = policy.smoothed(self.task, self.slow, seen, self.period_s)
        else:
            self.slow = {n: np.where(fresh, seen[n], slow) for n, slow in self.slow.items()}

    def _features(self):
        return policy.features(self.task, self.seen, self.slow)

    def close(self):
        self.env.close()

    def get_attr(self, attr_name, indices=None):
        return [getattr(self, attr_name, None)] * self.num_envs

    def set_attr(self, attr_name, value, indices=None):
        setattr(self, attr_name, value)

    def env_method(self, method_name, *args, indices=None, **kwargs):
        raise NotImplementedError(method_name)

    def env_is_wrapped(self, wrapper_class, indices=None):
        return [False] * self.num_envs


class Budget(BaseCallback):
    """Ends training when the time is up; says now and then how it goes."""

    def __init__(self, minutes):
        super().__init__()
        self.seconds, self.told = 60.0 * minutes, 0.0

    def _on_training_start(self):
        self.start = time.perf_counter()

    def _on_step(self):
        now = time.perf_counter() - self.start
        if now > self.told + 30.0:
            self.told = now
            lately = [e["r"] / e["l"] / SCALE for e in self.model.ep_info_buffer]
            ahead = np.mean(lately) if lately else float("nan")
            decisions = self.num_timesteps
            print(f"{now:4.0f} s {decisions:8d} decisions, {ahead:+.4f} to the PI", flush=True)
        return now < self.seconds


def sac(fields, seed):
    """Learns from every decision many times: most for the fewest."""
    return SAC(
        "MlpPolicy", fields, seed=seed, device="cpu", learning_rate=LinearSchedule(5e-4, 1e-4, 1.0),
        gamma=0.95, learning_starts=20 * fields.num_envs, train_freq=1,
        gradient_steps=fields.num_envs // 2,
        ent_coef="auto_0.05", target_entropy=-4.0, policy_kwargs={"net_arch": [64, 64]},
    )  # fmt: skip


def ppo(fields, seed):
    """Begins at the PI and moves off it in small steps: where the PI leaves little to gain."""
    return PPO(
        "MlpPolicy", fields, seed=seed, device="cpu", n_steps=32, batch_size=512, n_epochs=10,
        learning_rate=LinearSchedule(5e-4, 1e-4, 1.0), gamma=0.9, gae_lambda=0.9, ent_coef=0.0,
        policy_kwargs={"net_arch": [64, 64], "log_std_init": -1.5},
    )  # fmt: skip


LEARNERS = {"Plough-v0": sac, "WheelSlip-v0": ppo}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--env", default="Plough-v0", choices=list(BLURS))
    parser.add_argument("--out", default="slip.zip")
    parser.add_argument("--decisions", type=int, default=90_000)
    parser.add_argument("--minutes", type=float, default=9.5, help="ends it before, if it must")
    parser.add_argument("--tractors", type=int, default=128)
    parser.add_argument("--grounds", type=int, default=256)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    torch.set_num_threads(1)  # small networks: more threads only wait for each other
    grounds = Grounds(asked.env, asked.tractors, asked.grounds, steps=100, seed=asked.seed)
    model = LEARNERS[asked.env](VecMonitor(grounds), asked.seed)
    model.learn(asked.decisions, callback=Budget(asked.minutes))
    model.save(asked.out)
    print(f"saved {asked.out} after {model.num_timesteps} decisions")


if __name__ == "__main__":
    main()
