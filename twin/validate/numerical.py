"""Layer 5: time step, order of accuracy, settling, seeds."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.compute import quaternion
from twin.machine.build import Machine
from twin.physics.block import WheelSlot
from twin.reproduce.passes import drive
from twin.rig.tractor import tractor
from twin.rig.tyre import Tyre
from twin.rig.wheel import wheel
from twin.scenario import Course, Drive, Plough, Scenario, Soil
from twin.simulation.build import build
from twin.validate.by_hand import hold, parked, rolling, wheels
from twin.validate.check import Basis, Check, within

Array = NDArray[np.float64]

STEPS_MS = (2.0, 1.0, 0.5)
FINE_MS = 0.03125
"""Step of the reference: a 64th of the twin's own, so that its own error does not count."""
PLOUGHING = Scenario(
    name="validate-numerical",
    plough=Plough(depth_m=0.20),
    course=Course(approach_m=5.0, length_m=20.0),
)


def order_of_accuracy() -> list[Check]:
    """Slope of the error against the step in a steered drive, from the body to the tyres."""
    soil = Soil(strength_cv=0.0)
    levers = Drive(gear_ratio=52.0, engine_set_rpm=1700.0, differential_lock=False)
    scenario = Scenario(name="validate-order", soil=soil, drive=levers)
    machine = build(scenario)
    exact = _steered(machine, FINE_MS)
    off = [np.abs(_steered(machine, ms) - exact) for ms in STEPS_MS]
    names = (
        "rear-axle place",
        "heading",
        "deflection of the tyres along",
        "deflection of the tyres across",
        "slip",
    )
    steps = np.log(STEPS_MS)
    out = []
    for name, errors in zip(names, np.array(off).T, strict=True):
        slope = float(np.polyfit(steps, np.log(errors), 1)[0])
        out.append(
            within(
                "steered drive of 3 s, steps 2, 1, 0.5 ms",
                f"order of accuracy, {name}",
                slope,
                "1",
                low=0.8,
                high=1.3,
                reference=1.0,
                basis=Basis(
                    grade="derived",
                    source="MuJoCo's implicitfast and the tyres' deflections are first order",
                    why=f"error at 2 ms {errors[0]:.1e}, at 0.5 ms {errors[2]:.1e}, beside "
                    f"{FINE_MS:g} ms; a slope below 1 would be a kink or a lag of a step",
                ),
            )
        )
    return out


def _steered(machine: Machine, step_ms: float) -> Array:
    """Place, heading, deflections along and across, and slip after a steered drive. Shape (5,)."""
    model, steps_per_s = machine.model, round(1000.0 / step_ms)
    kept = float(model.opt.timestep)
    model.opt.timestep = 1e-3 * step_ms
    try:
        state = rolling(machine)
        hold(machine, state, throttle=machine.throttle)
        mujoco.mj_step(model, state, steps_per_s)
        hold(machine, state, throttle=machine.throttle, steer_left=0.1, steer_right=0.1)
        mujoco.mj_step(model, state, 2 * steps_per_s)
        mujoco.mj_forward(model, state)
    finally:
        model.opt.timestep = kept
    heading = quaternion.heading_rad(*state.qpos[3:7])
    act, slip = np.array(state.act[:16]).reshape(4, 4), wheels(state)[:, WheelSlot.SLIP]
    place = float(np.hypot(state.qpos[0], state.qpos[1]))
    return np.array([place, heading, act[2:, 0].mean(), act[:, 1].mean(), slip[2:].mean()])


def halved_step() -> list[Check]:
    """Means over 20 m of furrow at half and a quarter of the step."""
    passes = {ms: drive(replace(PLOUGHING, timestep_s=1e-3 * ms)) for ms in STEPS_MS}
    out = []
    for ms in STEPS_MS[1:]:
        for name in ("slip", "speed_kmh", "draft_n"):
            change = getattr(passes[ms], name) / getattr(passes[2.0], name) - 1.0
            quantity = name.rsplit("_", 1)[0] if "_" in name else name
            out.append(
                within(
                    f"plough 20 cm, step {ms:g} ms for 2 ms",
                    f"relative change of mean {quantity}",
                    change,
                    "1",
                    low=-0.01,
                    high=0.01,
                    reference=0.0,
                    basis=Basis(
                        grade="derived",
                        source="the twin's own step of 2 ms",
                        why="1 to 2 % of the slip is usual; the soil is a function of place, so "
                        "both drive over the same ground",
                    ),
                )
            )
    return out


def settling() -> list[Check]:
    """The start of a run is at rest: loads and height keep still for four seconds more."""
    machine = tractor("validate-settling", Soil())
    state = parked(machine)
    before, height = wheels(state)[:, WheelSlot.LOAD_N], float(state.qpos[2])
    mujoco.mj_step(machine.model, state, round(4.0 / machine.model.opt.timestep))
    change = np.abs(wheels(state)[:, WheelSlot.LOAD_N] / before - 1.0).max()
    return [
        within(
            "start of a run, 4 s more",
            "greatest relative change of a wheel's load",
            change,
            "1",
            high=1e-3,
            reference=0.0,
            basis=Basis(source="rest", why="well below any noise", grade="derived"),
        ),
        within(
            "start of a run, 4 s more",
            "change of height",
            1e3 * abs(state.qpos[2] - height),
            "mm",
            high=0.1,
            reference=0.0,
            basis=Basis(source="rest", why="well below any noise", grade="derived"),
        ),
    ]


def seeds() -> list[Check]:
    """One seed gives one run to the bit; another seed gives another field."""
    first, again, other = (drive(replace(PLOUGHING, seed=s)) for s in (3, 3, 4))
    far = abs(first.slip / other.slip - 1.0)
    return [
        within(
            "plough 20 cm, seed 3 twice",
            "difference of mean slip",
            first.slip - again.slip,
            "1",
            low=0.0,
            high=0.0,
            reference=0.0,
            basis=Basis(
                source="determinism",
                grade="derived",
                why="to the bit: nothing is drawn but from the seed",
            ),
        ),
        within(
            "plough 20 cm, seeds 3 and 4",
            "relative difference of mean slip",
            far,
            "1",
            low=1e-4,
            high=0.3,
            basis=Basis(
                source="variation of the soil",
                grade="assumed",
                why="another field, but of the same kind",
            ),
        ),
    ]


def dissipation() -> list[Check]:
    """No wheel gets power from the soil, at any slip and slip angle, by both laws."""
    slip, angle = np.meshgrid([-0.6, -0.2, 0.0, 0.05, 0.3, 0.9], np.radians([0.0, 5.0, 20.0, 60.0]))
    out = []
    for law in ("brixius", "bekker"):
        soil = Soil(law=law)
        seen = wheel(Tyre(), soil, slip=slip, load_n=21700.0, slip_angle_rad=angle)
        roll, side = np.cos(seen.slip_angle_rad), -np.sin(seen.slip_angle_rad)
        spin = np.where(seen.slip >= 0.0, roll / (1 - seen.slip), roll * (1 + seen.slip))
        given = seen.axle_torque_nm / seen.rolling_radius_m * spin
        lost = (given - seen.net_pull_n * roll - seen.lateral_n * side) / seen.load_n
        out.append(
            within(
                f"wheel rig, {law}, slip -60 to 90 %, slip angle to 60 deg",
                "least power lost in the soil over load and speed",
                lost.min(),
                "1",
                low=0.0,
                basis=Basis(
                    source="second law: T w = P v + losses",
                    grade="derived",
                    why="no wheel gets power from the soil",
                ),
            )
        )
    return out
