"""The tractor in the furrow: how it leans, what its wheels carry, and what is a mirror of what."""

import math
from functools import cache

import mujoco
import numpy as np
import pytest

from tests.simulation.rigs import (
    EVEN_PLOUGHING,
    PLOUGHING,
    driven,
    plough_rig,
    replace,
    set_controls,
    start,
    wheels,
)  # fmt: skip
from twin.physics import block
from twin.physics.block import MachineSlot, WheelSlot
from twin.scenario import Plough
from twin.simulation.build import build

DEPTHS_M = (0.15, 0.20, 0.25, 0.30)
LATE = slice(-5000, None)
"""The last 10 s: at full depth, settled."""


def furrowed(depth_m, side):
    return replace(EVEN_PLOUGHING, plough=Plough(depth_m=depth_m, furrow=side))


@cache
def means(depth_m, side):
    """Means of the columns over the last 10 s."""
    return {n: v[LATE].mean(axis=0) for n, v in driven(furrowed(depth_m, side)).items()}


def roll_deg(world_from_body):
    w, x, y, z = np.moveaxis(world_from_body, -1, 0)
    return np.degrees(np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)))


@pytest.mark.parametrize("side", ["right", "left"])
@pytest.mark.parametrize("depth_m", DEPTHS_M)
def test_the_roll_is_that_of_the_furrow_and_the_rear_tyres(depth_m, side):
    """atan((depth + more deflection on its lower side) / track); positive lowers the right."""
    c, machine = means(depth_m, side), plough_rig()
    track_m = 2.0 * float(machine.model.body("rl_wheel").pos[1])
    rl, rr = c["load_n"][2:] / machine.numbers["tyre_rear.stiffness_npm"]
    lower = depth_m if side == "right" else -depth_m
    expected_deg = math.degrees(math.atan((lower + rr - rl) / track_m))
    assert roll_deg(c["world_from_body"]) == pytest.approx(expected_deg, abs=0.3)


@pytest.mark.parametrize("depth_m", DEPTHS_M)
def test_a_furrow_on_the_left_is_the_mirror_of_one_on_the_right(depth_m):
    right, left = means(depth_m, "right"), means(depth_m, "left")
    swapped = [1, 0, 3, 2]
    for name in ("load_n", "shear_x_n", "slip", "rolling_radius_m"):
        assert left[name] == pytest.approx(right[name][swapped], rel=1e-4), name
    for name in ("wall_n", "shear_y_n"):
        assert left[name] == pytest.approx(-right[name][swapped], abs=2.0), name
    for name in ("plough_side_n", "steer_rad"):
        assert left[name] == pytest.approx(-right[name], rel=1e-3, abs=1e-5), name
    for name in ("draft_n", "depth_m", "landside_n", "engine_radps"):
        assert left[name] == pytest.approx(right[name], rel=1e-4), name
    assert left["position_w"][1] == pytest.approx(-right["position_w"][1], abs=1e-4)
    assert roll_deg(left["world_from_body"]) == pytest.approx(
        -roll_deg(right["world_from_body"]), abs=1e-3
    )


def test_the_deeper_the_furrow_the_more_its_rear_wheel_carries():
    extra = [np.diff(means(d, "right")["load_n"][2:])[0] for d in DEPTHS_M]
    assert np.all(np.diff(extra) > 500.0)
    assert extra[0] > 1e3
    level = driven(replace(EVEN_PLOUGHING, plough=Plough(depth_m=0.25, furrow="none")))
    assert abs(np.diff(level["load_n"][LATE].mean(axis=0)[2:])[0]) < 0.5 * extra[0]
    assert not np.any(level["wall_n"])


@pytest.mark.parametrize("depth_m", DEPTHS_M)
def test_wheels_and_walls_hold_what_weighs_and_pulls(depth_m):
    """Steady: loads carry weight and the soil's pull down; nothing is left over sideways.

    A leaning flank is pushed square to itself, so the wall carries a little too.
    """
    c = {n: v[LATE] for n, v in driven(furrowed(depth_m, "right")).items()}
    weight_n = 9.81 * float(plough_rig().model.body("tractor").subtreemass[0])
    down = c["load_n"].sum(axis=1) + c["draft_w"][:, 2]
    w, x, y, z = c["world_from_body"].T
    lean = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    down += c["wall_n"].sum(axis=1) * np.tan(lean)
    assert down.mean() == pytest.approx(weight_n, rel=2e-4)
    straight = np.zeros_like(w)
    steered = np.stack([c["fl_steer_rad"], c["fr_steer_rad"], straight, straight], axis=1)
    course = steered + np.arctan2(2.0 * (x * y + w * z), 1.0 - 2.0 * (y * y + z * z))[:, None]
    ahead, left = c["shear_x_n"] - c["resistance_n"], c["shear_y_n"] + c["wall_n"]
    wheels_n = (left * np.cos(course) + ahead * np.sin(course)).sum(axis=1)
    sideways = wheels_n + c["draft_w"][:, 1]
    assert sideways.mean() == pytest.approx(0.0, abs=0.004 * c["draft_n"].mean())
    assert np.all(c["load_n"] > 3e3)


def test_the_furrow_begins_before_the_plough_is_lowered():
    """On the approach the tractor is level; it leans within the ramp ahead of the plough."""
    c = driven(replace(EVEN_PLOUGHING, course=replace(EVEN_PLOUGHING.course, approach_m=8.0)))
    along, roll = c["position_w"][:, 0], roll_deg(c["world_from_body"])
    assert np.abs(roll[along < 3.0]).max() < 0.3
    assert roll[along > 11.0].min() > 7.0
    assert c["depth_m"][along < 8.0].max() == 0.0


def test_parked_with_the_plough_in_the_ground_nothing_chatters():
    """Brakes on after ploughing: lateral acceleration and landside die away at 2 ms steps."""
    machine = plough_rig()
    data, model = start(machine), machine.model
    set_controls(machine, data, throttle=machine.throttle, differential_lock=1.0, lift=0.2)
    mujoco.mj_step(model, data, 5000)
    set_controls(machine, data, brake=1.0, clutch_pedal=1.0, lift=0.2)
    mujoco.mj_step(model, data, 2500)
    lateral = []
    for _ in range(1000):
        mujoco.mj_step(model, data)
        lateral.append(data.qacc[1])
    assert data.userdata[block.MACHINE_SLOTS + MachineSlot.DEPTH_M] > 0.15
    assert np.abs(lateral).max() < 0.05
    assert np.linalg.norm(data.qvel[:6]) < 1e-3
    assert data.warning.number.sum() == 0


def test_the_side_of_the_furrow_is_where_it_is_said_to_be():
    for side, lower, upper in (("right", "rr", "rl"), ("left", "rl", "rr")):
        machine = build(replace(PLOUGHING, plough=Plough(furrow=side)))
        data = start(machine)
        set_controls(machine, data, throttle=machine.throttle, lift=0.6)
        mujoco.mj_step(machine.model, data, 3000)
        slots = dict(zip(block.WHEELS, wheels(data), strict=True))
        centre_m = {
            w: data.body(f"{w}_wheel").xpos[2] + slots[w][WheelSlot.DEFLECTION_M]
            for w in ("rl", "rr")
        }
        assert centre_m[upper] - centre_m[lower] == pytest.approx(0.25, abs=0.01)
