from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("cv2")

from drives import CAMERA, rendered

from estimators.odometry import streams as visual
from estimators.odometry.lens import Reason
from estimators.odometry.streams import Gyros, angle_at, integrate
from twin.sensors import camera
from twin.streams import Setup, Streams

SPIN = 0.2
SETUP = Setup(
    machine="", wheelbase_m=1, track_front_m=1, track_rear_m=1, cg_x_m=0.4,
    camera=camera.setup(CAMERA),
)  # fmt: skip


def with_gyros(streams, spin_radps=SPIN):
    count = 100
    epoch_ns = np.arange(count, dtype=np.int64) * 5_000_000
    zero = np.zeros(count)
    imu = {"epoch_ns": epoch_ns, "arrival_ns": epoch_ns + 2_000_000}
    rates = {"gyro_x_radps": zero, "gyro_y_radps": zero, "gyro_z_radps": zero + spin_radps}
    return Streams({**streams.tables, "imu": imu | rates}, streams.frames)


@pytest.fixture(scope="module")
def streams():
    return with_gyros(rendered(0.4, 1.0, SPIN))


def run(streams, size, method="phase-ecc"):
    state, tables = visual.init(SETUP, method), []
    for chunk in streams.chunks(size):
        state, table = visual.run(state, chunk)
        tables.append(table)
    return {name: np.concatenate([t[name] for t in tables]) for name in tables[0]}


def test_chunks_change_no_bit_and_later_samples_nothing(streams):
    whole = run(streams, len(streams))
    for cut in (run(streams, 7), run(streams.samples(0, 60), 60)):
        count = len(cut["epoch_ns"])
        for name, column in cut.items():
            assert column.tobytes() == whole[name][:count].tobytes(), name


def test_velocities_are_stamped_at_the_middle_of_their_interval(streams):
    table = run(streams, len(streams))
    assert list(table["reason"]) == [Reason.FIRST] + [Reason.USED] * 12
    np.testing.assert_allclose(table["epoch_ns"][1:] * 1e-9, (np.arange(12) + 0.5) / 30, atol=1e-8)
    assert table["v_y_mps"][1:].mean() == pytest.approx(SPIN * CAMERA.position_m[0], abs=5e-4)


def test_the_gyros_turn_the_axes_to_the_middle(streams):
    table = run(streams, len(streams))
    blind = run(with_gyros(streams, 0.0), len(streams))
    tilt = 0.5 * SPIN / 30  # without the gyros' turn the axes are those of the frame before
    difference = table["v_y_mps"][1:] - blind["v_y_mps"][1:]
    np.testing.assert_allclose(np.abs(difference), tilt, rtol=0.1)


def test_the_integral_of_the_gyros_is_exact_for_a_ramp():
    gyros = visual.Gyros()
    for k in range(1000):
        t = 0.005 * k
        gyros = visual.integrate(gyros, 5_000_000 * k, np.array([0.0, 0.3, 2.0 * t]))
    assert len(gyros.epoch_ns) == visual.KEPT
    angle = visual.angle_at(gyros, 5_000_000 * 999)
    np.testing.assert_allclose(angle, [0.0, 0.3 * 4.995, 4.995**2], rtol=1e-12, atol=1e-15)
    later = visual.angle_at(gyros, 5_000_000 * 1001)
    np.testing.assert_allclose(later - angle, [0.0, 0.003, 2.0 * 4.995 * 0.01], rtol=1e-9)
    same = visual.integrate(gyros, 5_000_000 * 1000, np.array([0.0, np.nan, 0.0]))
    assert same is gyros


def test_a_frame_the_mapping_lacks_is_missing(streams):
    holes = {n: streams.frames[n] for n in streams.frames if n != 5}
    table = run(Streams(streams.tables, holes), 50)
    assert [n for n, r in enumerate(table["reason"]) if r == Reason.MISSING] == [5]
    assert table["used"].sum() == 11
    none = run(Streams(streams.tables), 50)
    assert not none["used"].any()


def test_it_says_what_it_needs():
    with pytest.raises(ValueError, match=r"needs setup\.camera"):
        visual.init(replace(SETUP, camera=None))
    with pytest.raises(ValueError, match="there are: orb-printed, orb-similarity, phase-ecc"):
        visual.init(SETUP, "orb")


def test_the_set_up_survives_json():
    assert Setup.from_json(SETUP.to_json()) == SETUP


def test_a_gap_in_the_gyros_is_no_turn():
    """A rate goes on for a quarter of a second at most, so a pause turns no picture."""
    gyros = integrate(Gyros(), 0, np.array([0.1, 0.0, 0.0]))
    gyros = integrate(gyros, 20_000_000, np.array([0.1, 0.0, 0.0]))
    assert angle_at(gyros, 120_000_000)[0] == pytest.approx(0.012)
    assert angle_at(gyros, 6_000_000_000) is None
    after = integrate(gyros, 6_000_000_000, np.array([0.1, 0.0, 0.0]))
    assert angle_at(after, 6_000_000_000)[0] == pytest.approx(0.002)
    assert angle_at(Gyros(), 5) is None
