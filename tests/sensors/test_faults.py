"""Scheduled faults: what they do to the streams, in whatever pieces these come."""

import numpy as np
import pytest

from tests.sensors.trajectories import drive, pieces
from twin.errors import TwinError
from twin.sensors import Camera, Fault, Sensors, suite
from twin.sensors.faults import KINDS
from twin.streams import concatenate
from twin.trajectory.trajectory import Trajectory

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


@pytest.mark.parametrize("kind", [k for k, (of, *_) in KINDS.items() if of != "camera"])
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


@pytest.mark.parametrize("kind", [k for k, (of, *_) in KINDS.items() if of == "camera"])
def test_what_a_camera_shows_in_each_of_its_faults(kind):
    small = Camera(width_px=64, height_px=40)
    path = drive(2.0)
    path = Trajectory(
        path.epoch_ns, path.columns | {"position_w": path["position_w"] + [0, 0, 0.2]}
    )

    def seen(faults, chunks):
        sensors = Sensors(camera=small, faults=faults)
        state, found = suite.init(sensors, 11), {}
        for chunk in chunks:
            state, streams = suite.sample(sensors, state, chunk)
            epoch_ns = dict(
                zip(*(streams["camera"][c] for c in ("frame", "epoch_ns")), strict=True)
            )
            found |= {n: (epoch_ns[n] * 1e-9, streams.frames[n]) for n in streams.frames}
        return found

    whole, healthy = seen(fault(kind), [path]), seen((), [path])
    cut = seen(fault(kind), pieces(path, 37))
    assert cut.keys() == whole.keys()
    last = None
    for n, (time_s, image) in healthy.items():
        if n in whole:
            assert np.array_equal(whole[n][1], cut[n][1])
        if not START_S <= time_s < START_S + LENGTH_S:
            assert np.array_equal(whole[n][1], image)
            last = image if time_s < START_S else last
        elif kind == "camera-dropout":
            assert n not in whole
        elif kind == "camera-black":
            assert whole[n][1].shape == image.shape
            assert whole[n][1].max() < 5
        elif kind == "camera-frozen":
            assert np.array_equal(whole[n][1], last)
        else:
            means = image.reshape(20, 2, 32, 2).mean(axis=(1, 3))
            np.testing.assert_allclose(whole[n][1], means, atol=0.5)
