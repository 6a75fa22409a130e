"""Compile a scenario's machine: MJCF, ground, parameter block, working linkage, start state."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.machine.files import model_path
from twin.machine.ground_frame import quaternion, world_from_ground
from twin.machine.hitch import Hitch
from twin.physics import block
from twin.physics.block import Coupling, Engine, Field, Head, Plough, Soil, Wheel
from twin.physics.callback import install
from twin.scenario import FURROW_SIDES, ROUGHNESS, Scenario
from twin.scenario import Soil as Ground
from twin.soils import LAWS

Array = NDArray[np.float64]

GRAVITY_MPS2 = 9.81
RAISED_RAD = 0.6
"""Lower-link angle with the plough carried."""
FURROW_AHEAD_M, FURROW_RAMP_M = 2.0, 3.0
"""The last furrow begins so far before the plough is lowered, and takes so long to its depth."""
SETTLE_S = 4.0
"""Time in which the machine settles on its tyres before a run."""


@dataclass(frozen=True)
class Machine:
    """A compiled machine on its ground, ready to run."""

    scenario: Scenario
    model: Any
    """mujoco.MjModel with the parameter block."""
    numbers: dict[str, float]
    """The models' own <numeric> values by name."""
    world_from_ground: Array
    """Rotation from the ground plane's frame to the world. Shape (3, 3)."""
    hitch: Hitch
    work_rad: float
    """Lower-link angle at the working depth."""
    start_qpos: Array
    start_speed_mps: float

    @property
    def throttle(self) -> float:
        """Governor setting of the scenario, 0 at idle, 1 at full."""
        idle, top = self.numbers["engine.idle_rpm"], self.numbers["engine.no_load_rpm"]
        return (self.scenario.drive.engine_set_rpm - idle) / (top - idle)


def build(scenario: Scenario, *, looks: bool = False) -> Machine:
    """Compile the machine of a scenario and install the laws.

    Wheel contact is switched off, because the callback takes over; everything else stays native.
    What is only looked at is left out, as it would nearly double the time of a step.

    Args:
        scenario: what is built.
        looks: keep what is only looked at.
    """
    install()
    spec = mujoco.MjSpec.from_file(str(model_path(scenario.machine)))
    numbers = {n.name: float(n.data[0]) for n in spec.numerics}
    if scenario.plough is None:
        _leave_plough(spec)
    for geom in (*(f"{w}_tyre" for w in block.WHEELS), "plough.depth_wheel_rim"):
        if (rim := spec.geom(geom)) is not None:
            rim.contype = rim.conaffinity = 0
    rotation = world_from_ground(scenario.field, scenario.course)
    _add_ground(spec, rotation)
    _add_activations(spec)
    if scenario.plough is not None:
        spec.body("plough.frame").quat = _levelled(furrow_roll_rad(scenario, spec))
    spec.option.timestep = scenario.timestep_s
    spec.add_sensor(name="potential_j", type=mujoco.mjtSensor.mjSENS_E_POTENTIAL)
    spec.add_sensor(name="kinetic_j", type=mujoco.mjtSensor.mjSENS_E_KINETIC)
    spec.nuserdata = block.RATE_SLOTS + 16
    spec.add_numeric(name="tractor_twin", size=block.SIZE, data=[0.0] * block.SIZE)
    spec.compiler.discardvisual = not looks
    model = spec.compile()
    hitch = _hitch(spec)
    reflected = numbers["engine.inertia_kgm2"] * scenario.drive.gear_ratio**2
    model.dof_armature[model.joint("drive").dofadr[0]] = reflected
    model.numeric_data[-block.SIZE :] = _block(scenario, model, numbers, rotation)
    axle_height_m = model.body("tractor").pos[2]
    work_rad = 0.0
    if scenario.plough is not None:
        if scenario.plough.furrow != "none":  # one side lower by the depth, the middle by half
            axle_height_m -= 0.5 * scenario.plough.depth_m
        work_rad = _set_plough(
            model,
            scenario.plough,
            scenario.soil.resolved().draft_scale,
            numbers,
            hitch,
            axle_height_m,
        )
    speed = _unloaded_speed_mps(scenario, numbers)
    qpos = _settled(model, _start(model, scenario, rotation, hitch, work_rad))
    return Machine(scenario, model, numbers, rotation, hitch, work_rad, qpos, speed)


