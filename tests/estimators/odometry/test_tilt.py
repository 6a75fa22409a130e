"""What a tilted plane does to an affine map, against points of the plane itself."""

import numpy as np
import pytest

from estimators.odometry import tilt
from estimators.odometry.tilt import Tilt

SHAPE, FOCAL_PX, EDGE_PX = (200, 320), 320.0, 16
NORMAL, MOVED = np.array([0.16, 0.02]), np.array([0.003, 0.12, -0.0015])
"""The ground's normal over its part along the axis, and displacement in heights."""


def affine():
    """The map of least squares of all points that both pictures show, shape (2, 3)."""
    centre = np.array([(SHAPE[1] - 1) / 2, (SHAPE[0] - 1) / 2])
    v, u = np.mgrid[: SHAPE[0], : SHAPE[1]].reshape(2, -1)
    now = (np.column_stack([u, v]) - centre) / FOCAL_PX
    depth = 1.0 / (1.0 + now @ NORMAL)
    points = np.column_stack([now * depth[:, None], depth]) + MOVED
    before = points[:, :2] / points[:, 2:] * FOCAL_PX + centre
    halfway = 0.5 * (before + now * FOCAL_PX + centre)
    room = 0.5 * np.abs(MOVED[:2]) * FOCAL_PX + EDGE_PX
    shown = ((halfway > room) & (halfway < np.array(SHAPE)[::-1] - 1 - room)).all(axis=1)
    columns = np.column_stack([u, v, np.ones(len(u))])[shown]
    return np.linalg.lstsq(columns, before[shown], rcond=None)[0].T, centre


def test_what_an_affine_map_is_off_is_taken_out():
    warp, centre = affine()
    seen = warp @ np.append(centre, 1.0) - centre
    due = MOVED[:2] / (1.0 + MOVED[2]) * FOCAL_PX
    found = Tilt((float(NORMAL[0]), float(NORMAL[1])), 1.0)
    off = tilt.bent(found, warp, SHAPE, FOCAL_PX, EDGE_PX)
    assert abs(seen - due)[0] > 3e-3
    assert seen - off == pytest.approx(due, abs=2e-4)


def test_the_tilt_is_seen_in_how_the_picture_is_stretched():
    warp, _ = affine()
    found = tilt.seen(Tilt(), warp, SHAPE, FOCAL_PX, 0.033)
    assert found.normal == pytest.approx(NORMAL, abs=3e-4)
    assert tilt.leans(found) == pytest.approx(np.arctan(NORMAL[::-1]), abs=3e-4)
