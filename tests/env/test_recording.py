"""Recordings of episodes: what is in them, and when they are written."""

import subprocess
import sys

import gymnasium
import numpy as np
import pytest

from twin.env import IDS
from twin.env.recording import Recording
from twin.viz import paths


def told(file):
    command = [sys.executable, "-m", "rerun", "rrd", "print", str(file)]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


@pytest.mark.slow
@pytest.mark.parametrize("name", IDS)
def test_an_episode_is_recorded_with_tractor_actions_and_reward(name, tmp_path):
    env = Recording(
        gymnasium.make(f"twin.env:{name}", observation="estimate", max_episode_steps=60), tmp_path
    )
    env.reset(seed=1, options={"field.patches": [(5.0, 3.0, 0.7, 0.8)]})
    action = np.full(env.action_space.shape, 0.5, dtype=np.float32)
    ends = [env.step(action)[3] for _ in range(60)]
    assert ends[-1]
    assert [file.name for file in tmp_path.iterdir()] == ["episode_0.rrd"]
    env.reset(seed=2)
    env.reset(seed=3)  # nothing happened in the one before
    env.step(0.0 * action)
    env.close()
    assert sorted(file.name for file in tmp_path.iterdir()) == ["episode_0.rrd", "episode_1.rrd"]
    said = told(tmp_path / "episode_0.rrd")
    episodes = env.unwrapped.episodes
    for entity in (
        f"{paths.TRACTOR}/tractor", paths.PATH, paths.GROUND, f"{paths.SLIP}/truth",
        f"{paths.SLIP}/seen",
        *(f"{paths.ACTIONS}/{action}" for action in episodes.actions_named),
        *(f"{paths.REWARD}/{term}" for term in episodes.terms),
    ):  # fmt: skip
        assert f"/{entity}" in said, entity


def test_what_is_recorded_is_what_was_true(tmp_path, monkeypatch):
    """Slip, draft, speed and place at every control step are those of the infos and the state."""
    runs = []
    monkeypatch.setattr("twin.viz.record", lambda run, path, **shown: runs.append((run, shown)))
    env = Recording(gymnasium.make("twin.env:WheelSlip-v0", observation="truth"), tmp_path)
    env.reset(seed=1)
    infos, places, rewards = [], [], []
    for _ in range(20):
        *_, info = env.step(np.array([0.6, 0.5], dtype=np.float32))
        infos.append(info)
        rewards.append(info["reward_sideslip"])
        places.append(env.unwrapped.episodes.fleet.qpos[0, :3].copy())
    env.close()
    (run, shown), true = runs[0], runs[0][0].truth
    assert true["epoch_ns"][-1] == 20 * 20_000_000
    for name in ("slip", "slip_rl", "speed_mps", "draft_n"):
        np.testing.assert_allclose(true[name][1:], [info[name] for info in infos], rtol=1e-9)
    position = np.stack([true[name] for name in ("east_m", "north_m", "up_m")], axis=1)
    np.testing.assert_allclose(position[1:], places, atol=1e-9)
    np.testing.assert_array_equal(shown["control"]["reward_sideslip"][1:], rewards)
    np.testing.assert_allclose(shown["control"]["torque_left"][1:], 0.6, atol=1e-6)
    assert run.estimates == {}
