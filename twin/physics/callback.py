"""The laws as MuJoCo callbacks: they act in mj_step, rollouts, batches and the viewer alike.

`mjcb_passive` adds the ground's forces on wheels and plough, the engine and the brakes, and
reports in `userdata`; `mjcb_act_dyn` gives the rates of the tyres' deflections, which are MuJoCo
activations. A model without our parameter block is left alone.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache

import mujoco
from numba import types

from twin.compute.compiled import c_callback, law
from twin.errors import BadInput
from twin.physics import block, layout, memory, rigid
from twin.physics.block import (
    Coupling,
    Engine,
    Head,
    MachineSlot,
    PowerSlot,
    Soil,
    Wheel,
    WheelSlot,
)
from twin.physics.coupling import twist
from twin.physics.engine import (
    axle_torque_nm,
    engine_torque_nm,
    parasitic_torque_nm,
    radps_to_rpm,
)
from twin.physics.ploughing import pull_plough
from twin.physics.shapes import Array
from twin.physics.tyre import roll_wheel

_ = layout.offset
NV, NA, NBODY, NNUMERIC, NUSERDATA = (
    _("mjModel", n) for n in ("nv", "na", "nbody", "nnumeric", "nuserdata")
)
HFIELD_DATA, NHFIELDDATA = _("mjModel", "hfield_data"), _("mjModel", "nhfielddata")
TIMESTEP = _("mjModel", "opt.timestep")
NUMERIC_ADR, NUMERIC_SIZE, NUMERIC_DATA = (
    _("mjModel", n) for n in ("numeric_adr", "numeric_size", "numeric_data")
)
ACTUATOR_ACTADR, ACTUATOR_ACTNUM = (_("mjModel", n) for n in ("actuator_actadr", "actuator_actnum"))
ACT_DOT = _("mjData", "act_dot")
BODY_DOFADR, BODY_DOFNUM, BODY_PARENTID, BODY_ROOTID, DOF_PARENTID = (
    _("mjModel", n)
    for n in ("body_dofadr", "body_dofnum", "body_parentid", "body_rootid", "dof_parentid")
)
XPOS, XMAT, CVEL, SUBTREE_COM, CDOF, QVEL, ACT, CTRL, QFRC_PASSIVE, QFRC_DAMPER, USERDATA = (
    _("mjData", n)
    for n in (
        "xpos", "xmat", "cvel", "subtree_com", "cdof", "qvel",
        "act", "ctrl", "qfrc_passive", "qfrc_damper", "userdata",
    )
)  # fmt: skip
FIELD, SOIL, WHEEL = block.FIELD, block.SOIL, block.WHEEL
ENGINE, PLOUGH = block.ENGINE, block.PLOUGH
POWER_SLOTS, SCRATCH_SLOTS = block.POWER_SLOTS, block.SCRATCH_SLOTS
COUPLING, COUPLING_SIZE = block.COUPLING, int(Coupling.SIZE)
CLUTCH, LOCK, FRONT_DRIVE, BRAKE_RL, BRAKE_RR = range(5)
WHEEL_SIZE, WHEEL_SLOTS = int(Wheel.SIZE), int(WheelSlot.SIZE)
MACHINE_SLOTS, BLOCK_SIZE, SOIL_SIZE = block.MACHINE_SLOTS, block.SIZE, int(Soil.SIZE)
MAGIC, VERSION = block.MAGIC, block.VERSION


@law
def find_block(model: int) -> int:
    """Address of the parameter block in numeric_data, or -1 where the model has none.

    -1 also where the block has another version, or userdata has no room for the slots.
    """
    count = memory.size(model, NNUMERIC)
    if count == 0:
        return -1
    if memory.ints(model, NUMERIC_SIZE)[count - 1] != BLOCK_SIZE:
        return -1
    address = memory.ints(model, NUMERIC_ADR)[count - 1]
    head = memory.row(memory.doubles(model, NUMERIC_DATA), address + BLOCK_SIZE)[address:]
    if head[Head.MAGIC] != MAGIC or head[Head.VERSION] != VERSION:
        return -1
    if head[Head.RATES] < SCRATCH_SLOTS + SOIL_SIZE:
        return -1
    if memory.size(model, NUSERDATA) < head[Head.RATES] + memory.size(model, NA):
        return -1
    return address


@law
def last_dof(model: int, body: int) -> int:
    """Index of the last degree of freedom that moves a body, or -1 for a fixed body."""
    count, parent = memory.ints(model, BODY_DOFNUM), memory.ints(model, BODY_PARENTID)
    while count[body] == 0:
        if body == 0:
            return -1
        body = parent[body]
    return memory.ints(model, BODY_DOFADR)[body] + count[body] - 1


@law
def couple(
    parameters: Array,
    which: int,
    pedal: bool,
    rate_radps: float,
    act: Array,
    ctrl: Array,
    dt_s: float,
    rates: Array,
    slots: Array,
) -> float:
    """Torque of one friction element [N m]; writes its wind-up rate and adds its energy.

    Args:
        parameters: the parameter block.
        which: index of the element in `block.COUPLINGS`.
        pedal: its control releases it, as the clutch pedal does; else its control applies it.
        rate_radps: relative speed of its two sides.
        act, ctrl: mjData's activations and controls.
        dt_s: time step.
        rates: rates of the activations, written.
        slots: `MachineSlot` numbers; ELASTIC_J is added to.
    """
    at = COUPLING + which * COUPLING_SIZE
    element = parameters[at : at + COUPLING_SIZE]
    control = min(max(ctrl[int(element[Coupling.CONTROL])], 0.0), 1.0)
    windup = int(element[Coupling.WINDUP])
    applied = 1.0 - control if pedal else control
    torque, rates[windup] = twist(element, applied, act[windup], rate_radps, dt_s)
    held = applied * element[Coupling.CAPACITY_NM] * element[Coupling.WINDUP_RAD]
    slots[MachineSlot.ELASTIC_J] += 0.5 * held * act[windup] * act[windup]
    return torque


@law
def drive(
    parameters: Array,
    qvel: Array,
    act: Array,
    ctrl: Array,
    passive: Array,
    dt_s: float,
    slots: Array,
    rates: Array,
    powers: Array,
) -> None:
    """Torques of engine, clutch, differential, lock, front-axle drive and brakes on the wheels.

    The front axle is driven by the pinion of the rear differential, behind the clutch.

    Args:
        parameters: the parameter block.
        qvel, act, ctrl: joint velocities, activations and controls of mjData.
        passive: qfrc_passive; the torques are added.
        dt_s: time step.
        slots, rates, powers: written: `MachineSlot` numbers, rates of `act`, `PowerSlot` numbers.
    """
    engine = parameters[ENGINE:COUPLING]
    fl, fr, rl, rr = (
        int(parameters[WHEEL + Wheel.SPIN]),
        int(parameters[WHEEL + WHEEL_SIZE + Wheel.SPIN]),
        int(parameters[WHEEL + 2 * WHEEL_SIZE + Wheel.SPIN]),
        int(parameters[WHEEL + 3 * WHEEL_SIZE + Wheel.SPIN]),
    )
    shaft, ratio = int(engine[Engine.SHAFT]), engine[Engine.FRONT_RATIO]
    engine_radps = engine[Engine.GEAR_RATIO] * qvel[shaft]
    rpm = radps_to_rpm(engine_radps)
    throttle = min(max(ctrl[int(engine[Engine.THROTTLE])], 0.0), 1.0)
    torque = engine_torque_nm(engine, throttle, rpm)
    parasitic = parasitic_torque_nm(engine, rpm) * engine_radps
    output = axle_torque_nm(engine, torque, rpm)
    rear_rate = qvel[shaft] - 0.5 * (qvel[rl] + qvel[rr])
    front_rate = 0.5 * (ratio * (qvel[rl] + qvel[rr]) - (qvel[fl] + qvel[fr]))
    lock_rate = qvel[rl] - qvel[rr]
    rear = couple(parameters, CLUTCH, True, rear_rate, act, ctrl, dt_s, rates, slots)
    front = couple(parameters, FRONT_DRIVE, False, front_rate, act, ctrl, dt_s, rates, slots)
    lock = couple(parameters, LOCK, False, lock_rate, act, ctrl, dt_s, rates, slots)
    brake_l = couple(parameters, BRAKE_RL, False, qvel[rl], act, ctrl, dt_s, rates, slots)
    brake_r = couple(parameters, BRAKE_RR, False, qvel[rr], act, ctrl, dt_s, rates, slots)
    axle = rear - ratio * front
    passive[shaft] += output - rear
    passive[rl] += 0.5 * axle - lock - brake_l
    passive[rr] += 0.5 * axle + lock - brake_r
    passive[fl] += 0.5 * front
    passive[fr] += 0.5 * front
    slots[MachineSlot.ENGINE_RADPS], slots[MachineSlot.ENGINE_TORQUE_NM] = engine_radps, torque
    slots[MachineSlot.AXLE_TORQUE_NM] = axle
    slots[MachineSlot.BRAKE_TORQUE_NM] = brake_l + brake_r
    powers[PowerSlot.ENGINE] = torque * engine_radps
    powers[PowerSlot.PARASITIC] = parasitic
    powers[PowerSlot.TRANSMISSION] = torque * engine_radps - parasitic - output * qvel[shaft]
    powers[PowerSlot.DRIVELINE] = rear * rear_rate + front * front_rate + lock * lock_rate
    powers[PowerSlot.BRAKE] = brake_l * qvel[rl] + brake_r * qvel[rr]


@law
def ground_forces(model: int, data: int) -> None:
    """Add all forces of ground, engine and brakes to qfrc_passive, and write the slots.

    `model` and `data` are the addresses of an mjModel and its mjData.
    """
    address = find_block(model)
    if address < 0:
        return
    parameters = memory.row(memory.doubles(model, NUMERIC_DATA), address + BLOCK_SIZE)[address:]
    nv, nbody = memory.size(model, NV), memory.size(model, NBODY)
    xpos = memory.table(memory.doubles(data, XPOS), nbody, 3)
    xmat = memory.table(memory.doubles(data, XMAT), nbody, 9)
    cvel = memory.table(memory.doubles(data, CVEL), nbody, 6)
    com = memory.table(memory.doubles(data, SUBTREE_COM), nbody, 3)
    cdof, parent = memory.table(memory.doubles(data, CDOF), nv, 6), memory.ints(model, DOF_PARENTID)
    qvel, passive = memory.doubles(data, QVEL), memory.doubles(data, QFRC_PASSIVE)
    act, ctrl = memory.doubles(data, ACT), memory.doubles(data, CTRL)
    rate_slots = int(parameters[Head.RATES])
    slots = memory.row(memory.doubles(data, USERDATA), rate_slots + 64)
    rates, powers = slots[rate_slots:], slots[POWER_SLOTS:SCRATCH_SLOTS]
    here = slots[SCRATCH_SLOTS:rate_slots]
    for i in range(MACHINE_SLOTS, SCRATCH_SLOTS):
        slots[i] = 0.0
    dt_s = memory.double(model, TIMESTEP)
    nodes = memory.row(memory.floats(model, HFIELD_DATA), memory.size(model, NHFIELDDATA))
    for w in range(4):
        wheel = parameters[WHEEL + w * WHEEL_SIZE : WHEEL + (w + 1) * WHEEL_SIZE]
        body = int(wheel[Wheel.BODY])
        if body < 0:
            continue
        root = memory.ints(model, BODY_ROOTID)[body]
        force, torque = roll_wheel(
            parameters[FIELD:SOIL], parameters[SOIL:WHEEL], wheel, xpos, xmat, cvel, com, root,
            act, dt_s, slots[w * WHEEL_SLOTS : (w + 1) * WHEEL_SLOTS], rates, powers, here,
            nodes,
        )  # fmt: skip
        rigid.push(
            passive, cdof, parent, last_dof(model, body), com, root, rigid.row3(xpos, body),
            force, torque,
        )  # fmt: skip
    machine = slots[MACHINE_SLOTS:POWER_SLOTS]
    if parameters[ENGINE + Engine.SHAFT] >= 0.0:
        drive(parameters, qvel, act, ctrl, passive, dt_s, machine, rates, powers)
    frame = int(parameters[Head.PLOUGH_BODY])
    if frame >= 0:
        pull_plough(
            parameters, memory.ints(model, BODY_ROOTID)[frame], last_dof(model, frame), xpos, xmat,
            cvel, com, cdof, parent, passive, act, dt_s, rates, machine, powers, here, nodes,
        )  # fmt: skip
    damper = memory.doubles(data, QFRC_DAMPER)
    for j in range(nv):
        powers[PowerSlot.JOINT] -= damper[j] * qvel[j]


@law
def activation_rates(model: int, data: int, actuator: int) -> float:
    """Copy the activation rates of an actuator from userdata to act_dot, and return the first.

    `ground_forces` has written them to userdata. MuJoCo uses the return value where an actuator has
    one activation, act_dot where it has more. `model`, `data`: addresses of mjModel and mjData.
    """
    address = find_block(model)
    if address < 0:
        return 0.0
    first = memory.ints(model, ACTUATOR_ACTADR)[actuator]
    slot = int(memory.doubles(model, NUMERIC_DATA)[address + Head.RATES]) + first
    rates, out = memory.doubles(data, USERDATA), memory.doubles(data, ACT_DOT)
    for i in range(memory.ints(model, ACTUATOR_ACTNUM)[actuator]):
        out[first + i] = rates[slot + i]
    return rates[slot]


@cache
def _callbacks() -> tuple[Callable[..., None], Callable[..., float]]:
    """The compiled callbacks as C functions; kept, because MuJoCo holds only their addresses."""
    passive = c_callback(types.void(types.voidptr, types.voidptr))(_passive)
    act_dyn = c_callback(types.float64(types.voidptr, types.voidptr, types.int32))(_act_dyn)
    return (
        ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(passive.address),
        ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int)(
            act_dyn.address
        ),
    )


def _passive(model: int, data: int) -> None:
    ground_forces(model, data)


def _act_dyn(model: int, data: int, actuator: int) -> float:
    return activation_rates(model, data, actuator)


def install() -> None:
    """Install the laws as MuJoCo's callbacks, once per process.

    Raises:
        BadInput: another library has installed its own.
    """
    passive, act_dyn = _callbacks()
    for name, ours, getter, setter in (
        ("mjcb_passive", passive, mujoco.get_mjcb_passive, mujoco.set_mjcb_passive),
        ("mjcb_act_dyn", act_dyn, mujoco.get_mjcb_act_dyn, mujoco.set_mjcb_act_dyn),
    ):
        if getter() is not None and getter() is not ours:
            raise BadInput(f"{name} is already taken by other code in this process")
        setter(ours)
