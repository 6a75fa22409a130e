"""The physics behind the environments: the same numbers as elsewhere, side by side or alone."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from twin import sensors
from twin.env import grounds, reward, starts
from twin.env.fleet import Fleet, GroundFrame, levers, lift_rad
from twin.env.instruments import Instruments
from twin.env.levers import depth_set_m, governor
from twin.env.quantities import PLACE, TRUE, powers
from twin.env.starts import APPROACH_S
from twin.machine.geometry import geometry
from twin.physics import block
from twin.pipeline import named as registry
from twin.simulation.build import build
from twin.simulation.columns import Recorder
from twin.simulation.guard import Diverged, repeat
from twin.streams import concatenate
from twin.trajectory.trajectory import Trajectory
from twin.truth import truth

ACTION = np.array([[0.2, 0.5]])
LEVEL = grounds.ground_shapes(0.25)[:1]


@pytest.fixture(scope="module")
def machine(environments):
    return environments["truth"].episodes.fleet.machine


@pytest.fixture(scope="module")
def begin(environments):
    return environments["estimate"].episodes.starts.of(LEVEL)[0]


def ground(seed):
    return grounds.draw(np.random.default_rng(seed), {}, LEVEL)


def test_truth_is_that_of_the_scores(machine, begin):
    fleet, recorder = Fleet(machine), Recorder(machine)
    fleet.restore([0], [begin] * 1, [ground(1)])
    fleet.drive(ACTION, record=True)
    records, seen = [], []
    for _ in range(150):
        seen.append(fleet.true())
        seen[-1] = {name: float(value[0]) for name, value in seen[-1].items()}
        records.append(fleet.drive(ACTION, record=True))
    table = truth.sample(recorder.trajectory(records), ("rl", "rr"))
    for name, values in table.items():
        if name in seen[0]:
            np.testing.assert_allclose(
                [s[name] for s in seen], values, rtol=1e-12, atol=1e-12, err_msg=name
            )
    assert {"slip", "speed_mps", "draft_n", "load_rl_n", "slip_fl"} <= table.keys() & seen[0].keys()
    np.testing.assert_allclose([s["v_y_rear_mps"] for s in seen], table["v_y_rear_mps"], atol=1e-12)
    assert max(s["depth_m"] for s in seen) > 0.2


@pytest.mark.parametrize("nthread", [1, 2])
def test_side_by_side_is_alone_to_the_bit(machine, begin, nthread):
    seeds = (1, 2, 3)
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (60, 3, 2))
    together = Fleet(machine, nsim=3, nthread=nthread)
    together.restore(range(3), [begin] * 3, [ground(s) for s in seeds])
    alone = []
    for seed in seeds:
        fleet = Fleet(machine)
        fleet.restore([0], [begin] * 1, [ground(seed)])
        alone.append(fleet)
    for action in actions:
        together.drive(action, record=False)
        everything = together.true()
        for i, fleet in enumerate(alone):
            fleet.drive(action[i : i + 1], record=bool(i))
            own = fleet.true()
            assert {k: v[0] for k, v in own.items()} == {k: v[i] for k, v in everything.items()}


def test_a_part_put_back_leaves_the_others(machine, begin):
    fleet, other = Fleet(machine, nsim=2), Fleet(machine, nsim=2)
    both = np.repeat(ACTION, 2, axis=0)
    for f in (fleet, other):
        f.restore([0, 1], [begin] * 2, [ground(1), ground(2)])
        for _ in range(20):
            f.drive(both, record=False)
    fleet.restore([1], [begin] * 1, [ground(3)])
    for f in (fleet, other):
        f.drive(both, record=False)
    assert fleet.batch.state[0].tobytes() == other.batch.state[0].tobytes()
    assert fleet.batch.state[1].tobytes() != other.batch.state[1].tobytes()


def test_drawn_patches_that_the_soil_cannot_have_are_left_out():
    slippery = {"soil.friction": 0.05, "field.cross_slope_deg": 0.0}
    for seed in range(20):
        free, held = (grounds.draw(np.random.default_rng(seed), o, LEVEL) for o in ({}, slippery))
        assert held.patches == ()
        assert (held.origin_m, held.noise_seed) == (free.origin_m, free.noise_seed)
    assert any(grounds.draw(np.random.default_rng(seed), {}, LEVEL).patches for seed in range(20))


@pytest.mark.parametrize(
    "soil", [{}, {"soil.preset": "lete-sand", "soil.cone_index_kpa": 800.0, "soil.friction": 0.6}]
)
def test_a_reset_patches_the_block_as_a_build_would_write_it(machine, begin, soil):
    """Whatever is drawn, but for the origin, which no scenario has."""
    options = soil | {
        "field.cross_slope_deg": 4.0,
        "field.grade_deg": -2.0,
        "field.furrow_depth_m": 0.25,
        "field.patches": [(5.0, 3.0, 0.7, 0.8), (20.0, 4.0, 0.9, 0.6)],
        "field.origin_m": (0.0, 0.0),
    }
    chosen = grounds.check_options(options)
    fleet, drawn = Fleet(machine), grounds.draw(np.random.default_rng(4), chosen, LEVEL)
    sloped = replace(begin, frame=GroundFrame.of(drawn.shape, machine.scenario.course))
    fleet.restore([0], [sloped], [drawn])
    patches = tuple(replace(p, start_m=begin.along_m + p.start_m) for p in drawn.patches)
    field = replace(drawn.shape.field(), patches=patches)
    scenario = replace(machine.scenario, soil=drawn.soil, seed=drawn.pattern_seed, field=field)
    built = build(scenario)
    np.testing.assert_array_equal(fleet.blocks[0], built.model.numeric_data[-block.SIZE :])
    np.testing.assert_array_equal(fleet.world_from_ground[0], built.world_from_ground)
    state = fleet.batch.get_data(0)
    mujoco.mj_kinematics(fleet.batch.get_model(0), state)
    np.testing.assert_allclose(  # what the body lands on when it rolls over lies as the field does
        state.geom("ground").xmat.reshape(3, 3), built.world_from_ground, atol=1e-12
    )


def test_a_start_on_a_slope_is_settled_on_it(machine):
    """The wheels carry the weight's normal part, and nothing changes any more."""
    shape = grounds.GroundShape(cross_slope_deg=5.0, grade_deg=3.0)
    begin = starts.settle(machine, [shape], seen=False)[0]
    fleet = Fleet(machine)
    same = {"soil.preset": "firm", "soil.friction": 0.88, "soil.cone_index_kpa": 1200.0}
    same |= {"field.origin_m": (0.0, 0.0), "field.patches": ()}
    drawn = grounds.draw(np.random.default_rng(0), same, [shape])
    fleet.restore([0], [begin], [drawn])
    true = fleet.true()
    load_n = sum(float(true[f"load_{w}_n"][0]) for w in ("fl", "fr", "rl", "rr"))
    weight_n = 9.81 * machine.model.body_subtreemass[0]
    tilt = math.cos(math.radians(5.0)) * math.cos(math.radians(3.0))
    assert load_n == pytest.approx(weight_n * tilt, rel=0.02)
    speed = true["speed_mps"][0]
    for _ in range(50):
        fleet.drive(fleet.steady(), record=False)
    assert fleet.true()["speed_mps"][0] == pytest.approx(speed, abs=0.02)


