"""The draft of the whole implement: a partition of ASABE D497's, and its statistics."""

import mujoco
import numpy as np
import pytest

from tests.simulation.rigs import EVEN_PLOUGHING, LEVEL_PLOUGHING, PLOUGHING, driven, replace
from twin.reproduce.passes import correlation_length_m
from twin.scenario import Course, Plough, Soil
from twin.simulation.build import build
from twin.simulation.simulate import simulate

DEPTHS_M = (0.15, 0.20, 0.25, 0.30)
LATE = slice(-4000, None)
SIDE_RATIO, DOWN_RATIO, DRAG_RATIO = 0.25, 0.20, 0.10


@pytest.mark.parametrize("scenario", [EVEN_PLOUGHING, LEVEL_PLOUGHING], ids=["furrow", "level"])
@pytest.mark.parametrize("depth_m", DEPTHS_M)
def test_shares_landsides_and_depth_wheel_pull_d497s_draft_together(scenario, depth_m):
    """F (A + C S**2) W T at the run's own speed and depth, within 1 %; firm soil, F 0.87."""
    scenario = replace(scenario, plough=replace(scenario.plough, depth_m=depth_m))
    c = {n: v[LATE] for n, v in driven(scenario).items()}
    kmh = 3.6 * np.linalg.norm(c["velocity_w"], axis=1)
    asabe = 0.87 * (652.0 + 5.1 * kmh**2) * 1.40 * 100.0 * c["depth_m"]
    assert c["draft_n"].mean() == pytest.approx(asabe.mean(), rel=0.01)


@pytest.mark.parametrize("depth_m", DEPTHS_M)
def test_down_and_side_force_are_their_ratios_of_what_the_shares_pull(depth_m):
    """V = 0.20 D; S = 0.25 D towards the land less the landsides' N, with 0 < N < 3 S."""
    scenario = replace(EVEN_PLOUGHING, plough=Plough(depth_m=depth_m, furrow="right"))
    c = {n: v[LATE].mean(axis=0) for n, v in driven(scenario).items()}
    shares = c["draft_n"] - DRAG_RATIO * c["depth_wheel_n"]
    assert c["depth_wheel_n"] - c["draft_w"][2] == pytest.approx(DOWN_RATIO * shares, rel=0.01)
    assert 0.15 < (c["depth_wheel_n"] - c["draft_w"][2]) / c["draft_n"] < 0.21
    side = SIDE_RATIO * shares
    assert 0.0 < c["landside_n"] < 3.0 * side
    # the furrow is on the right, the land on the left; draft itself has a part along the drift
    assert c["plough_side_n"] == pytest.approx(side - c["landside_n"], abs=0.01 * c["draft_n"])


def test_the_drag_of_the_depth_wheel_is_taken_from_the_shares():
    """Set to carry more, it drags more and the shares less: the sum is D497's all the same."""
    drafts, wheels = [], []
    for share in (0.2, 0.7):
        scenario = replace(
            LEVEL_PLOUGHING, plough=replace(LEVEL_PLOUGHING.plough, wheel_share=share)
        )
        c = {n: v[LATE].mean(axis=0) for n, v in driven(scenario).items()}
        kmh = 3.6 * c["velocity_w"][0]
        drafts.append(c["draft_n"] / ((652.0 + 5.1 * kmh**2) * 1.40 * 100.0 * c["depth_m"]))
        wheels.append(c["depth_wheel_n"])
    assert wheels[1] > wheels[0] + 3e3
    assert drafts[1] == pytest.approx(drafts[0], rel=0.002)


@pytest.mark.slow
def test_the_draft_varies_as_measured_draft_does():
    """CV 8-13 %, correlation length 2-5 m; 150 m at 25 cm, seed by seed and on the mean."""
    spreads, lengths = [], []
    for seed in range(4):
        course = Course(approach_m=3.0, length_m=150.0)
        chunks = simulate(build(replace(PLOUGHING, course=course, seed=seed, soil=Soil())))
        c = list(chunks)
        along = np.concatenate([k["position_w"][:, 0] for k in c])
        draft = np.concatenate([k["draft_n"] for k in c])[along > 15.0][::10]
        speed = np.concatenate([k["velocity_w"][:, 0] for k in c])[along > 15.0]
        spreads.append(draft.std() / draft.mean())
        lengths.append(correlation_length_m(draft, speed.mean()))
    assert 0.08 < np.mean(spreads) < 0.13
    assert all(0.07 < s < 0.15 for s in spreads)
    assert 2.0 < np.mean(lengths) < 5.0
    assert all(1.5 < length < 6.0 for length in lengths)


def test_rocks_pull_and_the_tractor_feels_them():
    """The pulses stand out of the draft of even soil, each share's at its own places."""
    even = driven(EVEN_PLOUGHING)
    rocky = driven(replace(EVEN_PLOUGHING, soil=replace(EVEN_PLOUGHING.soil, rocks_per_100m2=10.0)))
    n = min(len(even["draft_n"]), len(rocky["draft_n"]))
    late = slice(n // 2, n)
    assert even["draft_n"][late].max() < 1.02 * even["draft_n"][late].mean()
    assert rocky["draft_n"].max() > even["draft_n"][late].mean() + 12e3
    again = list(
        simulate(
            build(replace(EVEN_PLOUGHING, soil=replace(EVEN_PLOUGHING.soil, rocks_per_100m2=10.0)))
        )
    )
    assert np.array_equal(np.concatenate([c["draft_n"] for c in again]), rocky["draft_n"])


def test_a_raised_plough_pulls_nothing():
    machine = build(LEVEL_PLOUGHING)
    data = mujoco.MjData(machine.model)
    data.qpos[:] = machine.start_qpos
    mujoco.mj_forward(machine.model, data)
    columns = driven(LEVEL_PLOUGHING)
    approach = columns["position_w"][:, 0] < 2.5
    for name in ("draft_n", "depth_m", "landside_n", "depth_wheel_n"):
        assert not np.any(columns[name][approach]), name
