"""Quaternions against scipy's rotations."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from twin.compute import quaternion

TURNED = Rotation.random(100, rng=np.random.default_rng(1))
WXYZ = TURNED.as_quat(scalar_first=True)
MATRICES = TURNED.as_matrix()


def test_the_axes_are_columns_and_rows_of_the_matrix():
    axes = (quaternion.x_axis, quaternion.y_axis, quaternion.z_axis)
    for k, axis in enumerate(axes):
        assert np.stack(axis(*WXYZ.T), 1) == pytest.approx(MATRICES[:, :, k], abs=1e-14)
    assert np.stack(quaternion.up_b(*WXYZ.T), 1) == pytest.approx(MATRICES[:, 2], abs=1e-14)


def test_vectors_are_rotated_all_by_their_own_or_one_by_all():
    vectors = np.random.default_rng(2).normal(size=(100, 3))
    assert quaternion.rotated(WXYZ, vectors) == pytest.approx(TURNED.apply(vectors), abs=1e-14)
    one = quaternion.rotated(WXYZ, vectors[0])
    assert one == pytest.approx(TURNED.apply(vectors[0]), abs=1e-14)


def test_heading_and_roll_are_the_first_and_the_last_of_yaw_pitch_and_roll():
    yaw, _, roll = TURNED.as_euler("ZYX").T
    assert quaternion.heading_rad(*WXYZ.T) == pytest.approx(yaw, abs=1e-12)
    assert quaternion.roll_rad(*WXYZ.T) == pytest.approx(roll, abs=1e-12)


def test_a_product_is_one_rotation_after_the_other():
    for p, q, wanted in zip(WXYZ, WXYZ[::-1], TURNED * TURNED[::-1], strict=True):
        ours = quaternion.multiplied(p, q)
        assert abs(ours @ wanted.as_quat(scalar_first=True)) == pytest.approx(1.0, abs=1e-14)


def test_matrices_there_and_back_for_a_quaternion_of_any_length():
    for wxyz, wanted in zip(WXYZ, MATRICES, strict=True):
        assert quaternion.matrix(1.7 * wxyz) == pytest.approx(wanted, abs=1e-14)
        assert abs(quaternion.from_matrix(wanted) @ wxyz) == pytest.approx(1.0, abs=1e-14)