def test_instruments_see_what_a_whole_run_would(machine, begin):
    estimator = registry.load("estimator", "four-state")
    fleet, instruments = Fleet(machine), Instruments(machine, estimator)
    fleet.restore([0], [begin] * 1, [ground(5)])
    instruments.begin(6, begin.approach)
    records = []
    for _ in range(100):
        records.append(fleet.drive(ACTION, record=True))
        instruments.advance(records[-1])
    recorder = Recorder(machine)
    recorder.steps = len(begin.approach)
    rest = recorder.trajectory(records)
    whole = Trajectory(
        np.concatenate([begin.approach.epoch_ns, rest.epoch_ns]),
        {n: np.concatenate([begin.approach[n], rest[n]]) for n in begin.approach.columns},
    )
    config = machine.scenario.sensors
    streams = sensors.sample(config, sensors.init(config, 6), whole)[1]
    setup = sensors.setup(config, geometry(machine))
    estimates = estimator.run(estimator.init(setup), streams)[1]
    seen = instruments.values()
    for name in ("slip", "slip_sd", "speed_mps", "wheel_speed_mps"):
        assert seen[name] == estimates[name][-1]
    for name in ("gnss.v_east_mps", "imu.gyro_z_radps", "machine.draft_pin_n", "depth.laser_m"):
        sensor, column = name.split(".")
        assert seen[name] == concatenate([streams])[sensor][column][-1]
    assert seen["depth_m"] == pytest.approx(float(fleet.true()["depth_m"][0]), abs=0.05)
    assert 0.05 <= seen["gnss.age_s"] <= 0.13


def test_the_approach_leads_to_the_start(machine, begin):
    assert len(begin.approach) == round(APPROACH_S / machine.model.opt.timestep)
    fleet = Fleet(machine)
    fleet.restore([0], [begin] * 1, [ground(7)])
    last = begin.approach["position_w"][-1] + 0.002 * begin.approach["velocity_w"][-1]
    np.testing.assert_allclose(fleet.qpos[0, :3], last, atol=1e-6)


