"""The parameter block of the laws, from the model's <numeric> values and the scenario.

The module is longer than 300 lines because every part of the block has one function here, so that
the block can be checked against its layout in `twin.physics.block` in one place.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from enum import IntEnum

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput, OutOfRange
from twin.machine import memory
from twin.machine.tread import tread_part
from twin.physics import block
from twin.physics.block import Coupling, Engine, Envelope, Field, Head, Part, Plough, Soil, Wheel
from twin.physics.implement_laws import implement_law_number
from twin.physics.laws import law_number
from twin.scenario import Scenario
from twin.scenario import Soil as Ground
from twin.scenario.events import most_filled_kg
from twin.scenario.plough import FURROW_SIDES
from twin.scenario.soils import Deformable
from twin.terrain.grid import GridMap
from twin.terrain.place import first_envelope, grid_part

Array = NDArray[np.float64]

FURROW_AHEAD_M, FURROW_RAMP_M = 2.0, 3.0
"""Distance before the plough's lowering at which the last furrow begins; length to its depth."""
ENDLESS_M = 1e9
"""End of a furrow that is longer than the run."""
STEADY, LEAST_STEADY = 0.85, 0.2
"""Most that brake and clutch together may change the speed of a wheel in one step, over that speed,
and what is left for the brake in any case [-]: above 2 they overshoot more each time and hold
nothing, and the tyre's spring acts too. Where a brake is stiffer, its wind-up is longer."""
MAPS = {"heights": Field.HEIGHTS, "mixture": Field.MIXTURE}
"""Height fields of the model that the laws read -> index of their `Grid` in the block."""
CONTROLS = {"clutch": "clutch_pedal", "lock": "differential_lock", "front_drive": "front_drive"}


def parameter_block(
    scenario: Scenario,
    model: mujoco.MjModel,
    numbers: dict[str, float],
    rotation: Array,
    maps: Mapping[str, GridMap],
) -> Array:
    """The parameter block of `twin.physics.block`. Shape (block.SIZE,).

    Args:
        scenario: soil, field, course, gear and plough.
        model: the compiled model, for addresses and masses.
        numbers: <numeric> values of the machine and its implement by name.
        rotation: ground axes to world axes, (3, 3).
        maps: the ground's maps by the names of their height fields.
    """
    out = np.zeros(block.SIZE)
    head = {
        Head.MAGIC: block.MAGIC,
        Head.VERSION: block.VERSION,
        Head.RATES: block.RATE_SLOTS,
        Head.PLOUGH_BODY: body_id(model, "plough.frame"),
        Head.DEPTH_WHEEL_BODY: body_id(model, "plough.depth_wheel"),
    }
    parts: list[tuple[int, Part]] = [
        (0, head),
        (block.FIELD, field_part(scenario, numbers, rotation)),
        (block.SOIL, soils(scenario)[0]),
        (block.ENGINE, _engine(scenario, model, numbers)),
    ]
    for name, at in MAPS.items():
        if name in maps:
            parts.append((block.FIELD, grid_part(model, name, maps[name], at)))
    if "heights" in maps:
        parts.append((block.FIELD, {Field.ENVELOPES: first_envelope(model)}))
    for i, name in enumerate(block.COUPLINGS):
        part = _coupling(model, name, numbers, scenario)
        parts.append((block.COUPLING + i * Coupling.SIZE, part))
    for i, wheel in enumerate(block.WHEELS):
        part = _wheel(model, wheel, numbers, scenario.soil.resolved.front_grip)
        parts.append((block.WHEEL + i * Wheel.SIZE, part))
    if scenario.plough is not None:
        tool = scenario.implement_file
        law = "d497" if tool is None else tool.draft.law
        parts.append((block.PLOUGH, _plough(model, numbers, law)))
    for start, part in parts:
        for index, value in part.items():
            out[start + index] = value
    return out


def wheel_radii_m(numbers: dict[str, float]) -> tuple[float, ...]:
    """Radii of front, rear and depth wheels, in the order of `twin.physics.block.Envelope`."""
    radii = [0.5 * numbers[f"tyre_{axle}.diameter_m"] for axle in ("front", "rear")]
    return (*radii, numbers.get("plough.depth_wheel.radius_m", radii[0]))


