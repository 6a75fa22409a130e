import numpy as np
import pytest

from tests.camera.views import LENS, view
from twin.camera.pinhole import exposed, ground_from_pixel, ground_points
from twin.errors import OutOfRange

CENTRE = np.array([[639.5], [399.5], [1.0]])


def at(homography, u, v):
    return ground_points(homography, np.array([[u], [v], [1.0]]))[:, 0]


def test_straight_down_a_pixel_is_height_over_focal_length():
    h = ground_from_pixel(LENS, view(2.0, 3.0))
    step_m = 0.5 / LENS.focal_px
    np.testing.assert_allclose(at(h, 639.5, 399.5), [2.0, 3.0], atol=1e-12)
    np.testing.assert_allclose(at(h, 639.5, 299.5), [2.0 + 100 * step_m, 3.0])  # top is ahead
    np.testing.assert_allclose(at(h, 739.5, 399.5), [2.0, 3.0 - 100 * step_m])  # right is right


def test_the_field_of_view_is_what_was_asked_for():
    h = ground_from_pixel(LENS, view())
    width_m = np.linalg.norm(at(h, -0.5, 0.0) - at(h, 1279.5, 0.0))
    assert width_m == pytest.approx(2 * 0.5 * np.tan(np.radians(26.5)))


@pytest.mark.parametrize("angle", [-0.1, 0.02, 0.3])
def test_a_tilted_axis_meets_the_ground_at_height_times_tangent(angle):
    pitched = ground_from_pixel(LENS, view(turn_rad=(0, angle, 0)))
    np.testing.assert_allclose(
        ground_points(pitched, CENTRE)[:, 0], [-0.5 * np.tan(angle), 0.0], atol=1e-12
    )
    rolled = ground_from_pixel(LENS, view(turn_rad=(angle, 0, 0)))
    np.testing.assert_allclose(
        ground_points(rolled, CENTRE)[:, 0], [0.0, 0.5 * np.tan(angle)], atol=1e-12
    )


def test_an_exposure_is_cut_so_that_no_part_moves_too_far():
    moving = view(velocity_mps=(1.0, 0, 0), exposure_s=0.004)
    blur_px = 0.004 * LENS.focal_px / 0.5
    parts = exposed(LENS, moving, path_px=2.5)
    assert len(parts) == int(np.ceil(blur_px / 2.5))
    places = np.array([ground_points(h, CENTRE)[0, 0] for h in parts])
    assert places.mean() == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(np.diff(places), 0.004 / len(parts))


def test_a_camera_that_sees_the_sky_says_so():
    with pytest.raises(OutOfRange, match="degrees from straight down"):
        ground_from_pixel(LENS, view(turn_rad=(1.5, 0, 0)))
    with pytest.raises(OutOfRange, match=r"-0.100 m above"):
        ground_from_pixel(LENS, view(height_m=-0.1))
