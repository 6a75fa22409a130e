"""How the operator sets the plough: top link, depth wheel, and upright in the furrow."""

from __future__ import annotations

import math
from typing import Any

from twin.machine.hitch import Hitch
from twin.machine.parameters import body_id
from twin.scenario import FURROW_SIDES, Scenario

GRAVITY_MPS2 = 9.81


def furrow_roll_rad(scenario: Scenario, spec: Any) -> float:
    """Roll of the tractor in the furrow, atan(depth / track); positive lowers the right side."""
    if scenario.plough is None:
        return 0.0
    track_m = 2.0 * float(spec.body("rl_wheel").pos[1])
    side = FURROW_SIDES[scenario.plough.furrow]
    return -side * math.atan(scenario.plough.depth_m / track_m)


def levelled(roll_rad: float) -> list[float]:
    """Rotation of the plough on its links that keeps it upright while the tractor rolls; wxyz."""
    return [math.cos(0.5 * roll_rad), -math.sin(0.5 * roll_rad), 0.0, 0.0]


def set_plough(
    model: Any,
    plough: Any,
    draft_scale: float,
    numbers: dict[str, float],
    hitch: Hitch,
    axle_height_m: float,
) -> float:
    """Set top link and depth wheel so that the plough works level at its depth; the link angle."""
    sole_m = numbers["plough.sole_below_hitch_m"]
    work_rad = hitch.lift_rad_at(sole_m - plough.depth_m, axle_height_m)
    model.tendon_lengthspring[model.tendon("top_link").id] = hitch.top_length_m(work_rad, -work_rad)
    expected_n = expected_draft_n(numbers, plough.depth_m, draft_scale)
    weight_n = GRAVITY_MPS2 * model.body_subtreemass[body_id(model, "plough.frame")]
    carried_n = plough.wheel_share * (weight_n + numbers["plough.vertical_ratio"] * expected_n)
    sag_m = carried_n / numbers["plough.depth_wheel.stiffness_npm"]
    radius_m = numbers["plough.depth_wheel.radius_m"]
    model.body("plough.depth_wheel").pos[2] = plough.depth_m - sole_m + radius_m - sag_m
    return work_rad


def expected_draft_n(numbers: dict[str, float], depth_m: float, draft_scale: float) -> float:
    """Draft the operator expects at 5.5 km/h (ASABE D497), to set depth wheel and hitch by."""
    specific = numbers["plough.draft_a"] + numbers["plough.draft_c"] * 5.5**2
    width_m = numbers["plough.bodies"] * numbers["plough.body_width_m"]
    return draft_scale * specific * width_m * 100.0 * depth_m
