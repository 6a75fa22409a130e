"""The compiled machine: its mass, its ground, its stance."""

import math

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.simulation.rigs import BARE, PLOUGHING, bare_rig, field, plough_rig, replace
from twin.machine.ground_frame import world_from_ground
from twin.physics import block
from twin.physics.block import WheelSlot
from twin.scenario import Course, Field, Patch
from twin.simulation.build import build


def stand(machine, seconds=3.0):
    """Loads of the four wheels, standing with brakes on, plough carried."""
    data = mujoco.MjData(machine.model)
    data.qpos[:] = machine.start_qpos
    for name, value in (("brake", 1.0), ("clutch_pedal", 1.0), ("lift", 0.6)):
        data.ctrl[machine.model.actuator(name).id] = value
    mujoco.mj_step(machine.model, data, round(seconds / machine.model.opt.timestep))
    slots = data.userdata[: block.MACHINE_SLOTS].reshape(4, int(WheelSlot.SIZE))
    return dict(zip(block.WHEELS, slots[:, WheelSlot.LOAD_N], strict=True)), data


def test_the_tractor_weighs_what_is_published():
    machine = bare_rig()
    assert machine.model.body("tractor").subtreemass == pytest.approx(5260.0, rel=0.001)


def test_the_plough_weighs_what_is_published_and_only_when_there():
    plough, bare = plough_rig().model, bare_rig().model
    added = plough.body("tractor").subtreemass - bare.body("tractor").subtreemass
    assert added == pytest.approx(1470.0, rel=0.001)
    assert mujoco.mj_name2id(bare, mujoco.mjtObj.mjOBJ_BODY, "plough.frame") == -1


def test_standing_loads_are_the_weight_shared_by_the_levers():
    """On the level, moments about the rear axle: N_f L = m g x_cg."""
    machine = bare_rig()
    loads, data = stand(machine)
    mass = machine.model.body("tractor").subtreemass[0]
    assert sum(loads.values()) == pytest.approx(mass * 9.81, rel=1e-4)
    body = machine.model.body("tractor").id
    rear_axle = data.xpos[body]
    ahead = data.xmat[body].reshape(3, 3)[:, 0]
    lever = (data.subtree_com[body] - rear_axle) @ ahead
    front = loads["fl"] + loads["fr"]
    assert front == pytest.approx(mass * 9.81 * lever / 2.55, rel=0.005)
    assert front / (mass * 9.81) == pytest.approx(0.42, abs=0.005)
    assert loads["fl"] == pytest.approx(loads["fr"], rel=1e-6)
    assert loads["rl"] == pytest.approx(loads["rr"], rel=1e-6)


def test_a_positive_cross_slope_rises_to_the_left_and_loads_the_right():
    loads, data = stand(build(field(BARE, cross_slope_deg=10.0)))
    body = data.body("tractor").xmat.reshape(3, 3)
    assert math.degrees(math.asin(body[2, 1])) == pytest.approx(10.0, abs=1.0)  # left side up
    assert loads["fr"] > loads["fl"]
    assert loads["rr"] > loads["rl"]
    mass = 5260.0 * 9.81
    assert sum(loads.values()) == pytest.approx(mass * math.cos(math.radians(10.0)), rel=2e-3)


def test_a_positive_grade_rises_ahead_and_loads_the_rear():
    level, _ = stand(bare_rig())
    uphill, data = stand(build(field(BARE, grade_deg=10.0)))
    body = data.body("tractor").xmat.reshape(3, 3)
    assert math.degrees(math.asin(body[2, 0])) == pytest.approx(10.0, abs=1.0)  # nose up
    assert uphill["rl"] > level["rl"]
    assert uphill["fl"] < level["fl"]


@pytest.mark.parametrize("heading_deg", [90.0, -135.0])
def test_heading_turns_the_course_counter_clockwise_from_east(heading_deg):
    _, data = stand(build(replace(BARE, course=Course(heading_deg=heading_deg))))
    ahead = data.body("tractor").xmat.reshape(3, 3)[:, 0]
    assert math.degrees(math.atan2(ahead[1], ahead[0])) == pytest.approx(heading_deg, abs=0.1)


