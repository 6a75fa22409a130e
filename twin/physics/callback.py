"""The laws as MuJoCo callbacks: they act in mj_step, rollouts, batches and the viewer alike.

`mjcb_passive` adds the ground's forces on wheels and plough, the engine and the brakes, and
reports in `userdata`; `mjcb_act_dyn` hands on the rates of the tyres' deflections, which are MuJoCo
activations. A model without our parameter block is left alone.
"""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any

import mujoco
from numba import carray, types

from twin.errors import BadInput
from twin.physics import block, layout, memory, rigid
from twin.physics.block import Coupling, Engine, Head, MachineSlot, Plough, Wheel, WheelSlot
from twin.physics.compiled import c_callback, law
from twin.physics.coupling import twist
from twin.physics.engine import axle_torque_nm, engine_torque_nm, radps_to_rpm
from twin.physics.plough import depth_wheel_force, share_force
from twin.physics.shapes import Array
from twin.physics.tyre import roll_wheel

_ = layout.offset
NV, NBODY, NNUMERIC = (_("mjModel", n) for n in ("nv", "nbody", "nnumeric"))
TIMESTEP = _("mjModel", "opt.timestep")
NUMERIC_ADR, NUMERIC_SIZE, NUMERIC_DATA = (
    _("mjModel", n) for n in ("numeric_adr", "numeric_size", "numeric_data")
)
ACTUATOR_ACTADR = _("mjModel", "actuator_actadr")
BODY_DOFADR, BODY_DOFNUM, BODY_PARENTID, BODY_ROOTID, DOF_PARENTID = (
    _("mjModel", n)
    for n in ("body_dofadr", "body_dofnum", "body_parentid", "body_rootid", "dof_parentid")
)
XPOS, XMAT, CVEL, SUBTREE_COM, CDOF, QVEL, ACT, CTRL, QFRC_PASSIVE, USERDATA = (
    _("mjData", n)
    for n in (
        "xpos", "xmat", "cvel", "subtree_com", "cdof", "qvel",
        "act", "ctrl", "qfrc_passive", "userdata",
    )
)  # fmt: skip
SOIL, WHEEL, ENGINE, PLOUGH = block.SOIL, block.WHEEL, block.ENGINE, block.PLOUGH
COUPLING, COUPLING_SIZE = block.COUPLING, int(Coupling.SIZE)
CLUTCH, LOCK, FRONT_DRIVE, BRAKE_RL, BRAKE_RR = range(5)
WHEEL_SIZE, WHEEL_SLOTS = int(Wheel.SIZE), int(WheelSlot.SIZE)
MACHINE_SLOTS, MAGIC, BLOCK_SIZE = block.MACHINE_SLOTS, block.MAGIC, block.SIZE


@law
def find_block(model: Any) -> int:
    """Address of the parameter block in numeric_data, or -1 for a model that is not ours."""
    count = memory.size(model, NNUMERIC)
    if count == 0:
        return -1
    if memory.ints(model, NUMERIC_SIZE)[count - 1] != BLOCK_SIZE:
        return -1
    address = memory.ints(model, NUMERIC_ADR)[count - 1]
    if memory.doubles(model, NUMERIC_DATA)[address] != MAGIC:
        return -1
    return address


@law
def last_dof(model: Any, body: int) -> int:
    """The last degree of freedom that moves a body."""
    count, parent = memory.ints(model, BODY_DOFNUM), memory.ints(model, BODY_PARENTID)
    while count[body] == 0:
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
) -> float:
    """Torque of one friction element; a pedal releases it, a lever applies it."""
    at = COUPLING + which * COUPLING_SIZE
    element = parameters[at : at + COUPLING_SIZE]
    control = min(max(ctrl[int(element[Coupling.CONTROL])], 0.0), 1.0)
    windup = int(element[Coupling.WINDUP])
    applied = 1.0 - control if pedal else control
    torque, rates[windup] = twist(element, applied, act[windup], rate_radps, dt_s)
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
) -> None:
    """Engine, clutch, differential with its lock, front-axle drive, and brakes."""
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
    rear_rate = qvel[shaft] - 0.5 * (qvel[rl] + qvel[rr])
    front_rate = ratio * qvel[shaft] - 0.5 * (qvel[fl] + qvel[fr])
    rear = couple(parameters, CLUTCH, True, rear_rate, act, ctrl, dt_s, rates)
    front = couple(parameters, FRONT_DRIVE, False, front_rate, act, ctrl, dt_s, rates)
    lock = couple(parameters, LOCK, False, qvel[rl] - qvel[rr], act, ctrl, dt_s, rates)
    brake_l = couple(parameters, BRAKE_RL, False, qvel[rl], act, ctrl, dt_s, rates)
    brake_r = couple(parameters, BRAKE_RR, False, qvel[rr], act, ctrl, dt_s, rates)
    passive[shaft] += axle_torque_nm(engine, torque, rpm) - rear - ratio * front
    passive[rl] += 0.5 * rear - lock - brake_l
    passive[rr] += 0.5 * rear + lock - brake_r
    passive[fl] += 0.5 * front
    passive[fr] += 0.5 * front
    slots[MachineSlot.ENGINE_RADPS], slots[MachineSlot.ENGINE_TORQUE_NM] = engine_radps, torque
    slots[MachineSlot.AXLE_TORQUE_NM] = rear
    slots[MachineSlot.BRAKE_TORQUE_NM] = brake_l + brake_r