def furrow_roll_rad(scenario: Scenario, spec: Any) -> float:
    """Roll of the tractor in the furrow, atan(depth / track); positive lowers the right side."""
    if scenario.plough is None:
        return 0.0
    track_m = 2.0 * float(spec.body("rl_wheel").pos[1])
    side = FURROW_SIDES[scenario.plough.furrow]
    return -side * math.atan(scenario.plough.depth_m / track_m)


def _levelled(roll_rad: float) -> list[float]:
    """Rotation of the plough on its links that keeps it upright while the tractor rolls; wxyz."""
    return [math.cos(0.5 * roll_rad), -math.sin(0.5 * roll_rad), 0.0, 0.0]


def _leave_plough(spec: Any) -> None:
    spec.delete(spec.tendon("top_link"))  # first: it goes with the body it is tied to
    spec.delete(spec.body("plough.frame"))


def _add_ground(spec: Any, rotation: Array) -> None:
    spec.worldbody.add_geom(
        name="ground",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[0, 0, 1],
        quat=quaternion(rotation),
        contype=1,
        conaffinity=2,
        rgba=[0.48, 0.40, 0.27, 1.0],
    )


def _add_activations(spec: Any) -> None:
    """Tyre deflections and wind-ups: MuJoCo activations whose rates our callback gives."""
    tyres = [f"{w}_tyre_{axis}" for w in block.WHEELS for axis in "xy"]
    for name in (*tyres, *(f"{c}_windup" for c in block.COUPLINGS)):
        actuator = spec.add_actuator(
            name=name,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            target="drive",
            dyntype=mujoco.mjtDyn.mjDYN_USER,
        )
        actuator.gainprm[0] = 0.0


def _hitch(spec: Any) -> Hitch:
    links, frame = spec.body("lower_links"), spec.frame("hitch")
    top, mast = spec.site("top_link_front"), spec.site("plough.top_link_rear")
    return Hitch(
        lower_front=(float(links.pos[0]), float(links.pos[2])),
        lower_length_m=-float(frame.pos[0]),
        top_front=(float(top.pos[0]), float(top.pos[2])),
        mast=(0.0, 0.0) if mast is None else (float(mast.pos[0]), float(mast.pos[2])),
    )


def _block(scenario: Scenario, model: Any, numbers: dict[str, float], rotation: Array) -> Array:
    """The parameter block of twin.physics.block."""
    out = np.zeros(block.SIZE)
    head = {
        Head.MAGIC: block.MAGIC,
        Head.VERSION: block.VERSION,
        Head.RATES: block.RATE_SLOTS,
        Head.PLOUGH_BODY: _body(model, "plough.frame"),
        Head.DEPTH_WHEEL_BODY: _body(model, "plough.depth_wheel"),
    }
    parts: list[tuple[int, dict[Any, float]]] = [
        (0, head),
        (block.FIELD, field_part(scenario, numbers, rotation)),
        (block.SOIL, soil_part(scenario.soil)),
        (block.ENGINE, _engine(scenario, model, numbers)),
    ]
    for i, name in enumerate(block.COUPLINGS):
        part = _coupling(model, name, numbers, scenario.drive.gear_ratio)
        parts.append((block.COUPLING + i * Coupling.SIZE, part))
    for i, wheel in enumerate(block.WHEELS):
        parts.append((block.WHEEL + i * Wheel.SIZE, _wheel(model, wheel, numbers)))
    if scenario.plough is not None:
        side = FURROW_SIDES[scenario.plough.furrow]
        parts.append((block.PLOUGH, _plough(model, numbers, side)))
    for start, part in parts:
        for index, value in part.items():
            out[start + index] = value
    return out