def soil_part(soil: Ground) -> Part:
    """The block's numbers (`block.Soil`) of a soil, without those that the soil does not have."""
    preset = soil.resolved
    return {
        Soil.LAW: law_number(soil.law),
        Soil.FRICTION: preset.friction,
        **(
            {}
            if math.isnan(preset.cone_index_kpa)
            else {Soil.CONE_INDEX_KPA: preset.cone_index_kpa}
        ),
        Soil.SLIP_RATE: preset.slip_rate,
        Soil.ROLLING_MOMENT: preset.rolling_moment,
        Soil.MOBILITY_RESISTANCE: preset.mobility_resistance,
        Soil.DRAFT_SCALE: preset.draft_scale,
        Soil.DRAFT_CV: soil.draft_cv,
        Soil.DRAFT_LENGTH_M: soil.draft_length_m,
        Soil.RIPPLE_CV: soil.ripple_cv,
        Soil.STRENGTH_CV: preset.strength_cv,
        Soil.ROCKS_PER_M2: soil.rocks_per_100m2 / 100.0,
        Soil.ROCK_N: 1e3 * soil.rock_kn,
        **_deformable_part(soil.law, preset.deformable, soil.friction_scale),
    }


def soils(scenario: Scenario) -> tuple[Part, Part]:
    """The block's numbers of the main soil and of the other soil.

    A number that one of them does not have is taken from the other, so that mixing the soils where
    they meet does not change it.
    """
    own, other = soil_part(scenario.soil), soil_part(scenario.field.other_soil)
    for lacking, giving in ((own, dict(other)), (other, dict(own))):
        for name, value in giving.items():
            if name not in lacking:
                lacking[name] = value
    return own, other


def _deformable_part(law: str, soil: Deformable | None, friction_scale: float) -> Part:
    """What Bekker's law needs; under it, tan(phi) is the friction."""
    if soil is None:
        return {}
    cohesion_pa = 1e3 * soil.cohesion_kpa * friction_scale
    tan_phi = math.tan(math.radians(soil.friction_angle_deg)) * friction_scale
    return {
        **({Soil.FRICTION: tan_phi} if law == "bekker" else {}),
        Soil.K_C: 1e3 * soil.k_c_kn_per_m_n1,
        Soil.K_PHI: 1e3 * soil.k_phi_kn_per_m_n2,
        Soil.SINKAGE_EXPONENT: soil.sinkage_exponent,
        Soil.COHESION_PA: cohesion_pa,
        Soil.TAN_PHI: tan_phi,
        Soil.SHEAR_LONG_M: soil.shear_modulus_m,
        Soil.SHEAR_LAT_M: soil.shear_modulus_m * soil.lateral_shear_ratio,
        Soil.UNIT_WEIGHT_NPM3: 1e3 * soil.unit_weight_knpm3,
        Soil.PEAK: soil.stress_peak,
        Soil.PEAK_SLIP: soil.stress_peak_slip,
        Soil.SLIP_SINKAGE: soil.slip_sinkage,
    }


def field_part(scenario: Scenario, numbers: dict[str, float], rotation: Array) -> Part:
    """Ground plane, furrow, patches and the other soil, as numbers of the block."""
    out: Part = {Field.SEED: scenario.seed, Field.PASS_WAY: 1.0}
    out |= {Field.OTHER + name: value for name, value in soils(scenario)[1].items()}
    for i, axis in enumerate((Field.AHEAD, Field.LEFT, Field.NORMAL)):
        out |= {axis + k: rotation[k, i] for k in range(3)}
    if scenario.plough is not None:
        wall = (Field.FURROW_WIDTH_M, Field.WALL_STIFFNESS_NPM, Field.WALL_DAMPING_NSPM)
        out |= {
            Field.FURROW_SIDE: FURROW_SIDES[scenario.plough.furrow],
            Field.FURROW_DEPTH_M: scenario.plough.depth_m,
            Field.FURROW_EDGE_M: furrow_edge_m(numbers, scenario.plough.depth_m),
            Field.FURROW_START_M: scenario.course.approach_m - FURROW_AHEAD_M,
            Field.FURROW_RAMP_M: FURROW_RAMP_M,
            Field.FURROW_END_M: ENDLESS_M,
            **{f: numbers[f"furrow.{f.name.lower().removeprefix('furrow_')}"] for f in wall},
        }
    for i, patch in enumerate(scenario.field.patches):
        end_m = patch.start_m + patch.length_m
        values = (patch.start_m, end_m, patch.friction_factor, patch.cone_index_factor)
        out |= {Field.PATCHES + 4 * i + k: value for k, value in enumerate(values)}
    return out | {Field.PATCH_COUNT: len(scenario.field.patches)}


