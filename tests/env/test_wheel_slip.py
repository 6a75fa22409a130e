"""WheelSlip-v0: torques, the towed draft, slip and sideslip, bits, options."""

import gymnasium
import numpy as np
import pytest

from tests.env.test_plough_env import assert_same_to_the_bit, rolled
from twin.env.grounds import ROLLED
from twin.env.observations import (
    MODES,
    TORQUE_ESTIMATE,
    TORQUE_SENSORS,
    TORQUE_TASK,
    TORQUE_TRUTH,
)  # fmt: skip
from twin.env.reward import PULLING
from twin.env.torque_fleet import pulled_law
from twin.env.towing import draft_n
from twin.env.wheel_slip import WheelSlipEnv
from twin.errors import BadInput, UnknownName
from twin.vehicle import files

PULLED = pulled_law(files.implement("cultivator_light"))
LEVEL = {"field.cross_slope_deg": 0.0, "field.grade_deg": 0.0, "field.patches": ()}
DRY = {"soil.preset": "dry", "soil.friction": 0.88, "soil.cone_index_kpa": 1200.0}


@pytest.fixture(scope="module")
def pulling():
    made = {m: gymnasium.make("twin.env:WheelSlip-v0", observation=m).unwrapped for m in MODES}
    yield made
    for env in made.values():
        env.close()


def held(env, action, steps, options=None, seed=1):
    env.reset(seed=seed, options=LEVEL | DRY | (options or {}))
    for _ in range(steps):
        *_, info = env.step(np.asarray(action, dtype=np.float32))
    return info


def test_what_is_observed_changes_nothing_that_happens(pulling):
    first, *others = (rolled(env, 7, 60) for env in pulling.values())
    for other in others:
        assert [step[1:] for step in first] == [step[1:] for step in other]


def test_steady_pull_is_the_draft_and_more_torque_is_more_slip(pulling):
    """The rear axle's gross thrust less the wheels' resistance is the cultivator's draft."""
    low, high = (held(pulling["truth"], [u, u], 500) for u in (0.4, 0.6))
    assert 0.02 < low["slip"] < high["slip"] < 0.2
    for info in (low, high):
        scale = 0.70 * np.array([0.8, 1.2])
        bounds = draft_n(scale, np.full(2, info["speed_mps"]), PULLED)
        assert bounds[0] <= info["draft_n"] <= bounds[1]
        assert 0.4 < info["traction_efficiency"] < 0.9


def test_draft_resists_the_motion_and_holds_nothing_at_rest():
    np.testing.assert_allclose(
        draft_n(np.full(4, 0.5), np.array([1.0, -1.0, 0.05, 0.0]), PULLED),
        [105.0, -105.0, 0.5 * (80.0 + 130.0 * 0.0025) * 0.5, 0.0],
    )


def test_the_stronger_wheel_slips_more(pulling):
    info = held(pulling["truth"], [0.65, 0.45], 100)
    assert info["slip_rl"] > info["slip_rr"] + 0.02


def test_a_slope_to_the_left_slides_it_to_the_right_and_slip_makes_it_worse(pulling):
    calm, wild = (
        held(pulling["truth"], [u, u], 300, {"field.cross_slope_deg": 8.0}) for u in (0.4, 0.95)
    )
    assert calm["v_y_rear_mps"] < -0.01
    assert wild["v_y_rear_mps"] < 2.0 * calm["v_y_rear_mps"]


def test_a_slippery_patch_lets_the_wheels_spin(pulling):
    on = held(pulling["truth"], [0.6, 0.6], 200, {"field.patches": [(1.5, 30.0, 0.5, 1.0)]})
    off = held(pulling["truth"], [0.6, 0.6], 200)
    assert on["slip"] > off["slip"] + 0.1


def test_it_starts_rolling_at_its_speed(pulling):
    for mode in ("truth", "estimate"):
        observation, info = pulling[mode].reset(seed=2, options=LEVEL | DRY)
        seen = dict(zip([e.name for e in pulling[mode].entries], observation, strict=True))
        assert info["speed_mps"] == pytest.approx(1.0, abs=0.05)
        assert seen["speed_mps"] == pytest.approx(info["speed_mps"], abs=0.1)
        assert seen["slip"] == pytest.approx(info["slip"], abs=0.05)


def test_wet_soil_takes_the_front_wheels_grip(pulling):
    env = pulling["truth"]
    fleet = env.episodes.fleet
    ratio = fleet.machine.numbers["tyre_front.lateral_ratio"]
    for preset, factor in (("dry", 1.0), ("wet", 0.78)):
        env.reset(seed=1, options={"soil.preset": preset})
        np.testing.assert_allclose(fleet.blocks[0, fleet.front_grip], factor * ratio)


def test_reward_is_the_sum_of_its_terms_and_never_negative(pulling):
    for _, value, _, _, info in rolled(pulling["truth"], 8, 100)[1:]:
        parts = [info[f"reward_{name}"] for name in PULLING]
        assert value == sum(parts)
        assert min(parts) >= 0.0
    assert sum(PULLING.values()) == pytest.approx(1.0)


def test_what_cannot_be_is_named_and_changes_nothing(pulling):
    env = pulling["truth"]
    untouched = rolled(env, 14, 2)
    env.reset(seed=14)
    with pytest.raises(UnknownName, match=r"field\.furrow_depth_m"):
        env.reset(seed=1, options={"field.furrow_depth_m": 0.2})
    with pytest.raises(BadInput, match=r"action\[1\] \(torque_right\) = nan"):
        env.step(np.array([0.0, np.nan]))
    with pytest.raises(BadInput, match=r"shape \(3,\), not \(2,\)"):
        env.step(np.zeros(3))
    actions = np.random.default_rng(14).uniform(-1.0, 1.0, (2, 2)).astype(np.float32)
    assert_same_to_the_bit(untouched[1:], [env.step(a) for a in actions])


def test_the_docstring_tables_name_every_entry_with_its_bounds():
    rows = [
        [cell.strip() for cell in line.split("|")[1:-1]]
        for line in WheelSlipEnv.__doc__.splitlines()
        if line.strip().startswith("|")
    ]
    found = [
        (r[0], float(r[1]), float(r[2]))
        for r in rows
        if len(r) == 5 and r[1].lstrip("-").replace(".", "").isdigit()
    ]
    entries = (*TORQUE_ESTIMATE, *TORQUE_SENSORS, *TORQUE_TRUTH, *TORQUE_TASK)
    assert found == [(e.name, e.low, e.high) for e in entries]
    for name in (*PULLING, *ROLLED.options):
        assert name in WheelSlipEnv.__doc__
