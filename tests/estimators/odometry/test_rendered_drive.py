import numpy as np
import pytest

pytest.importorskip("cv2")

from drives import CAMERA, motions, rendered

SPEED, SPIN = 1.0, 0.1
AHEAD_M = CAMERA.position_m[0]


@pytest.fixture(scope="module")
def drive():
    return rendered(1.0, SPEED, SPIN)


def used(found):
    return [m for m in found if m.used]


@pytest.mark.parametrize(
    ("method", "lateral_mps", "forward"),
    [("phase-ecc", 0.5e-3, 0.002), ("orb-similarity", 20e-3, 0.01)],
)
def test_the_velocity_is_the_camera_points(drive, method, lateral_mps, forward):
    found = used(motions(drive, SPIN, method))
    velocity = np.array([m.velocity_mps for m in found])
    assert len(found) == 30
    assert velocity[:, 0].mean() == pytest.approx(SPEED, rel=forward)
    assert np.sqrt(np.mean((velocity[:, 1] - SPIN * AHEAD_M) ** 2)) < lateral_mps


@pytest.mark.parametrize(("method", "sd_mps"), [("phase-ecc", 2e-3), ("orb-similarity", 20e-3)])
def test_errors_are_within_the_covariance(drive, method, sd_mps):
    found = used(motions(drive, SPIN, method))
    error = np.array([m.velocity_mps for m in found]) - [SPEED, SPIN * AHEAD_M]
    nees = [e @ np.linalg.solve(m.covariance, e) for e, m in zip(error, found, strict=True)]
    assert np.mean(nees) < 2.7  # chi-square, 2 x 30 degrees of freedom, 99 %
    sd = np.sqrt([m.covariance[1, 1] for m in found])
    assert sd.max() < sd_mps


def test_without_gyros_the_picture_tells_the_turn(drive):
    found = used(motions(drive, SPIN, gyros=False))
    velocity = np.array([m.velocity_mps for m in found])
    assert np.abs(velocity[:, 1] - SPIN * AHEAD_M).max() < 2e-3
    assert np.mean([m.yaw_rad / m.interval_s for m in found]) == pytest.approx(SPIN, abs=2e-3)


def test_the_printed_pipeline_runs(drive):
    found = used(motions(drive, SPIN, "orb-printed"))
    assert np.median([m.velocity_mps[0] for m in found]) == pytest.approx(SPEED, rel=0.2)


def test_standing_still_is_a_velocity_of_zero_not_of_nothing():
    found = used(motions(rendered(0.3, 0.0)))
    assert len(found) == 9
    assert np.abs([m.velocity_mps for m in found]).max() < 0.5e-3
