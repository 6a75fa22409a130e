"""The ignition off and on: what is missing, what begins anew, and the clock that jumps once."""

from dataclasses import replace

import numpy as np
import pytest

from tests.sensors.test_chunking import run
from tests.sensors.trajectories import drive, pieces, same
from twin.errors import BadInput, OutOfRange
from twin.sensors import Fault, Gnss, Outage, Sensors, ignition, suite
from twin.streams import check

OFF_S, LASTS_S = 4.0, 6.0
ON_S, READY_S, SET_S = 10.0, 12.0, 15.0
SENSORS = Sensors(ignition_off_s=((OFF_S, LASTS_S),))
PLAIN = Sensors()


@pytest.fixture(scope="module")
def both():
    """The same drive without and with the ignition off from 4 to 10 s."""
    truth = drive(20.0)
    return run(PLAIN, [truth]), run(SENSORS, [truth])


def seconds(table):
    return table["epoch_ns"] * 1e-9


def test_before_it_is_off_nothing_differs(both):
    plain, off = both
    for name, table in off.tables.items():
        head = seconds(table) < 3.5
        before = {c: v[: head.sum()] for c, v in plain[name].items()}
        assert same({c: v[head] for c, v in table.items()}, before)


def test_it_is_a_valid_stream_with_a_gap(both):
    _, off = both
    check(off)
    for name, table in off.tables.items():
        t = seconds(table)
        clock_s = 0.0 if name == "gnss" else ignition.CLOCK_S
        ready_s = SET_S if name == "gnss" else READY_S
        assert not ((t > OFF_S) & (t < ready_s - clock_s)).any(), name
        assert (t > ready_s + clock_s).sum() > 20, name


def test_counters_begin_from_zero_and_count_on(both):
    plain, off = both
    t, ticks = seconds(off["wheels"]), off["wheels"]["ticks_rl"]
    after = t > SET_S + 0.6
    was = plain["wheels"]["ticks_rl"][np.isin(plain["wheels"]["epoch_ns"],
                                              off["wheels"]["epoch_ns"][after])]  # fmt: skip
    lost = was - ticks[after]
    assert len(set(lost.tolist())) == 1
    per_second = 4000 * 1.5 / 0.83 / (2 * np.pi)
    assert lost[0] == pytest.approx(plain["wheels"]["ticks_rl"][0] + ON_S * per_second, rel=0.02)
    first = ticks[t > OFF_S][0]
    assert first == pytest.approx((READY_S - ON_S) * per_second, abs=30)


def test_the_clock_is_off_until_the_receiver_sets_it_and_jumps_once(both):
    _, off = both
    step_s = np.diff(off["wheels"]["epoch_ns"])[off["wheels"]["epoch_ns"][1:] > 12.6e9] * 1e-9
    odd = step_s[np.abs(step_s - 0.02) > 1e-6]
    plan = ignition.restarts(SENSORS.ignition_off_s, 11, 0)[0]
    assert len(odd) == 1
    assert odd[0] == pytest.approx(0.02 - plan.clock_ns * 1e-9, abs=1e-6)
    assert abs(plan.clock_ns) < 0.5e9
    np.testing.assert_allclose(np.diff(off["gnss"]["epoch_ns"])[-50:], 50_000_000)


def test_the_receiver_comes_back_single_then_float(both):
    _, off = both
    after = seconds(off["gnss"]) > OFF_S
    assert seconds(off["gnss"])[after][0] == pytest.approx(SET_S, abs=0.051)
    assert list(dict.fromkeys(off["gnss"]["quality"][after].tolist()))[:2] == [1, 5]


def test_the_imu_has_a_new_bias_of_the_data_sheets_size():
    truth = drive(20.0, speed_mps=0.0, engine_radps=0.0)
    steps = []
    for seed in range(40):
        sensors = replace(SENSORS, gnss=None, wheels=None, depth=None, machine=None)
        _, streams = suite.sample(sensors, suite.init(sensors, seed), truth)
        t, rate = seconds(streams["imu"]), streams["imu"]["gyro_z_radps"]
        steps.append(rate[t > 16].mean() - rate[t < 4].mean())
    sd = np.sqrt(2.0) * sensors.imu.gyro_bias_sd_radps
    assert np.std(steps) == pytest.approx(sd, rel=0.35)


@pytest.mark.parametrize("size", [1, 333, 2500])
def test_chunking_changes_no_bit(size):
    truth = drive(20.0, step_ns=10_000_000)
    sensors = replace(SENSORS, faults=(Fault(kind="wheels-stuck", start_s=1.0, duration_s=1.0),))
    whole, cut = run(sensors, [truth]), run(sensors, pieces(truth, size))
    assert all(same(whole[n], cut[n]) for n in whole.tables)


def test_the_same_seed_gives_the_same_and_another_one_another_clock():
    clocks = [ignition.restarts(SENSORS.ignition_off_s, seed, 0)[0].clock_ns for seed in (1, 1, 2)]
    assert clocks[0] == clocks[1] != clocks[2]
    many = [ignition.restarts(((1.0, 1.0),), seed, 0)[0].clock_ns * 1e-9 for seed in range(400)]
    assert np.std(many) == pytest.approx(1.0 / np.sqrt(12.0), rel=0.1)


def test_they_count_from_where_faults_count():
    sensors = replace(SENSORS, faults=(Fault(kind="imu-bias", start_s=1.0, duration_s=1.0),))
    moved = suite.faults_from(sensors, 30.0)
    assert moved.ignition_off_s == ((34.0, 6.0),)
    assert moved.faults[0].start_s == 31.0


@pytest.mark.parametrize(
    ("off_s", "error", "says"),
    [
        (((-1.0, 2.0),), OutOfRange, r"ignition_off_s start = -1 is outside"),
        (((1.0, 0.0),), OutOfRange, r"ignition_off_s duration = 0 is outside"),
        (((5.0, 2.0), (10.0, 1.0)), BadInput, "10 s is before the receiver is back .* at 12 s"),
    ],
)
def test_bad_times_are_named(off_s, error, says):
    with pytest.raises(error, match=says):
        Sensors(ignition_off_s=off_s)


def test_an_outage_of_the_receiver_may_not_lie_in_it():
    outage = Outage(start_s=8.0, duration_s=5.0)
    with pytest.raises(BadInput, match="one after the other"):
        Sensors(gnss=Gnss(outages=(outage,)), ignition_off_s=((4.0, 6.0),))
