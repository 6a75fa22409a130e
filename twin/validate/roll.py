"""Layer 1: the tractor rocking from side to side on hard ground, against two degrees of freedom."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.compute import quaternion
from twin.machine.build import Machine
from twin.machine.tread import tread_part
from twin.physics import block
from twin.physics.block import Wheel
from twin.rig.tractor import Statics, statics, tractor
from twin.rig.tyre import machine_tyre
from twin.scenario import Soil
from twin.validate.by_hand import hold, parked
from twin.validate.check import Basis, Check, near

Array = NDArray[np.float64]

HARD = Soil(preset="asphalt", strength_cv=0.0)
CONTEXT = (
    "beside it, another tractor as measured: 1.5 to 1.9 Hz about a point 1.2 to 1.7 m below the "
    "centre of gravity (Sjoflot and Suggs 1972, abstract)"
)
KICK_RADPS = 0.02
"""Small, so that no tyre slides or leaves the ground."""
SEEN_S = 3.0


@dataclass(frozen=True)
class Mode:
    """The slowest motion in which a standing tractor sways and rolls together."""

    frequency_hz: float
    axis_above_cg_m: float
    """Height of the point that stays where it is; negative below the centre of gravity."""


def roll_mode() -> list[Check]:
    """The roll mode of the bare tractor, brakes on."""
    machine = tractor("validate-roll", HARD)
    body = statics(HARD)
    seen, expected = measured(machine, body), closed_form(machine, body)
    case = "rocking on hard ground, the bare tractor"
    source = (
        "two degrees of freedom, sway and roll: springs of the rear tyres, side springs of all, "
        "those of the front ones at the pivot of their axle"
    )
    return [
        near(
            case,
            "roll mode",
            seen.frequency_hz,
            "Hz",
            expected.frequency_hz,
            relative=0.05,
            basis=Basis(
                source=source,
                grade="derived",
                why="bounce, yaw and the front axle's own roll are left out",
                note=CONTEXT,
            ),
        ),
        near(
            case,
            "its axis above the centre of gravity",
            seen.axis_above_cg_m,
            "m",
            expected.axis_above_cg_m,
            relative=0.1,
            basis=Basis(
                source=source,
                grade="derived",
                why="the same, and small differences of two large numbers",
                note=CONTEXT,
            ),
        ),
    ]


def closed_form(machine: Machine, body: Statics) -> Mode:
    """The slower mode of sway y and roll phi of a rigid body on springs.

        2 U = K_r (y + h phi)**2 + K_f (y + (h - p) phi)**2 + (k_phi - W_r h - W_f (h - p)) phi**2
        k_phi = k t**2 / 2 + k b**2 / 6        2 T = m y'**2 + I phi'**2

    y: sway of the centre of gravity. m, I: mass, and roll inertia about the centre of gravity.
    K_r, K_f: lateral stiffness of both rear, both front tyres. W_r, W_f: loads of the axles.
    k: vertical stiffness of one rear tyre. t: track. b: width of a rear tyre's tread.
    h: height of the centre of gravity. p: height of the front axle's pivot, where its tyres push.
    """
    model = machine.model
    front, rear = (machine_tyre(machine.scenario.machine, axle) for axle in ("front", "rear"))
    side_r, side_f = (2.0 * tread_part(t)[Wheel.SHEAR_LAT_NPM] for t in (rear, front))
    track_m = 2.0 * float(model.body("rl_wheel").pos[1])
    stiffness, width_m = rear[Wheel.STIFFNESS_NPM], rear[Wheel.WIDTH_M]
    share = body.cg_ahead_m / body.wheelbase_m
    height = body.cg_height_m
    above_pivot = height - (float(parked(machine).qpos[2]) + float(model.body("front_axle").pos[2]))
    roll_npm = stiffness * (0.5 * track_m**2 + width_m**2 / 6.0)
    roll_npm -= body.weight_n * ((1.0 - share) * height + share * above_pivot)
    cross = side_r * height + side_f * above_pivot
    roll_npm += side_r * height**2 + side_f * above_pivot**2
    springs = np.array([[side_r + side_f, cross], [cross, roll_npm]])
    masses = np.diag([body.weight_n / 9.81, roll_inertia_kgm2(machine)])
    squares, shapes = np.linalg.eig(np.linalg.solve(masses, springs))
    slow = int(np.argmin(squares))
    return Mode(math.sqrt(squares[slow]) / (2.0 * math.pi), shapes[0, slow] / shapes[1, slow])


def roll_inertia_kgm2(machine: Machine) -> float:
    """Of the whole machine about its centre of gravity, all joints rigid."""
    state = parked(machine)
    mujoco.mj_forward(machine.model, state)
    return float(state.crb[machine.model.body("tractor").id, 0])


def measured(machine: Machine, body: Statics) -> Mode:
    """Kicked in roll, without dampers: the frequency and where the body does not sway."""
    model, state = machine.model, parked(machine)
    kept = model.numeric_data.copy()
    for i in range(len(block.WHEELS)):
        at = len(kept) - block.SIZE + block.WHEEL + i * int(Wheel.SIZE)
        dampers = (Wheel.DAMPING_NSPM, Wheel.SHEAR_DAMPING_LONG_SPM, Wheel.SHEAR_DAMPING_LAT_SPM)
        for damper in dampers:
            model.numeric_data[at + damper] = 0.0
    hold(machine, state, brake=1.0, clutch_pedal=1.0)
    cg = model.site("cg").pos
    expected = closed_form(machine, body)
    # kicked about the mode's own axis, so that the faster mode is hardly there
    below = cg[2] + expected.axis_above_cg_m
    state.qvel[1], state.qvel[3] = KICK_RADPS * below, KICK_RADPS
    times, rolls, sways = [], [], []
    for _ in range(round(SEEN_S / model.opt.timestep)):
        mujoco.mj_step(model, state)
        roll = float(quaternion.roll_rad(*state.qpos[3:7]))
        times.append(state.time)
        rolls.append(roll)
        sways.append(float(state.qpos[1]) - cg[2] * roll)
    model.numeric_data[:] = kept
    return _fitted(np.array(times), np.array(rolls), np.array(sways))


def _fitted(time_s: Array, roll_rad: Array, sway_m: Array) -> Mode:
    """The sine that fits the roll best, and sway over roll at its frequency."""
    tried = np.arange(0.5, 4.0, 0.002)

    def part(signal: Array, hz: float) -> tuple[float, complex]:
        w = 2.0 * math.pi * hz * time_s
        basis = np.stack([np.cos(w), np.sin(w), np.ones_like(w)], 1)
        found, left, *_ = np.linalg.lstsq(basis, signal)
        return float(left[0]), complex(found[0], -found[1])

    best = min(tried, key=lambda hz: part(roll_rad, hz)[0])
    ratio = part(sway_m, best)[1] / part(roll_rad, best)[1]
    return Mode(float(best), float(ratio.real))
