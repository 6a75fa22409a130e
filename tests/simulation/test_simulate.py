"""A drive repeats to the bit, however it is cut; it ends, wherever it gets stuck."""

import itertools

import numpy as np
import pytest

from tests.simulation.rigs import BARE, LEVEL_PLOUGHING, PLOUGHING, driven, field, replace, soiled
from twin.scenario import Course, Drive, Driver, Field, Plough, Scenario
from twin.simulation.build import build
from twin.simulation.columns import Recorder
from twin.simulation.guard import Diverged
from twin.simulation.simulate import simulate


def joined(scenario, **how):
    chunks = list(simulate(build(scenario), **how))
    epochs = np.concatenate([c.epoch_ns for c in chunks])
    return epochs, {n: np.concatenate([c[n] for c in chunks]) for n in chunks[0].columns}


def same(a, b):
    return all(np.array_equal(a[n], b[n], equal_nan=True) for n in a)


def test_the_same_seed_drives_the_same_and_another_does_not():
    scenario = soiled(PLOUGHING, strength_cv=0.0)
    first, again = joined(scenario), joined(scenario)
    assert np.array_equal(first[0], again[0])
    assert same(first[1], again[1])
    other = joined(replace(scenario, seed=5))
    n = min(len(first[0]), len(other[0]))
    assert not np.array_equal(first[1]["draft_n"][:n], other[1]["draft_n"][:n])
    assert np.array_equal(first[1]["slip"][:500], other[1]["slip"][:500])  # before it ploughs


@pytest.mark.parametrize("decisions", [1, 7])
def test_chunks_of_any_length_are_the_same_drive(decisions):
    whole, cut = joined(PLOUGHING), joined(PLOUGHING, chunk_decisions=decisions)
    assert np.array_equal(whole[0], cut[0])
    assert same(whole[1], cut[1])


def test_epochs_are_the_physics_grid_without_a_gap():
    epochs, _ = joined(BARE)
    assert epochs[0] == 0
    assert np.all(np.diff(epochs) == 2_000_000)


def test_columns_describe_one_epoch():
    """MuJoCo steps positions with the new velocity: x[k+1] - x[k] = dt v[k+1], to rounding."""
    _, c = joined(LEVEL_PLOUGHING)
    velocity = np.diff(c["position_w"], axis=0) / 0.002
    assert np.abs(velocity - c["velocity_w"][1:]).max() < 1e-9
    assert np.abs(velocity - c["velocity_w"][:-1]).max() > 1e-4  # one step off would be seen
    rate = np.diff(c["wheel_angle_rad"], axis=0) / 0.002
    assert np.abs(rate - c["wheel_rate_radps"][1:]).max() < 1e-9
    # the slots are of the same epoch as the sensors: hub and body move as one on a straight line
    hub = c["wheel_speed_x_mps"][:, 2:].mean(axis=1)
    ahead = c["velocity_w"][:, 0]
    assert np.abs(hub - ahead).max() < 0.3 * np.abs(np.diff(ahead)).max() + 1e-3
    rim = c["spin_radps"] * c["rolling_radius_m"]
    v = c["wheel_speed_x_mps"]
    slip = (rim - v) / np.maximum(np.maximum(np.abs(rim), np.abs(v)), 0.05)
    assert slip == pytest.approx(c["slip"], abs=1e-12)


def test_it_ploughs_at_its_depth_and_on_its_line():
    c = driven(PLOUGHING)
    late = slice(-3000, None)
    assert c["depth_m"][late].mean() == pytest.approx(0.25, abs=0.01)
    assert np.abs(c["position_w"][late, 1]).max() < 0.2
    assert 0.05 < c["slip"][late, 2:].mean() < 0.25


STUCK = {
    "spins its wheels": soiled(PLOUGHING, cone_index_kpa=50.0),
    "stalls the engine": replace(PLOUGHING, drive=Drive(gear_ratio=20.0)),
    "slides down backwards": field(soiled(BARE, friction=0.1), grade_deg=15.0),
    "slides aside": field(soiled(BARE, friction=0.1), cross_slope_deg=25.0),
    "never reaches its depth": replace(PLOUGHING, plough=Plough(depth_m=0.05, wheel_share=1.0)),
}


@pytest.mark.parametrize("how", STUCK)
def test_every_drive_ends(how):
    scenario = replace(STUCK[how], course=Course(approach_m=2.0, length_m=5.0))
    try:
        chunks = list(itertools.islice(simulate(build(scenario)), 61))
    except Diverged:
        return  # an end with a reason
    assert len(chunks) <= 60


def test_a_stalled_tractor_may_rock_but_does_not_drive_backwards():
    scenario = replace(STUCK["stalls the engine"], course=Course(approach_m=2.0, length_m=50.0))
    _, c = joined(scenario)
    along = c["position_w"][:, 0]
    assert np.max(np.maximum.accumulate(along) - along) < 0.05
    assert c["engine_radps"][-2000:].mean() < 0.5 * 800.0 * np.pi / 30.0  # below half idle


def test_the_recorder_counts_epochs_across_chunks():
    machine = build(BARE)
    recorder = Recorder(machine)
    first = next(iter(simulate(machine, chunk_decisions=2)))
    assert len(first) == 20
    assert recorder.time_s == 0.0


@pytest.mark.slow
def test_the_line_is_held_on_a_fast_road_with_the_plough_up():
    """A raised plough takes load off the front wheels; a short look ahead then swings wider."""
    road = Scenario(
        name="test-road", plough=Plough(depth_m=0.22), field=Field(roughness_class="C"),
        course=Course(passes=2, length_m=200.0, road_m=300.0),
        driver=Driver(shifts=True, road_kmh=30.0),
    )  # fmt: skip
    chunks = itertools.takewhile(lambda c: c.epoch_ns[-1] < 40e9, simulate(build(road)))
    place, velocity = (
        np.concatenate(each)
        for each in zip(*((c["position_w"], c["velocity_w"]) for c in chunks), strict=True)
    )
    assert abs(velocity[:, 0]).max() > 7.0
    assert abs(place[:, 1]).max() < 0.15
