"""Scheduled faults: what they do to the streams, in whatever pieces these come."""

import numpy as np
import pytest

from tests.sensors.trajectories import drive, pieces
from twin.errors import TwinError
from twin.sensors import Fault, Sensors, suite
from twin.sensors.faults import KINDS
from twin.streams import concatenate

START_S, LENGTH_S = 0.8, 0.5


def run(faults, chunks):
    sensors = Sensors(faults=faults)
    state, parts = suite.init(sensors, 11), []
    for chunk in chunks:
        state, streams = suite.sample(sensors, state, chunk)
        parts.append(streams)
    return concatenate(parts)


def fault(kind):
    return (Fault(kind=kind, start_s=START_S, duration_s=LENGTH_S),)


@pytest.mark.parametrize("kind", KINDS)
def test_a_fault_touches_its_stream_alone_and_no_chunking_changes_it(kind):
    trajectory = drive(2.0, yaw_rate_radps=0.2)
    whole, cut = run(fault(kind), [trajectory]), run(fault(kind), pieces(trajectory, 37))
    healthy = run((), [trajectory])
    for name in healthy.tables:
        for column in healthy[name]:
            assert np.array_equal(whole[name][column], cut[name][column], equal_nan=True)
            if name != KINDS[kind][0]:
                same = np.array_equal(whole[name][column], healthy[name][column], equal_nan=True)
                assert same, (name, column)
    of = KINDS[kind][0]
    assert any(not np.array_equal(whole[of][c], healthy[of][c]) for c in healthy[of])


def during(table):
    time = table["epoch_ns"] * 1e-9
    return (time >= START_S) & (time < START_S + LENGTH_S)


def test_what_each_fault_is():
    trajectory = [drive(2.0, yaw_rate_radps=0.2)]
    healthy = run((), trajectory)
    gnss, wheels = healthy["gnss"], healthy["wheels"]
    assert not during(run(fault("gnss-dropout"), trajectory)["gnss"]).any()
    spiked = run(fault("gnss-spike"), trajectory)["gnss"]["v_east_mps"] - gnss["v_east_mps"]
    assert spiked == pytest.approx(3.0 * during(gnss))
    frozen = run(fault("gnss-frozen"), trajectory)["gnss"]["east_m"]
    assert np.ptp(frozen[during(gnss)]) == 0.0
    assert frozen[during(gnss)][0] == gnss["east_m"][~during(gnss)][during(gnss).argmax() - 1]
    late = run(fault("gnss-late"), trajectory)["gnss"]
    assert np.all(np.diff(late["arrival_ns"]) >= 0)
    stuck = run(fault("wheels-stuck"), trajectory)["wheels"]["ticks_rl"]
    assert np.ptp(stuck[during(wheels)]) <= np.diff(wheels["ticks_rl"]).max()
    assert np.array_equal(np.diff(stuck[-20:]), np.diff(wheels["ticks_rl"][-20:]))  # it goes on
    missed = run(fault("wheel-missed"), trajectory)["wheels"]
    gone = wheels["ticks_rl"] - missed["ticks_rl"]
    passed = np.diff(wheels["ticks_rl"][during(wheels)][[0, -1]])[0]
    assert gone[-1] == pytest.approx(0.1 * passed, rel=0.1)
    assert np.array_equal(missed["ticks_rr"], wheels["ticks_rr"])
    back = run(fault("imu-back"), trajectory)["imu"]["epoch_ns"]
    assert np.diff(back).min() < 0


def test_a_fault_that_is_none_is_refused():
    with pytest.raises(TwinError, match="no sensor fault is called 'gnss-dropuot'"):
        Fault(kind="gnss-dropuot", start_s=1.0, duration_s=1.0)
    with pytest.raises(TwinError, match=r"fault.start_s = -1 is outside"):
        Fault(kind="gnss-spike", start_s=-1.0, duration_s=1.0)
