"""The linkage's geometry against the same linkage in MuJoCo."""

import math
from functools import cache

import mujoco
import numpy as np
import pytest

from tests.simulation.rigs import LEVEL_PLOUGHING, PLOUGHING, plough_rig, replace
from twin.physics import block
from twin.scenario import Plough
from twin.simulation.build import build


@cache
def level_rig():
    return build(LEVEL_PLOUGHING)


def posed(machine, lift, pitch):
    data = mujoco.MjData(machine.model)
    data.joint("lift").qpos[0], data.joint("plough.pitch").qpos[0] = lift, pitch
    mujoco.mj_forward(machine.model, data)
    return data


@pytest.mark.parametrize("lift", [-0.3, 0.0, 0.6])
@pytest.mark.parametrize("pitch", [-0.4, 0.0, 0.25])
def test_points_and_top_link_are_where_mujoco_has_them(lift, pitch):
    machine = level_rig()
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
    machine = build(replace(PLOUGHING, plough=Plough(depth_m=depth_m, furrow="none")))
    data = posed(machine, machine.work_rad, -machine.work_rad)
    for i in range(1, 5):
        assert data.site(f"plough.share_{i}").xpos[2] == pytest.approx(-depth_m, abs=1e-9)
    tendon = machine.model.tendon("top_link").id
    assert data.ten_length[tendon] == pytest.approx(machine.model.tendon_lengthspring[tendon][0])


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("depth_m", [0.15, 0.30])
def test_in_the_furrow_all_shares_are_level_at_their_depth(depth_m, side):
    """The tractor rolled by atan(depth / track), its axle's middle half the depth lower."""
    machine = build(replace(PLOUGHING, plough=Plough(depth_m=depth_m, furrow=side)))
    data = posed(machine, machine.work_rad, -machine.work_rad)
    track_m = 2.0 * float(machine.model.body("rl_wheel").pos[1])
    roll_rad = math.atan(depth_m / track_m) * (1.0 if side == "right" else -1.0)
    data.qpos[2] -= 0.5 * depth_m
    data.qpos[3:7] = math.cos(0.5 * roll_rad), math.sin(0.5 * roll_rad), 0.0, 0.0
    mujoco.mj_forward(machine.model, data)
    first = machine.model.nnumericdata - block.SIZE + block.PLOUGH + int(block.Plough.SHARES)
    shares = machine.model.numeric_data[first : first + 12].reshape(4, 3)  # turned to their side
    frame = data.body("plough.frame")
    heights = (frame.xpos + shares @ frame.xmat.reshape(3, 3).T)[:, 2]
    assert np.ptp(heights) < 0.02 * depth_m
    assert np.mean(heights) == pytest.approx(-depth_m, abs=0.005)


def test_carried_the_plough_clears_the_ground():
    machine = plough_rig()
    data = mujoco.MjData(machine.model)
    data.qpos[:] = machine.start_qpos
    mujoco.mj_forward(machine.model, data)
    heights = [data.site(f"plough.share_{i}").xpos[2] for i in range(1, 5)]
    assert min(heights) > 0.05
    assert np.all(np.isfinite(heights))
