import copy
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.sensors.trajectories import drive, pieces, same
from twin.sensors import Gnss, Imu, Outage, Sensors, Wheels, suite
from twin.streams import check, concatenate

WILD = Sensors(
    gnss=Gnss(
        rate_hz=30.0,
        lever_arm_error_m=(0.02, -0.01, 0.03),
        outages=(Outage(start_s=0.3, duration_s=0.4, kind="block"),),
    ),
    imu=Imu(rate_hz=75.0, internal_rate_hz=225.0),
    wheels=Wheels(rate_hz=70.7),
)


def bumpy(duration_s=2.0):
    n = round(duration_s / 0.002) + 1
    rng = np.random.default_rng(3)
    calm = drive(duration_s, yaw_rate_radps=0.4, roll_rad=0.1)
    return drive(
        duration_s,
        yaw_rate_radps=0.4,
        roll_rad=0.1,
        imu_accel_b=calm["imu_accel_b"] + rng.standard_normal((n, 3)),
        engine_radps=180 + np.cumsum(rng.standard_normal(n)),
    )


def run(sensors, chunks):
    state = suite.init(sensors, 11)
    parts = []
    for chunk in chunks:
        state, streams = suite.sample(sensors, state, chunk)
        parts.append(streams)
    return concatenate(parts)


@pytest.mark.parametrize("sensors", [Sensors(), WILD], ids=["default", "wild"])
@pytest.mark.parametrize("size", [1, 7, 1000])
def test_chunking_changes_no_bit(sensors, size):
    trajectory = bumpy()
    whole, cut = run(sensors, [trajectory]), run(sensors, pieces(trajectory, size))
    check(cut)
    assert all(same(whole[name], cut[name]) for name in whole.tables)
    assert min(len(whole[name]["epoch_ns"]) for name in whole.tables) > 15


@given(st.lists(st.integers(0, 301), max_size=12))
@settings(deadline=None, max_examples=40)
def test_no_cut_anywhere_changes_a_bit(cuts):
    trajectory = bumpy(0.6)
    at = [0, *sorted(cuts), len(trajectory)]
    chunks = [trajectory.cut(a, b) for a, b in pairwise(at)]
    whole, cut = run(WILD, [trajectory]), run(WILD, chunks)
    assert all(same(whole[name], cut[name]) for name in whole.tables)


def test_a_copied_state_continues_as_the_original():
    sensors, (first, second) = Sensors(), pieces(bumpy(), 600)[:2]
    state, _ = suite.sample(sensors, suite.init(sensors, 4), first)
    branch = copy.deepcopy(state)
    _, a = suite.sample(sensors, state, second)
    _, b = suite.sample(sensors, branch, second)
    assert all(same(a[name], b[name]) for name in a.tables)


def test_nothing_is_handed_on_before_it_arrives():
    sensors, state = Sensors(), suite.init(Sensors(), 1)
    waited = 0
    for chunk in pieces(bumpy(), 10):
        state, streams = suite.sample(sensors, state, chunk)
        for table in streams.tables.values():
            assert np.all(table["arrival_ns"] <= chunk.epoch_ns[-1])
            waited += int(np.sum(table["epoch_ns"] < chunk.epoch_ns[0]))
    assert waited > 0


def test_switching_a_sensor_off_changes_no_other():
    trajectory = bumpy()
    full, part = run(Sensors(), [trajectory]), run(Sensors(gnss=None, depth=None), [trajectory])
    assert set(part.tables) == {"imu", "wheels", "machine"}
    assert all(same(full[name], part[name]) for name in part.tables)