def test_the_ground_frame_is_yaw_then_pitch_up_then_roll():
    for heading, grade, cross in [(17.0, 0.0, 18.0), (-120.0, 7.0, -9.0), (179.0, -15.0, 25.0)]:
        ours = world_from_ground(
            Field(cross_slope_deg=cross, grade_deg=grade), Course(heading_deg=heading)
        )
        theirs = Rotation.from_euler("ZYX", [heading, -grade, cross], degrees=True)
        assert ours == pytest.approx(theirs.as_matrix(), abs=1e-14)
        assert math.degrees(math.asin(ours[2, 0])) == pytest.approx(grade)


def test_the_block_says_what_the_scenario_asked():
    scenario = replace(
        PLOUGHING, soil=replace(PLOUGHING.soil, cone_index_kpa=777.0, friction=0.6), seed=99
    )
    numbers = build(scenario).model.numeric_data[-block.SIZE :]
    assert numbers[0] == block.MAGIC
    assert numbers[block.FIELD + block.Field.SEED] == 99.0
    assert numbers[block.SOIL + block.Soil.CONE_INDEX_KPA] == 777.0
    assert numbers[block.SOIL + block.Soil.FRICTION] == 0.6


def test_wheels_touch_through_the_law_only_and_activations_fit_the_slots():
    for scenario in (BARE, PLOUGHING):
        machine = build(scenario, looks=True)  # without looks the tyres' shapes are left out
        model = machine.model
        for wheel in block.WHEELS:
            geom = model.geom(f"{wheel}_tyre")
            assert geom.contype[0] == geom.conaffinity[0] == 0
        assert model.nuserdata >= block.RATE_SLOTS + model.na
        _, data = stand(machine, 0.2)
        assert data.ncon == 0
        _, data = stand(build(scenario), 0.2)
        assert data.ncon == 0


@pytest.mark.parametrize(("side", "sign"), [("left", 1.0), ("none", 0.0), ("right", -1.0)])
def test_the_block_says_where_the_furrow_is(side, sign):
    machine = build(replace(PLOUGHING, plough=replace(PLOUGHING.plough, furrow=side)))
    field = machine.model.numeric_data[-block.SIZE :][block.FIELD : block.SOIL]
    assert field[block.Field.FURROW_SIDE] == sign
    assert field[block.Field.FURROW_DEPTH_M] == 0.25
    # its wall is where the leaning tyre's flank is: the tread r sin(roll) nearer the land
    track_m = 2.0 * float(machine.model.body("rl_wheel").pos[1])
    roll_rad = math.asin(0.25 / track_m)
    flank_m = 0.5 * (track_m - machine.numbers["tyre_rear.width_m"]) * math.cos(roll_rad)
    wall_m = flank_m - 0.5 * machine.numbers["tyre_rear.diameter_m"] * math.sin(roll_rad)
    assert field[block.Field.FURROW_EDGE_M] == pytest.approx(wall_m)


def test_the_block_says_the_grounds_shape_and_its_patches():
    ground = Field(
        cross_slope_deg=5.0,
        grade_deg=-3.0,
        roughness_class="C",
        patches=(Patch(start_m=10.0, length_m=5.0, friction_factor=0.5, cone_index_factor=0.8),),
    )
    machine = build(replace(BARE, field=ground))
    field = machine.model.numeric_data[-block.SIZE :][block.FIELD : block.SOIL]
    axes = np.reshape(field[block.Field.AHEAD : block.Field.NORMAL + 3], (3, 3))
    np.testing.assert_allclose(axes.T, world_from_ground(ground, BARE.course), atol=1e-12)
    assert (
        field[block.Field.HEIGHTS + block.Grid.COLUMNS] == machine.model.hfield("heights").ncol[0]
    )
    assert field[block.Field.MIXTURE + block.Grid.ROWS] == 0.0
    assert field[block.Field.PATCH_COUNT] == 1.0
    at = block.Field.PATCHES
    assert field[at : at + 4] == pytest.approx([10.0, 15.0, 0.5, 0.8])


@pytest.mark.parametrize("timestep_s", [0.0005, 0.001])
def test_the_time_step_is_the_scenarios(timestep_s):
    machine = build(replace(BARE, timestep_s=timestep_s))
    assert machine.model.opt.timestep == timestep_s


def test_a_machine_to_be_looked_at_is_the_same_and_need_not_settle():
    seen, driven = build(PLOUGHING, looks=True, settle=False), build(PLOUGHING, looks=True)
    np.testing.assert_array_equal(seen.model.body_pos, driven.model.body_pos)
    np.testing.assert_array_equal(seen.model.geom_pos, driven.model.geom_pos)
    assert np.isfinite(seen.start_qpos).all()
    assert np.isnan(seen.start_load_n).all()
