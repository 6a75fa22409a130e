"""Learn slip control with SAC or PPO, on two cores in under ten minutes.

    pip install 'tractor-twin[rl]'
    python examples/train_slip_control.py --env Plough-v0 --out plough.zip
    twin compare-controllers --env Plough-v0 --policy plough.zip

The policy learns what to add to the tuned PI. It is trained on the truth of training
grounds, blurred as the estimate was there; it meets the estimator itself, which is many times
slower, first on the grounds that compare.
"""

import argparse
import time

import numpy as np
import torch
from gymnasium.spaces import Box
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv, VecMonitor

from twin.control import policy
from twin.control.trials import ENVIRONMENTS, TRAINING

GAMMA, SCALE, STALL = 0.9, 5.0, 30.0
USUAL = {"Plough-v0": 0.79, "WheelSlip-v0": 0.82}
"""Rewards are learned as what they are above the usual, scaled; a stall loses that for good."""
BIAS = {"Plough-v0": {"slip": (0.0015, 0.004), "depth_m": (-0.003, 0.0055)}, "WheelSlip-v0": {}}
"""Mean and sd of what an estimate is off by for a whole episode."""
NOISE = {
    "Plough-v0": {
        "slip": 0.006, "speed_mps": 0.009, "wheel_speed_mps": 0.016, "depth_m": 0.005,
        "draft_n": 1240.0,
    },
    "WheelSlip-v0": {
        "slip": 0.007, "slip_rl": 0.015, "slip_rr": 0.015, "speed_mps": 0.02,
        "wheel_speed_mps": 0.01, "draft_n": 1000.0,
    },
}  # fmt: skip
"""sd of what it is off by besides, drawn anew in each control step."""


class Fields(VecEnv):
    """A vector environment as stable-baselines3 wants it; a step is one decision of the policy."""

    def __init__(self, name, tractors, steps, seed):
        kind = ENVIRONMENTS[name][0]
        self.env = kind(tractors, observation="truth", autoreset_mode="DISABLED")
        self.task, self.usual = policy.TASKS[name], USUAL[name]
        self.biases, self.sds = BIAS[name], NOISE[name]
        self.names = [entry.name for entry in self.env.entries]
        self.period_s = self.env.episodes.fleet.period_s
        self.repeat = round(policy.DECISION_S / self.period_s)
        self.steps, self.noise = steps, np.random.default_rng(seed)
        self.first = TRAINING + 1000 * seed
        seen = Box(-10.0, 10.0, (self.task.size,), np.float32)
        super().__init__(tractors, seen, Box(-1.0, 1.0, (2,), np.float32))

    def reset(self):
        observation, _ = self.env.reset(seed=self.first)
        self.age = self.noise.integers(self.steps, size=self.num_envs)  # not all end at once
        self.slow, self.base = None, self.task.base.init(self.num_envs)
        self.bias = {}
        return self._features(observation)

    def step_async(self, actions):
        self.wanted = actions

    def step_wait(self):
        reward, ended = np.zeros(self.num_envs), np.zeros(self.num_envs, dtype=bool)
        for _ in range(self.repeat):
            self.base, action = self.task.base.act(self.base, self.seen, self.period_s)
            action = policy.added(self.task, action, self.wanted).astype(np.float32)
            observation, value, stalled, _, _ = self.env.step(action)
            reward, ended = reward + np.where(ended, 0.0, value), ended | stalled
            last = self._features(observation)
            if stalled.any():
                observation = self._again(stalled)
        self.age += 1
        over = (self.age >= self.steps) & ~ended
        infos = [{} for _ in range(self.num_envs)]
        for i in np.flatnonzero(over | ended):
            infos[i] = {"terminal_observation": last[i], "TimeLimit.truncated": bool(over[i])}
        now = last
        if over.any():
            observation = self._again(over)
        if (over | ended).any():
            self.age[over | ended] = 0
            now = self._features(observation, fresh=over | ended)
        worth = SCALE * (reward / self.repeat - self.usual)
        worth -= np.where(ended, STALL, 0.0)
        return now, worth.astype(np.float32), over | ended, infos

    def _again(self, mask):
        return self.env.reset(options={"reset_mask": mask})[0]

    def _features(self, observation, fresh=None):
        values = dict(zip(self.names, observation.T.astype(float), strict=True))
        self._lean(values, False if fresh is None else fresh)
        for name, sd in self.sds.items():
            values[name] = values[name] + sd * self.noise.standard_normal(self.num_envs)
        self.seen = values
        self.slow = policy.smoothed(self.task, self.slow, values, self.period_s)
        if fresh is not None:
            self.slow = {n: np.where(fresh, values[n], slow) for n, slow in self.slow.items()}
            begun = self.task.base.init(self.num_envs)
            self.base = np.where(fresh, begun, self.base)
        return policy.features(self.task, values, self.slow)

    def _lean(self, values, fresh):
        """Add an episode's biases, drawn anew where one begins."""
        for name, (mean, sd) in self.biases.items():
            drawn = mean + sd * self.noise.standard_normal(self.num_envs)
            self.bias[name] = np.where(fresh, drawn, self.bias.get(name, drawn))
            values[name] = values[name] + self.bias[name]

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

    def __init__(self, minutes, usual):
        super().__init__()
        self.usual = usual
        self.seconds, self.told = 60.0 * minutes, 0.0

    def _on_training_start(self):
        self.start = time.perf_counter()

    def _on_step(self):
        now = time.perf_counter() - self.start
        if now > self.told + 30.0:
            self.told = now
            lately = [self.usual + e["r"] / e["l"] / SCALE for e in self.model.ep_info_buffer]
            reward = np.mean(lately) if lately else float("nan")
            print(
                f"{now:4.0f} s {self.num_timesteps:8d} decisions, reward {reward:.4f}", flush=True
            )
        return now < self.seconds


def sac(fields, tractors, seed):
    """Learns from every decision many times: most for the fewest."""
    return SAC(
        "MlpPolicy", fields, seed=seed, device="cpu", learning_rate=5e-4, gamma=GAMMA,
        learning_starts=20 * tractors, train_freq=1, gradient_steps=tractors // 2,
        ent_coef="auto_0.05", target_entropy=-4.0, policy_kwargs={"net_arch": [64, 64]},
    )  # fmt: skip


def ppo(fields, tractors, seed):
    """Begins at the PI and moves off it in small steps: where the PI leaves little to gain."""
    return PPO(
        "MlpPolicy", fields, seed=seed, device="cpu", n_steps=32, batch_size=512, n_epochs=10,
        learning_rate=5e-4, gamma=GAMMA, gae_lambda=0.9, ent_coef=0.0,
        policy_kwargs={"net_arch": [64, 64], "log_std_init": -1.5},
    )  # fmt: skip


LEARNERS = {"Plough-v0": sac, "WheelSlip-v0": ppo}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--env", default="Plough-v0", choices=list(USUAL))
    parser.add_argument("--out", default="slip.zip")
    parser.add_argument("--decisions", type=int, default=80_000)
    parser.add_argument("--minutes", type=float, default=9.5, help="ends it before, if it must")
    parser.add_argument("--tractors", type=int, default=64)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    torch.set_num_threads(1)  # small networks: more threads only wait for each other
    fields = VecMonitor(Fields(asked.env, asked.tractors, steps=100, seed=asked.seed))
    model = LEARNERS[asked.env](fields, asked.tractors, asked.seed)
    model.learn(asked.decisions, callback=Budget(asked.minutes, USUAL[asked.env]))
    model.save(asked.out)
    print(f"saved {asked.out} after {model.num_timesteps} decisions")


if __name__ == "__main__":
    main()