def furrow_edge_m(numbers: dict[str, float], depth_m: float) -> float:
    """Distance |t| of the furrow's wall from the line, where the rear tyre's flank just touches it.

    e cos(rho) - r sin(rho)     rho = asin(depth / track), the roll of the tractor in the furrow

    e is |y| of the inner flank of the upright tyre, r the tyre's radius.
    """
    upright_m, sine = (
        numbers["furrow.edge_m"],
        depth_m / (2.0 * numbers["furrow.edge_m"] + numbers["tyre_rear.width_m"]),
    )
    cosine = math.sqrt(1.0 - sine * sine)
    return upright_m * cosine - 0.5 * numbers["tyre_rear.diameter_m"] * sine


def body_id(model: mujoco.MjModel, name: str) -> int:
    """A body's number, -1 where there is none."""
    return int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name))


def _number(numbers: dict[str, float], name: str) -> float:
    if name not in numbers:
        raise BadInput(f"the model has no <numeric name='{name}'>")
    return numbers[name]


def _named(numbers: dict[str, float], prefix: str, fields: tuple[IntEnum, ...]) -> Part:
    """Fields of a block part from the numerics `prefix.<field in lower case>`."""
    return {f: _number(numbers, f"{prefix}.{f.name.lower()}") for f in fields}


def _wheel(model: mujoco.MjModel, wheel: str, numbers: dict[str, float], front_grip: float) -> Part:
    axle = "front" if wheel[0] == "f" else "rear"
    sizes = tuple(f for f in Wheel if Wheel.WIDTH_M <= f <= Wheel.NOMINAL_LOAD_N)
    named = _named(numbers, f"tyre_{axle}", sizes)
    if axle == "front":
        named[Wheel.LATERAL_RATIO] *= front_grip
    return {
        Wheel.BODY: model.body(f"{wheel}_wheel").id,
        Wheel.SPIN: int(model.joint(f"{wheel}_spin").dofadr[0]),
        Wheel.INERTIA_KGM2: float(model.body(f"{wheel}_wheel").inertia.max()),
        Wheel.ENVELOPE: Envelope.FRONT if axle == "front" else Envelope.REAR,
        Wheel.TYRE: memory.address(model, f"{wheel}_tyre_x"),
        **named,
        **tread_part(named),
        **{f: numbers.get(f"tyre_{axle}.{f.name.lower()}", 0.0) for f in block.BUILD},
    }


def _engine(scenario: Scenario, model: mujoco.MjModel, numbers: dict[str, float]) -> Part:
    own = tuple(f for f in Engine if f < Engine.GEAR_RATIO)
    points: Part = {Engine.POINT_COUNT: numbers.get("engine.point_count", 0.0)}
    for i in range(int(points[Engine.POINT_COUNT])):
        at = Engine.POINTS + 2 * i
        points |= {at: numbers[f"engine.point_{i}_rpm"], at + 1: numbers[f"engine.point_{i}_nm"]}
    return {
        **points,
        **_named(numbers, "engine", own),
        **({} if scenario.drive.exhaust_brake else {Engine.EXHAUST_BRAKE_PA: 0.0}),
        Engine.GEAR_RATIO: scenario.gear.ratio,
        Engine.FRONT_RATIO: _number(numbers, "front_drive.ratio"),
        Engine.SHAFT: int(model.joint("drive").dofadr[0]),
        Engine.THROTTLE: model.actuator("throttle").id,
    }


