import numpy as np
import pytest

cv2 = pytest.importorskip("cv2")

from drives import LENS, motions, rendered  # noqa: E402

from estimators.odometry import odometry  # noqa: E402
from estimators.odometry.lens import Reason  # noqa: E402

FIRST = 4
"""Number of the first frame that is spoilt."""
SIZE = (800, 1280)


@pytest.fixture(scope="module")
def drive():
    return rendered(0.4, 1.0)


def spoilt(drive, frames):
    return motions(drive, replaced=dict(enumerate(frames, FIRST)))


def check(found, reasons):
    """The spoilt samples say why, all others are used, and nothing is silently zero."""
    assert [m.reason for m in found[FIRST : FIRST + len(reasons)]] == reasons
    for number, motion in enumerate(found):
        assert motion.used == bool(np.all(np.isfinite(motion.velocity_mps)))
        assert motion.used == bool(np.all(np.isfinite(motion.covariance)))
        if number and not FIRST <= number < FIRST + len(reasons):
            assert motion.used
            assert motion.velocity_mps[0] == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("level", [0, 128, 255])
def test_black_grey_and_white(drive, level):
    frames = [np.full(SIZE, level, np.uint8)] * 3
    check(spoilt(drive, frames), [Reason.FLAT] * 3)


def test_black_with_the_noise_of_a_sensor(drive):
    noise = np.random.default_rng(1).normal(0, 2.0, SIZE)
    check(spoilt(drive, [np.clip(noise, 0, 255).astype(np.uint8)]), [Reason.FLAT])


def test_missing(drive):
    found = spoilt(drive, [None, None])
    check(found, [Reason.MISSING] * 2)
    assert found[FIRST + 2].interval_s == pytest.approx(3 / 30, abs=1e-6)  # across the gap


def test_a_camera_that_hangs(drive):
    before = drive.frames[FIRST - 1]
    check(spoilt(drive, [before, before]), [Reason.FROZEN] * 2)


def test_all_frames_equal():
    frame = rendered(0.1, 1.0).frames[0]
    state, used = odometry.begin(LENS), []
    for k in range(5):
        state, motion = odometry.step(state, frame, k * 33_000_000)
        used.append(motion.used)
    assert not any(used)


def test_a_resolution_that_changes_goes_on_at_the_new_one(drive):
    halved = {
        n: cv2.resize(drive.frames[n], None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
        for n in range(FIRST, 13)
    }
    found = motions(drive, replaced=halved)
    assert found[FIRST].reason == Reason.SIZE
    for motion in found[FIRST + 1 :]:
        assert motion.velocity_mps[0] == pytest.approx(1.0, abs=0.01)


def test_another_shape_is_no_picture_of_this_lens(drive):
    square = drive.frames[5][:, :800]
    check(spoilt(drive, [square, square[:20, :20], np.zeros((0, 0), np.uint8)]), [Reason.SIZE] * 3)


def test_colour_is_taken_as_grey(drive):
    check(spoilt(drive, [cv2.cvtColor(drive.frames[FIRST], cv2.COLOR_GRAY2BGR)]), [Reason.USED])


def test_another_place_is_not_matched(drive):
    elsewhere = rendered(0.1, 1.0, seed=9).frames[2]
    found = motions(drive, replaced={FIRST: elsewhere})
    assert [m.reason for m in found[FIRST : FIRST + 2]] == [Reason.UNMATCHED] * 2
    assert all(m.used for m in found[FIRST + 2 :])


def test_a_long_gap_starts_anew(drive):
    state = odometry.begin(LENS)
    state, _ = odometry.step(state, drive.frames[0], 0)
    _, motion = odometry.step(state, drive.frames[1], 1_000_000_000)
    assert motion.reason == Reason.FIRST