def test_actions_mean_what_the_table_says(machine):
    numbers = machine.numbers
    idle, top = numbers["engine.idle_rpm"], numbers["engine.no_load_rpm"]
    set_rpm = idle + governor(np.array([-1.0, 0.0, 1.0]), levers(machine)) * (top - idle)
    np.testing.assert_allclose(set_rpm, [900.0, 1638.0, 2376.0])
    np.testing.assert_allclose(depth_set_m(np.array([-1.0, 1.0])), [-0.10, 0.35])
    sole, axle = numbers["plough.sole_below_hitch_m"], machine.model.body("tractor").pos[2]
    axle = axle - 0.5 * 0.25  # one side of the axle is down in the furrow
    for depth in (-0.10, 0.0, 0.25, 0.35):
        expected = machine.hitch.lift_rad_at(sole - depth, axle)
        assert lift_rad(machine, depth) == pytest.approx(expected, abs=1e-14)


def test_efficiency_is_drawbar_power_over_axle_power():
    out = np.zeros((len(TRUE), 3))
    for name, values in {
        "draft_n": [20e3, 0.0, 1e3],
        "speed_mps": [1.5, 2.0, 1.0],
        "axle_torque_nm": [25e3, 3e3, 0.0],
        "axle_radps": [2.0, 2.4, 2.0],
    }.items():
        out[PLACE[name]] = values
    powers(np.arange(3), 1e3, out)
    np.testing.assert_allclose(out[PLACE["traction_efficiency"]], [0.6, 0.0, 0.0])


def test_reward_terms_at_and_beside_their_targets():
    names = list(reward.PLOUGHING)
    for speed, slip, depth, expected in (
        (1e4 / 3600.0 / 1.4, 0.12, 0.25, {"slip": 0.25, "depth": 0.25, "work": 0.30}),
        (0.0, 0.17, 0.22, {"slip": 0.125, "depth": 0.125, "work": 0.0}),
    ):
        rate = reward.work_rate_m2ps(speed, depth, 1.4, 0.25)
        terms = reward.ploughing(rate, 0.5, slip, depth, 0.12, 0.25)
        terms = dict(zip(names, terms, strict=True))
        assert terms == pytest.approx(expected | {"efficiency": 0.1})
    assert sum(reward.PLOUGHING.values()) == pytest.approx(1.0)


def test_nothing_is_compiled_on_reset(truth_env, monkeypatch):
    def fails(*args, **kwargs):
        raise AssertionError("compiled on reset")

    monkeypatch.setattr(mujoco.MjSpec, "compile", fails)
    truth_env.reset(seed=1, options={"soil.preset": "soft"})
    truth_env.step(np.zeros(2))


def test_a_failure_names_the_machine_and_what_was_not_finite(machine, begin):
    fleet = Fleet(machine, nsim=2)
    fleet.restore([0, 1], [begin] * 2, [ground(1), ground(2)])
    fleet.qvel[1, machine.model.joint("rl_spin").dofadr[0]] = np.inf
    with pytest.raises(Diverged, match=r"rl.* of machine 1 of 'Plough-v0'") as caught:
        fleet.drive(np.repeat(ACTION, 2, axis=0), record=False)
    assert repeat(fleet.batch.get_model(1), caught.value.evidence.states, fleet.steps).failure
    fleet.restore([1], [begin], [ground(2)])
    fleet.drive(np.repeat(ACTION, 2, axis=0), record=False)


def downhill(machine, nsim=1):
    """Tractors on a hard slope down, the plough carried, and their actions: full throttle."""
    fleet = Fleet(machine, nsim)
    shape = grounds.GroundShape(cross_slope_deg=0.0, grade_deg=-15.0, furrow_depth_m=0.05)
    starts.stand(fleet, [shape] * nsim)
    return fleet, np.tile([[-1.0, -1.0]], (nsim, 1))


def test_the_driver_brakes_downhill_as_in_a_run(machine):
    fleet, slow = downhill(machine, 2)
    pressed, rates = [], []
    for _ in range(500):
        fleet.drive(slow, record=False)
        pressed.append(fleet.pedals["pedal"].copy())
        rates.append(66.0 * fleet.qvel[:, fleet.engine] * 30.0 / np.pi)
    assert np.all(np.array(pressed)[:, 0] == np.array(pressed)[:, 1])
    assert np.max(pressed) > 0.0
    assert np.mean(rates[-100:]) < 1.08 * 900.0
    assert np.max(rates) < 1.15 * machine.numbers["engine.no_load_rpm"]


def test_a_start_keeps_the_pedal_where_it_was(machine):
    shape = grounds.GroundShape(cross_slope_deg=0.0, grade_deg=-15.0, furrow_depth_m=0.05)
    (begin,) = starts.settle(machine, [shape], seen=False)
    fleet = Fleet(machine)
    fleet.restore([0], [begin], [replace(ground(1), shape=shape)])
    assert fleet.pedals[0] == begin.pedal
    assert begin.pedal["asked_radps"] > 0.0
