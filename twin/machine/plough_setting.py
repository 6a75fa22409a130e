"""How the operator sets the plough: top link, lever, depth wheel, and roll on the links."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np

from twin.machine.hitch import FLOAT_RAD, Hitch
from twin.machine.parameters import body_id
from twin.physics.block import Plough as Block
from twin.physics.plough import draft_n as draft_of
from twin.scenario import Plough, Scenario
from twin.scenario.plough import FURROW_SIDES

GRAVITY_MPS2 = 9.81
SWING_RAD = 1e-4
"""Small angle of the lower links by which a floating plough is in balance [rad]."""


@dataclass(frozen=True)
class Setting:
    """The operator's setting of the lever and the depth wheel."""

    lever_rad: float
    """Angle of the lower links in work [rad]; 0 is level."""
    lowest_rad: float
    """Lowest angle to which the lift lowers [rad]."""
    draft_n: float
    """Expected draft in work [N]."""
    sag_m: float
    """Deflection of the depth wheel's tyre where the plough is level at its depth; negative: its
    clearance from the ground."""


@dataclass(frozen=True)
class Mounted:
    """A plough on its linkage, for `by_geometry`; points are (x, z) in the vertical plane."""

    plough: Plough
    numbers: dict[str, float]
    """<numeric> values of the machine and its implement by name."""
    hitch: Hitch
    axle_height_m: float
    """Height of the rear axle's centre above the unploughed ground, in work."""
    weight_n: float
    points: dict[str, tuple[float, float]]
    """`mass`: centre of mass; `resultant`: point where the soil's force acts; `hub` of the depth
    wheel. From the plough's lower hitch points [m]."""
    draft_n: float
    """Expected draft at 5.5 km/h and the set depth."""
    deepest_m: float
    """Greatest depth to which the hitch modes `draft` and `mix` lower the plough."""

    @property
    def work_rad(self) -> float:
        """Lower-link angle at which the level plough has its depth, if the tyres do not sink."""
        sole_m = self.numbers["plough.sole_below_hitch_m"]
        return self.hitch.lift_rad_at(sole_m - self.plough.depth_m, self.axle_height_m)

    @property
    def top_length_m(self) -> float:
        """Length of the top link with which the plough is level at `work_rad`."""
        return self.hitch.top_length_m(self.work_rad, -self.work_rad)

    @property
    def soil_down_n(self) -> float:
        """Downward force of the soil that goes with the draft."""
        return self.numbers["plough.vertical_ratio"] * self.draft_n

    def place(self, lift_rad: float, name: str) -> tuple[float, float]:
        """Position (x, z) from the rear axle [m] of the point `name` at a lower-link angle."""
        return self.hitch.plough_point(lift_rad, self.top_length_m, self.points[name])


def furrow_roll_rad(scenario: Scenario, spec: mujoco.MjSpec) -> float:
    """Roll of the tractor in the furrow, atan(depth / track); positive lowers the right side."""
    if scenario.plough is None:
        return 0.0
    track_m = 2.0 * float(spec.body("rl_wheel").pos[1])
    side = FURROW_SIDES[scenario.plough.furrow]
    return -side * math.atan(scenario.plough.depth_m / track_m)


def levelled(roll_rad: float) -> list[float]:
    """Rotation of the plough on its links that keeps it upright while the tractor rolls; wxyz."""
    return [math.cos(0.5 * roll_rad), -math.sin(0.5 * roll_rad), 0.0, 0.0]