def soil_part(soil: Ground) -> dict[Any, float]:
    """The block's numbers of a soil."""
    preset = soil.resolved()
    return {
        Soil.LAW: LAWS.index(soil.law),
        Soil.FRICTION: preset.friction,
        Soil.CONE_INDEX_KPA: preset.cone_index_kpa,
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
    }


def field_part(scenario: Scenario, numbers: dict[str, float], rotation: Array) -> dict[Any, float]:
    """Ground plane, furrow and patches, as numbers of the block."""
    roughness_m = 0.1 * math.sqrt(ROUGHNESS[scenario.field.roughness_class])
    out: dict[Any, float] = {Field.SEED: scenario.seed, Field.ROUGHNESS_M: roughness_m}
    for i, axis in enumerate((Field.AHEAD, Field.LEFT, Field.NORMAL)):
        out |= {axis + k: rotation[k, i] for k in range(3)}
    if scenario.plough is not None:
        wall = (Field.FURROW_WIDTH_M, Field.WALL_STIFFNESS_NPM, Field.WALL_DAMPING_NSPM)
        out |= {
            Field.FURROW_SIDE: FURROW_SIDES[scenario.plough.furrow],
            Field.FURROW_DEPTH_M: scenario.plough.depth_m,
            Field.FURROW_EDGE_M: numbers["furrow.edge_m"],
            Field.FURROW_START_M: scenario.course.approach_m - FURROW_AHEAD_M,
            Field.FURROW_RAMP_M: FURROW_RAMP_M,
            **{f: numbers[f"furrow.{f.name.lower().removeprefix('furrow_')}"] for f in wall},
        }
    for i, patch in enumerate(scenario.field.patches):
        end_m = patch.start_m + patch.length_m
        values = (patch.start_m, end_m, patch.friction_factor, patch.cone_index_factor)
        out |= {Field.PATCHES + 4 * i + k: value for k, value in enumerate(values)}
    return out | {Field.PATCH_COUNT: len(scenario.field.patches)}


def _body(model: Any, name: str) -> int:
    return int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name))


def _number(numbers: dict[str, float], name: str) -> float:
    if name not in numbers:
        raise BadInput(f"the model has no <numeric name='{name}'>")
    return numbers[name]


def _named(numbers: dict[str, float], prefix: str, fields: tuple[Any, ...]) -> dict[Any, float]:
    """Fields of a block part from the numerics `prefix.<field in lower case>`."""
    return {f: _number(numbers, f"{prefix}.{f.name.lower()}") for f in fields}


def _wheel(model: Any, wheel: str, numbers: dict[str, float]) -> dict[Any, float]:
    axle = "front" if wheel[0] == "f" else "rear"
    sizes = tuple(f for f in Wheel if Wheel.WIDTH_M <= f < Wheel.SIZE)
    return {
        Wheel.BODY: model.body(f"{wheel}_wheel").id,
        Wheel.SPIN: int(model.joint(f"{wheel}_spin").dofadr[0]),
        Wheel.TYRE: _activation(model, f"{wheel}_tyre_x"),
        **_named(numbers, f"tyre_{axle}", sizes),
    }


def _activation(model: Any, actuator: str) -> int:
    """Address of an actuator's activation."""
    return int(model.actuator_actadr[model.actuator(actuator).id])


def _engine(scenario: Scenario, model: Any, numbers: dict[str, float]) -> dict[Any, float]:
    own = tuple(f for f in Engine if f < Engine.GEAR_RATIO)
    return {
        **_named(numbers, "engine", own),
        Engine.GEAR_RATIO: scenario.drive.gear_ratio,
        Engine.FRONT_RATIO: _number(numbers, "front_drive.ratio"),
        Engine.SHAFT: int(model.joint("drive").dofadr[0]),
        Engine.THROTTLE: model.actuator("throttle").id,
    }


