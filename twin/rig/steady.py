"""Run the test stand to its steady state and read it."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from twin.errors import TwinError
from twin.physics.block import Wheel, WheelSlot
from twin.rig.stand import SERVO_RADPS, STEP_S

Array = NDArray[np.float64]

SEATING_S = 0.4
"""Time in which the wheel sinks onto its tyre before the spin is set by its rolling radius [s]."""
RELAXATION_LENGTHS = 16.0
"""Distance run before reading, in the tyre's longest relaxation length: exp(-16) is 1e-7."""
STEADY = 1e-3
"""Most that a force may change over the last tenth of the run, over the load."""


class NotSteady(TwinError, ArithmeticError):
    """A rig did not come to a steady state, or left the finite numbers."""


SLOTS = {
    "slip": WheelSlot.SLIP,
    "tread_speed_y_mps": WheelSlot.TREAD_SPEED_Y_MPS,
    "speed_x_mps": WheelSlot.SPEED_X_MPS,
    "rolling_radius_m": WheelSlot.ROLLING_RADIUS_M,
    "sinkage_m": WheelSlot.SINKAGE_M,
    "resistance_n": WheelSlot.RESISTANCE_N,
}


def steady(
    model: mujoco.MjModel,
    sizes: Mapping[Wheel, float],
    load_n: Array,
    speeds_mps: Mapping[str, Array],
) -> dict[str, Array]:
    """Run all points at once to their steady state, and read forces and `SLOTS`. Shape (n,) each.

    Args:
        model: of `twin.rig.stand.stand`.
        sizes: numbers of the tyre by `Wheel`, in SI units.
        load_n: load of each point [N] (n,).
        speeds_mps: wanted speed of each joint [m/s] (n,); of "spin" the rolling speed w R.

    Returns:
        By joint, the force [N] or torque [N m] of its servo; by name, the slots; `slip_angle_rad`.

    Raises:
        NotSteady: MuJoCo warned, a force is not finite, or one still changes at the end.
    """
    batch = Batch(model, nsim=len(load_n), nthread=1)
    ctrl, slots = batch.bind("ctrl"), batch.bind("userdata")
    held = [model.sensor(i).name for i in range(model.nsensor)]
    ctrl[:, model.actuator("lift").id] = -load_n
    _start(model, batch, sizes, load_n, speeds_mps, held)
    for joint in held:
        radius = sizes[Wheel.FREE_ROLLING_RADIUS_M] if joint == "spin" else 1.0
        ctrl[:, model.actuator(joint).id] = speeds_mps[joint] / radius
    batch.rollout(round(SEATING_S / STEP_S), record=("sensordata",))
    if "spin" in held:
        radius_m = slots[:, WheelSlot.ROLLING_RADIUS_M]
        ctrl[:, model.actuator("spin").id] = speeds_mps["spin"] / radius_m
    slowest = float(np.min(np.hypot(speeds_mps["along"], speeds_mps["across"])))
    longest_m = max(sizes[Wheel.RELAXATION_LONG_M], sizes[Wheel.RELAXATION_LAT_M])
    seconds = SEATING_S + RELAXATION_LENGTHS * longest_m / slowest
    record = batch.rollout(round(seconds / STEP_S), record=("sensordata",))
    forces = record["sensordata"]
    _refuse_unsteady(batch, forces, load_n, sizes, held)
    out = {joint: np.array(forces[:, -1, i]) for i, joint in enumerate(held)}
    out |= {name: np.array(slots[:, slot]) for name, slot in SLOTS.items()}
    out["slip_angle_rad"] = np.arctan2(-out["tread_speed_y_mps"], np.abs(out["speed_x_mps"]))
    return out


def _start(
    model: mujoco.MjModel,
    batch: Batch,
    sizes: Mapping[Wheel, float],
    load_n: Array,
    speeds_mps: Mapping[str, Array],
    held: list[str],
) -> None:
    """On the tyre's deflection, at the wanted speeds, the servos at rest behind them."""
    qpos, qvel, act = batch.bind("qpos"), batch.bind("qvel"), batch.bind("act")
    qpos[:, model.joint("up").qposadr[0]] = -load_n / sizes[Wheel.STIFFNESS_NPM]
    for joint, speed in speeds_mps.items():
        rate = speed / sizes[Wheel.FREE_ROLLING_RADIUS_M] if joint == "spin" else speed
        qvel[:, model.joint(joint).dofadr[0]] = rate
        if joint in held:
            servo = model.actuator_actadr[model.actuator(joint).id]
            act[:, servo] = rate * 2.0 / SERVO_RADPS  # where damping and stiffness balance


def _refuse_unsteady(
    batch: Batch, forces: Array, load_n: Array, sizes: Mapping[Wheel, float], held: list[str]
) -> None:
    """Raise NotSteady for a point that MuJoCo warned of, is not finite, or still changes."""
    if warned := np.flatnonzero(batch.warning[:, :, 1].sum(axis=0)).tolist():
        raise NotSteady(f"MuJoCo warned in the wheel rig: {mujoco.mjtWarning(warned[0]).name}")
    late = forces[:, -max(2, forces.shape[1] // 10) :]
    scale = load_n[:, None] * np.array(
        [sizes[Wheel.FREE_ROLLING_RADIUS_M] if joint == "spin" else 1.0 for joint in held]
    )
    change = np.max(np.ptp(late, axis=1) / scale, axis=1)
    worst = int(np.argmax(np.where(np.isfinite(change), change, np.inf)))
    if not change[worst] <= STEADY:
        raise NotSteady(
            f"point {worst} of the wheel rig (load_n = {load_n[worst]:g}) is not steady: "
            f"its forces still change by {change[worst]:.2g} of the load"
        )