def mounted(
    model: mujoco.MjModel,
    plough: Plough,
    draft_scale: float,
    numbers: dict[str, float],
    hitch: Hitch,
    axle_height_m: float,
    deepest_m: float,
) -> Mounted:
    """The plough of a compiled model, before it is set.

    `draft_scale` is the soil factor F of ASABE D497 that the operator expects; the other arguments
    are as the fields of `Mounted`.
    """
    sites = [model.site(i) for i in range(model.nsite)]
    shares_m = np.mean([s.pos for s in sites if s.name.startswith("plough.share_")], axis=0)
    above_sole_m = (1.0 - numbers["plough.force_depth_ratio"]) * plough.depth_m
    hub_m = model.body("plough.depth_wheel").pos
    mass_m = model.body("plough.frame").ipos
    points = {
        "mass": (float(mass_m[0]), float(mass_m[2])),
        "resultant": (float(shares_m[0]), float(shares_m[2]) + above_sole_m),
        "hub": (float(hub_m[0]), float(hub_m[2])),
    }
    weight_n = GRAVITY_MPS2 * float(model.body_subtreemass[body_id(model, "plough.frame")])
    draft_n = expected_draft_n(numbers, plough.depth_m, draft_scale)
    return Mounted(plough, numbers, hitch, axle_height_m, weight_n, points, draft_n, deepest_m)


def by_geometry(here: Mounted) -> Setting:
    """Setting from the linkage's geometry and the expected forces, if the tyres sink no further."""
    plough = here.plough
    lowest_rad = FLOAT_RAD
    if plough.mix > 0.0:
        lowest_rad = _deeper_rad(here, here.deepest_m - plough.depth_m)
    if plough.wheel_up:  # it touches where the lift lowers no further
        sag_m = here.place(lowest_rad, "hub")[1] - here.place(here.work_rad, "hub")[1]
        return Setting(here.work_rad, lowest_rad, here.draft_n, sag_m)
    carried_n = plough.wheel_share * (here.weight_n + here.soil_down_n)
    if plough.hitch == "float":
        carried_n = _floating_n(here)
    sag_m = carried_n / here.numbers["plough.depth_wheel.stiffness_npm"]
    return Setting(here.work_rad, lowest_rad, here.draft_n, sag_m)


def set_plough(model: mujoco.MjModel, here: Mounted, setting: Setting) -> None:
    """Set the length of the top link and the height of the depth wheel in a compiled model."""
    numbers = here.numbers
    model.tendon_lengthspring[model.tendon("top_link").id] = here.top_length_m
    ground_m = here.plough.depth_m - numbers["plough.sole_below_hitch_m"]
    radius_m = numbers["plough.depth_wheel.radius_m"]
    model.body("plough.depth_wheel").pos[2] = ground_m + radius_m - setting.sag_m


def _floating_n(here: Mounted) -> float:
    """Load of the depth wheel where the lift carries nothing.

    The plough swings on its links, so the work of all forces in a small swing is zero:

        N dz_hub = W dz_mass + V dz_resultant + D dx_resultant

    with its weight W, the soil's downward force V, and the draft D backward.
    """
    low, high = here.work_rad - 0.5 * SWING_RAD, here.work_rad + 0.5 * SWING_RAD
    moved = {n: np.subtract(here.place(high, n), here.place(low, n)) for n in here.points}
    work_j = here.weight_n * moved["mass"][1] + here.soil_down_n * moved["resultant"][1]
    return float((work_j + here.draft_n * moved["resultant"][0]) / moved["hub"][1])


def _deeper_rad(here: Mounted, deeper_m: float) -> float:
    """Lower-link angle that puts the bodies so far below the working depth (bisection)."""
    wanted_m = here.place(here.work_rad, "resultant")[1] - deeper_m
    low, high = here.work_rad - 0.5, here.work_rad
    for _ in range(40):
        middle = 0.5 * (low + high)
        if here.place(middle, "resultant")[1] > wanted_m:
            high = middle
        else:
            low = middle
    return 0.5 * (low + high)


def expected_draft_n(numbers: dict[str, float], depth_m: float, draft_scale: float) -> float:
    """Draft of the whole implement that the operator expects at 5.5 km/h, by ASABE D497 [N]."""
    law = np.zeros(Block.SIZE)
    for f in (Block.DRAFT_A, Block.DRAFT_B, Block.DRAFT_C, Block.FACTOR_MEDIUM,
              Block.FACTOR_COARSE):  # fmt: skip
        law[f] = numbers[f"plough.{f.name.lower()}"]
    law[Block.DRAFT_WIDTH] = numbers["plough.bodies"] * numbers["plough.draft_width"]
    return float(draft_of(law, draft_scale, depth_m, 5.5 / 3.6))