def _coupling(
    model: mujoco.MjModel, name: str, numbers: dict[str, float], scenario: Scenario
) -> Part:
    gear_ratio = scenario.gear.ratio
    kind = name.removesuffix("_rl").removesuffix("_rr")
    sizes = (Coupling.CAPACITY_NM, Coupling.WINDUP_RAD, Coupling.DAMPING_S)
    own = _named(numbers, kind, sizes)
    if kind == "brake":
        clutch = _named(numbers, "clutch", sizes)
        left = STEADY - abs(gear_ratio) * _stiffness(model, clutch)
        left -= _laden(model, numbers, most_filled_kg(scenario.events))
        own[Coupling.WINDUP_RAD] *= max(1.0, _stiffness(model, own) / max(left, LEAST_STEADY))
    if kind == "clutch":  # it sits at the engine, the wind-up is the axle's
        own[Coupling.CAPACITY_NM] *= abs(gear_ratio)
    return {
        Coupling.CONTROL: model.actuator(CONTROLS.get(kind, "brake")).id,
        Coupling.WINDUP: memory.address(model, f"{name}_windup"),
        **own,
    }


def _stiffness(model: mujoco.MjModel, element: Part) -> float:
    """How much a friction element changes the speed of a rear wheel in one step, over that speed.

    C (dt + tau) dt / (u_max I)
    """
    dt_s, inertia = float(model.opt.timestep), float(model.body("rl_wheel").inertia.max())
    held = element[Coupling.CAPACITY_NM] * (dt_s + element[Coupling.DAMPING_S]) * dt_s
    return held / (element[Coupling.WINDUP_RAD] * inertia)


def _laden(model: mujoco.MjModel, numbers: dict[str, float], filled_kg: float) -> float:
    """How much more a tyre changes its wheel's speed in one step under a load that is filled in.

    6.6 W' r^2 (dt + tau) dt / (l I) ;  6.6 = 0.88 * 7.5, the steepest thrust over load against
    slip (Brixius 1987), W' the nominal load times the share of the mass that is filled in, l the
    relaxation length and tau the damping of the tread's shear.
    """
    tyre = {f: _number(numbers, f"tyre_rear.{f}") for f in (
        "nominal_load_n", "nominal_rolling_radius_m", "relaxation_long_m", "shear_damping_s",
    )}  # fmt: skip
    more_n = tyre["nominal_load_n"] * filled_kg / float(model.body_mass.sum())
    return _stiffness(model, {
        Coupling.CAPACITY_NM: 6.6 * more_n * tyre["nominal_rolling_radius_m"] ** 2,
        Coupling.WINDUP_RAD: tyre["relaxation_long_m"],
        Coupling.DAMPING_S: tyre["shear_damping_s"],
    })  # fmt: skip


def _plough(model: mujoco.MjModel, numbers: dict[str, float], law: str) -> Part:
    """The implement's numbers; its shares are where `twin.machine.turnover` has set them."""
    laws = tuple(f for f in Plough if f < Plough.WHEEL_RADIUS_M)
    wheel = tuple(f for f in Plough if Plough.WHEEL_RADIUS_M <= f < Plough.SOIL_STIFFNESS_NPM)
    out = _named(numbers, "plough", (*laws, Plough.SOIL_STIFFNESS_NPM))
    bodies = _bodies(model, out[Plough.BODIES])
    out[Plough.LAW] = implement_law_number(law)
    out[Plough.SOIL] = memory.address(model, "soil_1_x")
    for f in wheel:
        out[f] = _number(numbers, "plough." + f.name.lower().replace("wheel_", "depth_wheel."))
    for i in range(bodies):
        place = model.site(f"plough.share_{i + 1}").pos
        out |= {Plough.SHARES + 3 * i + k: v for k, v in enumerate(place)}
    return out


def _bodies(model: mujoco.MjModel, bodies: float) -> int:
    """How many bodies a plough has; refused where the block or the model has no place for them."""
    if bodies != int(bodies) or not 1 <= bodies <= block.MOST_SHARES:
        raise OutOfRange(
            "plough.bodies", f"{bodies:g}", f"the whole numbers 1 to {block.MOST_SHARES}"
        )
    sites = sum(model.site(i).name.startswith("plough.share_") for i in range(model.nsite))
    if sites != bodies:
        raise BadInput(
            f"plough.bodies = {bodies:g}, but the model has {sites} sites plough.share_1, "
            "plough.share_2, ...: one for each body would do"
        )
    return int(bodies)