CONTROLS = {"clutch": "clutch_pedal", "lock": "differential_lock", "front_drive": "front_drive"}


def _coupling(
    model: Any, name: str, numbers: dict[str, float], gear_ratio: float
) -> dict[Any, float]:
    kind = name.removesuffix("_rl").removesuffix("_rr")
    sizes = (Coupling.CAPACITY_NM, Coupling.WINDUP_RAD, Coupling.DAMPING_S)
    own = _named(numbers, kind, sizes)
    if kind == "clutch":  # it sits at the engine, the wind-up is the axle's
        own[Coupling.CAPACITY_NM] *= gear_ratio
    return {
        Coupling.CONTROL: model.actuator(CONTROLS.get(kind, "brake")).id,
        Coupling.WINDUP: _activation(model, f"{name}_windup"),
        **own,
    }


def _plough(model: Any, numbers: dict[str, float], side: int) -> dict[Any, float]:
    laws = tuple(f for f in Plough if f < Plough.WHEEL_RADIUS_M)
    wheel = tuple(f for f in Plough if Plough.WHEEL_RADIUS_M <= f < Plough.SHARES)
    out = _named(numbers, "plough", laws)
    for f in wheel:
        out[f] = _number(numbers, "plough." + f.name.lower().replace("wheel_", "depth_wheel."))
    mirror = -1.0 if side < 0 else 1.0  # drawn for a furrow on the left
    for i in range(int(out[Plough.BODIES])):
        x, y, z = model.site(f"plough.share_{i + 1}").pos
        out |= {Plough.SHARES + 3 * i + k: v for k, v in enumerate((x, mirror * y, z))}
    return out


def _set_plough(
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
    weight_n = GRAVITY_MPS2 * model.body_subtreemass[_body(model, "plough.frame")]
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


def _unloaded_speed_mps(scenario: Scenario, numbers: dict[str, float]) -> float:
    """Speed at which the governed engine just carries its own losses."""
    drive = scenario.drive
    droop = (
        numbers["engine.droop_rpm_per_nm"] * numbers["engine.no_load_rpm"] / drive.engine_set_rpm
    )
    rpm = drive.engine_set_rpm - 2.5 * droop * numbers["engine.parasitic_nm"]
    radius_m = numbers["tyre_rear.free_rolling_radius_m"]
    return rpm * math.pi / 30.0 / drive.gear_ratio * radius_m


def _settled(model: Any, qpos: Array) -> Array:
    """Where the machine comes to rest with the brakes on and the plough carried. Shape (nq,)."""
    state = mujoco.MjData(model)
    state.qpos[:] = qpos
    for control, value in (("brake", 1.0), ("clutch_pedal", 1.0), ("lift", RAISED_RAD)):
        state.ctrl[model.actuator(control).id] = value
    mujoco.mj_step(model, state, round(SETTLE_S / model.opt.timestep))
    return np.array(state.qpos)


def _start(model: Any, scenario: Scenario, rotation: Array, hitch: Hitch, work_rad: float) -> Array:
    """Standing on the ground at the start of the course, the plough carried. Shape (nq,)."""
    qpos = model.qpos0.copy()
    qpos[:3] = rotation @ np.array([0.0, 0.0, model.body("tractor").pos[2]])
    qpos[3:7] = quaternion(rotation)
    qpos[model.joint("lift").qposadr[0]] = RAISED_RAD
    if scenario.plough is not None:
        top_m = hitch.top_length_m(work_rad, -work_rad)
        pitch = hitch.pitch_rad_at(RAISED_RAD, top_m)
        qpos[model.joint("plough.pitch").qposadr[0]] = pitch
    return np.asarray(qpos, dtype=np.float64)
