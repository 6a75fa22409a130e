"""What other libraries do with the environments; a library that is absent is skipped."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv
from gymnasium.wrappers import RecordVideo

from twin.env import IDS

STEPS = 6


def made(name, **arguments):
    return gymnasium.make(f"twin.env:tractor_twin/{name}", **{"observation": "truth", **arguments})


def maker(name):
    return lambda: made(name, max_episode_steps=4)


def rolled(env, count, steps=STEPS):
    first = env.reset(seed=[1, 2])
    actions = np.random.default_rng(1).uniform(
        -1.0, 1.0, (steps, count, *env.single_action_space.shape)
    )
    return [first, *(env.step(each.astype(np.float32)) for each in actions)]


@pytest.mark.parametrize("name", IDS)
def test_gymnasium_s_check_passes(name):
    check_env(made(name).unwrapped, skip_render_check=True)


@pytest.mark.parametrize("name", IDS)
def test_the_check_of_stable_baselines3_passes(name):
    pytest.importorskip("stable_baselines3", reason="stable-baselines3 is not installed")
    from stable_baselines3.common.env_checker import check_env as their_check

    their_check(made(name).unwrapped, skip_render_check=True)


@pytest.mark.parametrize("name", IDS)
def test_sync_async_and_native_vectors_agree_to_the_bit(name):
    """Four steps, an autoreset in the next one, and on."""
    native = gymnasium.make_vec(
        f"twin.env:tractor_twin/{name}", num_envs=2, vectorization_mode="vector_entry_point",
        observation="truth", max_episode_steps=4,
    )  # fmt: skip
    sync = SyncVectorEnv([maker(name)] * 2)
    other = AsyncVectorEnv([maker(name)] * 2, context="fork")
    try:
        one, two, three = (rolled(env, 2) for env in (native, sync, other))
        assert native.unwrapped.np_random_seed == sync.np_random_seed == (1, 2)
    finally:
        other.close()
    for ours, *theirs in zip(one, two, three, strict=True):
        for each in theirs:
            for mine, yours in zip(ours[:-1], each[:-1], strict=True):
                np.testing.assert_array_equal(mine, yours)
            assert ours[-1].keys() == each[-1].keys()
            for key in ("slip", "soil.friction"):
                np.testing.assert_array_equal(ours[-1][key], each[-1][key])


def test_a_video_is_recorded(tmp_path):
    pytest.importorskip("moviepy", reason="moviepy, which writes videos, is not installed")
    env = RecordVideo(
        made("Plough-v0", render_mode="rgb_array", width=64, height=48), str(tmp_path / "videos"),
        video_length=3,
    )  # fmt: skip
    try:
        env.reset(seed=1)
    except gymnasium.error.DependencyNotInstalled as error:
        pytest.skip(f"no OpenGL here: {error}")
    for _ in range(4):
        env.step(np.zeros(2, dtype=np.float32))
    env.close()
    assert list((tmp_path / "videos").glob("*.mp4"))


@pytest.mark.filterwarnings("ignore::UserWarning")  # of what a data set should also name
@pytest.mark.parametrize("name", IDS)
def test_minari_collects_steps_with_their_infos(name, tmp_path, monkeypatch):
    minari = pytest.importorskip("minari", reason="minari is not installed")
    for needed in ("h5py", "jax"):
        pytest.importorskip(needed, reason=f"{needed}, which minari collects with, is absent")
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    env = minari.DataCollector(made(name, max_episode_steps=STEPS), record_infos=True)
    for seed in (1, 2):
        env.reset(seed=seed)
        for _ in range(STEPS):
            last = env.step(env.action_space.sample())
    dataset = env.create_dataset(f"tractor/{name.lower()}", algorithm_name="random")
    episodes = list(dataset.iterate_episodes())
    env.close()
    assert [len(each) for each in episodes] == [STEPS, STEPS]
    assert episodes[1].infos["slip"].shape == (STEPS + 1,)
    assert episodes[1].infos["slip"][-1] == last[-1]["slip"]
    assert "soil.friction" in episodes[0].infos


@pytest.mark.parametrize("name", IDS)
def test_stable_baselines3_trains_on_the_native_vector(name):
    pytest.importorskip("stable_baselines3", reason="stable-baselines3 is not installed")
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import VecMonitor

    from twin.env.sb3 import TractorVecEnv

    env = VecMonitor(TractorVecEnv(name, 3, observation="truth", max_episode_steps=5))
    model = PPO("MlpPolicy", env, n_steps=8, batch_size=8, n_epochs=1, device="cpu", seed=3)
    model.learn(24)
    assert len(model.ep_info_buffer) == 3
    assert all(each["l"] == 5 for each in model.ep_info_buffer)


def test_the_native_vector_is_the_vector_environment_with_ends_of_its_own():
    pytest.importorskip("stable_baselines3", reason="stable-baselines3 is not installed")
    from twin.env.sb3 import TractorVecEnv
    from twin.errors import BadInput

    native = gymnasium.make_vec(
        "twin.env:Plough-v0", num_envs=2, vectorization_mode="vector_entry_point",
        observation="truth", max_episode_steps=4, autoreset_mode="SAME_STEP",
        grounds=[{"soil.preset": "soft"}, {"soil.preset": "firm"}],
    )  # fmt: skip
    env = TractorVecEnv(
        "Plough-v0", 2, observation="truth", max_episode_steps=4,
        grounds=[{"soil.preset": "soft"}, {"soil.preset": "firm"}],
    )  # fmt: skip
    env.seed(1)
    first, _ = native.reset(seed=[1, 2])
    np.testing.assert_array_equal(env.reset(), first)
    assert [info["soil.preset"] for info in env.reset_infos] == ["soft", "firm"]
    actions = np.random.default_rng(1).uniform(-1.0, 1.0, (6, 2, 2)).astype(np.float32)
    for action in actions:
        seen, rewards, done, infos = env.step(action)
        theirs, worth, stalled, late, told = native.step(action)
        np.testing.assert_array_equal(seen, theirs)
        np.testing.assert_array_equal(rewards, worth.astype(np.float32))
        np.testing.assert_array_equal(done, stalled | late)
        for i in range(2):
            last = told["final_info"]["slip"][i] if done[i] else told["slip"][i]
            assert infos[i]["slip"] == last
            if done[i]:
                assert infos[i]["TimeLimit.truncated"]
                np.testing.assert_array_equal(
                    infos[i]["terminal_observation"], told["final_obs"][i]
                )
    assert env.get_attr("limit") == [4, 4]
    assert env.env_is_wrapped(gymnasium.Wrapper) == [False, False]
    env.set_options([{"soil.preset": "soft"}, {"soil.preset": "firm"}])
    with pytest.raises(BadInput, match="give them as grounds="):
        env.reset()
    with pytest.raises(BadInput, match="autoreset_mode cannot be given"):
        TractorVecEnv("Plough-v0", 2, autoreset_mode="NEXT_STEP")