@law
def pull_plough(
    model: Any,
    parameters: Array,
    xpos: Array,
    xmat: Array,
    cvel: Array,
    com: Array,
    cdof: Array,
    parent: Any,
    passive: Array,
    slots: Array,
) -> None:
    """Soil forces on the plough's bodies and its depth wheel."""
    head, soil, plough = parameters, parameters[SOIL:WHEEL], parameters[PLOUGH:]
    frame, wheel = int(head[Head.PLOUGH_BODY]), int(head[Head.DEPTH_WHEEL_BODY])
    root, dof = memory.ints(model, BODY_ROOTID)[frame], last_dof(model, frame)
    normal = (head[Head.NORMAL_X], head[Head.NORMAL_Y], head[Head.NORMAL_Z])
    none, total, depth_sum = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0
    left = rigid.axis(xmat, frame, 1)
    left = rigid.unit(rigid.minus(left, rigid.scaled(rigid.dot(left, normal), normal)))
    for i in range(int(plough[Plough.BODIES])):
        at = Plough.SHARES + 3 * i
        tip = rigid.to_world(xpos, xmat, frame, (plough[at], plough[at + 1], plough[at + 2]))
        velocity = rigid.point_velocity(cvel, com, frame, root, tip)
        force, depth = share_force(head, soil, plough, tip, velocity, normal, left)
        above_tip = depth * (1.0 - plough[Plough.FORCE_DEPTH_RATIO])
        point = rigid.plus(tip, rigid.scaled(above_tip, normal))
        rigid.push(passive, cdof, parent, dof, com, root, point, force, none)
        total, depth_sum = rigid.plus(total, force), depth_sum + depth
    hub = rigid.row3(xpos, wheel)
    velocity = rigid.point_velocity(cvel, com, wheel, root, hub)
    force, load = depth_wheel_force(plough, hub, velocity, normal)
    rigid.push(passive, cdof, parent, dof, com, root, hub, force, none)
    total = rigid.plus(total, force)
    slots[MachineSlot.DRAFT_X_N], slots[MachineSlot.DRAFT_Y_N], slots[MachineSlot.DRAFT_Z_N] = total
    slots[MachineSlot.DRAFT_N] = -rigid.dot(total, rigid.cross(left, normal))
    slots[MachineSlot.DEPTH_M] = depth_sum / plough[Plough.BODIES]
    slots[MachineSlot.DEPTH_WHEEL_N] = load


@law
def ground_forces(model: Any, data: Any) -> None:
    """All forces of ground, engine and brakes, added to qfrc_passive."""
    address = find_block(model)
    if address < 0:
        return
    parameters = carray(memory.doubles(model, NUMERIC_DATA), address + BLOCK_SIZE)[address:]
    nv, nbody = memory.size(model, NV), memory.size(model, NBODY)
    xpos, xmat = (
        carray(memory.doubles(data, XPOS), (nbody, 3)),
        carray(memory.doubles(data, XMAT), (nbody, 9)),
    )
    cvel = carray(memory.doubles(data, CVEL), (nbody, 6))
    com = carray(memory.doubles(data, SUBTREE_COM), (nbody, 3))
    cdof, parent = carray(memory.doubles(data, CDOF), (nv, 6)), memory.ints(model, DOF_PARENTID)
    qvel, passive = memory.doubles(data, QVEL), memory.doubles(data, QFRC_PASSIVE)
    act, ctrl = memory.doubles(data, ACT), memory.doubles(data, CTRL)
    rate_slots = int(parameters[Head.RATES])
    slots = carray(memory.doubles(data, USERDATA), rate_slots + 64)
    rates = slots[rate_slots:]
    dt_s = memory.double(model, TIMESTEP)
    for w in range(4):
        wheel = parameters[WHEEL + w * WHEEL_SIZE : WHEEL + (w + 1) * WHEEL_SIZE]
        body = int(wheel[Wheel.BODY])
        root = memory.ints(model, BODY_ROOTID)[body]
        force, torque = roll_wheel(
            parameters, parameters[SOIL:WHEEL], wheel, xpos, xmat, cvel, com, root, act, dt_s,
            slots[w * WHEEL_SLOTS : (w + 1) * WHEEL_SLOTS], rates,
        )  # fmt: skip
        rigid.push(
            passive,
            cdof,
            parent,
            last_dof(model, body),
            com,
            root,
            rigid.row3(xpos, body),
            force,
            torque,
        )
    machine = slots[MACHINE_SLOTS:rate_slots]
    machine[:] = 0.0
    drive(parameters, qvel, act, ctrl, passive, dt_s, machine, rates)
    if parameters[Head.PLOUGH_BODY] >= 0.0:
        pull_plough(model, parameters, xpos, xmat, cvel, com, cdof, parent, passive, machine)


@law
def activation_rate(model: Any, data: Any, actuator: int) -> float:
    """Rate of one of our activations, as the passive callback left it; 0 for a foreign model."""
    address = find_block(model)
    if address < 0:
        return 0.0
    rate_slots = int(memory.doubles(model, NUMERIC_DATA)[address + Head.RATES])
    return memory.doubles(data, USERDATA)[
        rate_slots + memory.ints(model, ACTUATOR_ACTADR)[actuator]
    ]


@cache
def _callbacks() -> tuple[Any, Any]:
    """The compiled callbacks as C functions; kept, because MuJoCo holds only their addresses."""
    passive = c_callback(types.void(types.voidptr, types.voidptr))(_passive)
    act_dyn = c_callback(types.float64(types.voidptr, types.voidptr, types.int32))(_act_dyn)
    return (
        ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(passive.address),
        ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int)(
            act_dyn.address
        ),
    )


def _passive(model: Any, data: Any) -> None:
    ground_forces(model, data)


def _act_dyn(model: Any, data: Any, actuator: Any) -> Any:
    return activation_rate(model, data, actuator)


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
