"""Values of a map's [setup]."""

import pytest

from twin.errors import BadInput
from twin.logs.setup_block import setup_from


def test_gravity_may_have_been_taken_out_of_the_accelerations():
    assert setup_from({"machine": "m"}, assume=True).imu is None
    assert setup_from({"machine": "m", "imu": {}}, assume=True).imu.gravity
    assert not setup_from({"machine": "m", "imu": {"gravity": False}}, assume=True).imu.gravity


@pytest.mark.parametrize("wrong", [0, "false", 1.0])
def test_gravity_is_true_or_false(wrong):
    with pytest.raises(BadInput, match=r"setup.imu.gravity = .* must be true or false"):
        setup_from({"machine": "m", "imu": {"gravity": wrong}}, assume=True)
