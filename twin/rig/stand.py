"""The test stand: one wheel on a carriage, its speeds imposed by servos that measure the forces.

Four joints: along, across and up for the carriage, spin for the wheel. The wheel stays parallel to
the first; a slip angle is a speed across. The soil acts through the parameter block, as on a
machine; the block's other three wheels and its engine are absent.
"""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.machine.parameters import soil_part
from twin.machine.plough_setting import GRAVITY_MPS2
from twin.machine.tread import tread_part
from twin.physics import block
from twin.physics.block import Engine, Field, Head, Part, Soil, Wheel
from twin.physics.callback import install
from twin.scenario import Soil as Ground

STEP_S = 0.002
SERVO_RADPS = 50.0
"""Natural frequency of the speed servos, critically damped [rad/s]."""
HEAVE_RADPS = 0.2 / STEP_S
"""Natural frequency of the carriage on its tyre [rad/s]: the stand is as light as the step allows,
and damped at half critical, because only its rest counts."""
AXES = {"along": (1, 0, 0), "across": (0, 1, 0), "up": (0, 0, 1)}
RADIAL = {Soil.SLIP_RATE: 9.5, Soil.ROLLING_MOMENT: 0.0325, Soil.MOBILITY_RESISTANCE: 0.9}
"""Brixius (1987) for radial tyres: k, c0, m."""


def stand(
    sizes: Mapping[Wheel, float],
    soil: Ground,
    load_n: float,
    *,
    radial: bool = False,
    held: tuple[str, ...] = ("along", "across", "spin"),
) -> mujoco.MjModel:
    """The stand as a mujoco.MjModel without gravity.

    Actuators in order: `tyre` (no force), `lift` (vertical force [N], upward positive; minus the
    load), then one wanted speed for each joint of `held` ([m/s]; spin [rad/s]).

    Args:
        sizes: numbers of the tyre by `Wheel`, in SI units.
        soil: the soil under the tyre, the same everywhere.
        load_n: largest load [N]. Along and across, the carriage has the mass load_n / g.
        radial: Brixius' numbers for a radial tyre in place of the soil's.
        held: joints whose speed is imposed; "along", "across" or "spin" left out runs free.
    """
    install()
    spec = mujoco.MjSpec()
    spec.option.timestep, spec.option.gravity = STEP_S, [0.0, 0.0, 0.0]
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    spec.option.disableflags = mujoco.mjtDisableBit.mjDSBL_CONTACT
    mass_kg = load_n / GRAVITY_MPS2
    heave_kg = sizes[Wheel.STIFFNESS_NPM] / HEAVE_RADPS**2
    inertias = {"along": mass_kg, "across": mass_kg, "up": heave_kg}
    inertias["spin"] = mass_kg * sizes[Wheel.FREE_ROLLING_RADIUS_M] ** 2
    _add_bodies(spec, inertias, 0.5 * sizes[Wheel.DIAMETER_M])
    tyre = _actuator(spec, "tyre", "spin", dyntype=mujoco.mjtDyn.mjDYN_USER, gain=0.0)
    tyre.actdim = 4
    _actuator(spec, "lift", "up", gain=1.0)
    for joint in held:
        _servo(spec, joint, inertias[joint])
    spec.nuserdata = block.RATE_SLOTS + 16
    spec.add_numeric(name="tractor_twin", size=block.SIZE, data=[0.0] * block.SIZE)
    model = spec.compile()
    own = {
        Wheel.DAMPING_NSPM: heave_kg * HEAVE_RADPS,
        Wheel.NOMINAL_LOAD_N: load_n,
        Wheel.INERTIA_KGM2: inertias["spin"],
    }
    tyre = {**sizes, **own}
    if radial:  # the soil's numbers are those of a radial tyre already
        tyre |= dict.fromkeys(block.BUILD[:3], 0.0)
    model.numeric_data[-block.SIZE :] = _block(model, tyre | tread_part(tyre), soil, radial)
    return model


def _add_bodies(spec: mujoco.MjSpec, inertias: Mapping[str, float], height_m: float) -> None:
    """A chain of bodies that weigh nothing beside their joints' armatures."""
    body = spec.worldbody
    for joint, axis in (*AXES.items(), ("spin", (0, 1, 0))):
        kind = mujoco.mjtJoint.mjJNT_HINGE if joint == "spin" else mujoco.mjtJoint.mjJNT_SLIDE
        place = [0.0, 0.0, height_m] if joint == "along" else [0.0, 0.0, 0.0]
        body = body.add_body(name="wheel" if joint == "spin" else joint, pos=place)
        light = 1e-6 * min(inertias.values())
        body.mass, body.inertia, body.ipos = light, [light] * 3, [0.0, 0.0, 0.0]
        body.explicitinertial = True
        body.add_joint(name=joint, type=kind, axis=axis, armature=inertias[joint])


def _actuator(
    spec: mujoco.MjSpec, name: str, joint: str, *, gain: float, dyntype: mujoco.mjtDyn | None = None
) -> mujoco.MjsActuator:
    out = spec.add_actuator(name=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=joint)
    out.gainprm[0] = gain
    if dyntype is not None:
        out.dyntype = dyntype
    return out


def _servo(spec: mujoco.MjSpec, joint: str, inertia: float) -> None:
    """Imposes a speed and keeps no error: force = k (integral of the wanted speed - q) - c dq/dt"""
    stiffness, damping = inertia * SERVO_RADPS**2, 2.0 * inertia * SERVO_RADPS
    integrator = mujoco.mjtDyn.mjDYN_INTEGRATOR
    servo = _actuator(spec, joint, joint, gain=stiffness, dyntype=integrator)
    servo.biastype = mujoco.mjtBias.mjBIAS_AFFINE
    servo.biasprm[:3] = [0.0, -stiffness, -damping]
    force = mujoco.mjtSensor.mjSENS_ACTUATORFRC
    spec.add_sensor(name=joint, type=force, objtype=mujoco.mjtObj.mjOBJ_ACTUATOR, objname=joint)


def _block(
    model: mujoco.MjModel, sizes: Mapping[Wheel, float], soil: Ground, radial: bool
) -> NDArray[np.float64]:
    """The parameter block: one wheel on a level plane."""
    wheel = {
        Wheel.BODY: model.body("wheel").id,
        Wheel.SPIN: int(model.joint("spin").dofadr[0]),
        Wheel.TYRE: int(model.actuator_actadr[model.actuator("tyre").id]),
        **sizes,
    }
    level = {Field.AHEAD: 1.0, Field.LEFT + 1: 1.0, Field.NORMAL + 2: 1.0}
    ground = soil_part(soil) | {Soil.STRENGTH_CV: 0.0} | (RADIAL if radial else {})
    parts: list[tuple[int, Part]] = [
        (0, {Head.MAGIC: block.MAGIC, Head.VERSION: block.VERSION, Head.RATES: block.RATE_SLOTS}),
        (0, {Head.PLOUGH_BODY: -1, Head.DEPTH_WHEEL_BODY: -1}),
        (block.FIELD, level),
        (block.SOIL, ground),
        (block.WHEEL, wheel),
        *((block.WHEEL + i * Wheel.SIZE, {Wheel.BODY: -1.0}) for i in range(1, 4)),
        (block.ENGINE, {Engine.SHAFT: -1}),
    ]
    out = np.zeros(block.SIZE)
    for start, part in parts:
        for index, value in part.items():
            out[start + index] = value
    return out
