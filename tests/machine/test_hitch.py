"""The linkage's geometry against the same linkage in MuJoCo."""

import mujoco
import numpy as np
import pytest

from tests.machine.rigs import PLOUGHING, plough_rig, replace
from twin.machine.build import build
from twin.scenario import Plough


def posed(machine, lift, pitch):
    data = mujoco.MjData(machine.model)
    data.joint("lift").qpos[0], data.joint("plough.pitch").qpos[0] = lift, pitch
    mujoco.mj_forward(machine.model, data)
    return data


@pytest.mark.parametrize("lift", [-0.3, 0.0, 0.6])
@pytest.mark.parametrize("pitch", [-0.4, 0.0, 0.25])
def test_points_and_top_link_are_where_mujoco_has_them(lift, pitch):
    machine = plough_rig()
    data = posed(machine, lift, pitch)
    rear_axle = data.body("tractor").xpos
    x, _, z = data.body("plough.frame").xpos - rear_axle
    assert machine.hitch.hitch_point(lift) == pytest.approx((x, z), abs=1e-12)
    tendon = machine.model.tendon("top_link").id
    assert machine.hitch.top_length_m(lift, pitch) == pytest.approx(
        data.ten_length[tendon], abs=1e-12
    )


@pytest.mark.parametrize("lift", [-0.2, 0.1, 0.6])
def test_the_angle_found_for_a_top_link_gives_that_length(lift):
    hitch = plough_rig().hitch
    for pitch in (-lift - 0.3, -lift, -lift + 0.2):
        assert hitch.pitch_rad_at(lift, hitch.top_length_m(lift, pitch)) == pytest.approx(
            pitch, abs=1e-9
        )


def test_the_lift_angle_puts_the_hitch_at_its_height():
    hitch = plough_rig().hitch
    for height_m in (0.43, 0.55, 0.7):
        lift = hitch.lift_rad_at(height_m, 0.8375)
        assert 0.8375 + hitch.hitch_point(lift)[1] == pytest.approx(height_m)


@pytest.mark.parametrize("depth_m", [0.10, 0.25, 0.35])
def test_at_the_working_angle_all_shares_are_level_at_their_depth(depth_m):
    machine = build(replace(PLOUGHING, plough=Plough(depth_m=depth_m)))
    data = posed(machine, machine.work_rad, -machine.work_rad)
    for i in range(1, 5):
        assert data.site(f"plough.share_{i}").xpos[2] == pytest.approx(-depth_m, abs=1e-9)
    tendon = machine.model.tendon("top_link").id
    assert data.ten_length[tendon] == pytest.approx(machine.model.tendon_lengthspring[tendon][0])


def test_carried_the_plough_clears_the_ground():
    machine = plough_rig()
    data = mujoco.MjData(machine.model)
    data.qpos[:] = machine.start_qpos
    mujoco.mj_forward(machine.model, data)
    heights = [data.site(f"plough.share_{i}").xpos[2] for i in range(1, 5)]
    assert min(heights) > 0.05
    assert np.all(np.isfinite(heights))
