"""Conversions between the ground plane and the horizontal, against their closed form."""

import numpy as np
import pytest

from estimators.sideslip_ekf import plane

SLOPE, HEADING = np.radians(18.0), np.radians(17.0)


def across(slope_rad):
    """A plane that rises to the north."""
    return plane.world_from_plane(np.array([0.0, np.sin(slope_rad), np.cos(slope_rad)]))


def test_a_cross_slope_keeps_east_and_shortens_north():
    turn = across(SLOPE)
    exact = [[1, 0, 0], [0, np.cos(SLOPE), -np.sin(SLOPE)], [0, np.sin(SLOPE), np.cos(SLOPE)]]
    np.testing.assert_allclose(turn, exact, atol=1e-15)


def test_azimuth_at_18_degrees_slope_and_17_degrees_heading():
    """tan A = cos(slope) tan(heading)"""
    seen, slope = plane.azimuth(across(SLOPE), HEADING)
    assert seen == pytest.approx(np.arctan(np.cos(SLOPE) * np.tan(HEADING)), abs=1e-15)
    exact = np.cos(SLOPE) * np.cos(seen) ** 2 / np.cos(HEADING) ** 2
    assert slope == pytest.approx(exact, rel=1e-12)
    assert plane.heading(across(SLOPE), seen) == pytest.approx(HEADING, abs=1e-14)


def test_an_antenna_baseline_across_the_body():
    """The body's left at heading h is (-sin h, cos h) in the plane."""
    seen, _ = plane.azimuth(across(SLOPE), HEADING + np.pi / 2)
    assert seen == pytest.approx(np.arctan2(np.cos(SLOPE) * np.cos(HEADING), -np.sin(HEADING)))


@pytest.mark.parametrize("up", [(0.0, 0.0), (0.2, -0.25), (-0.1, 0.3), (0.9, 0.9)])
def test_any_plane_is_turned_upright(up):
    vertical = plane.tilted(np.array(up))
    turn = plane.world_from_plane(vertical)
    np.testing.assert_allclose(turn @ vertical, [0, 0, 1], atol=1e-14)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(turn) == pytest.approx(1.0)
    for angle in np.linspace(-3, 3, 7):
        seen, _ = plane.azimuth(turn, angle)
        assert plane.wrap(plane.heading(turn, seen) - angle) == pytest.approx(0.0, abs=1e-9)
