"""One decision of the drivers of many machines: what they see, decide, and set as controls."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from twin.compute import quaternion
from twin.compute.compiled import inlined_law, law
from twin.physics import block
from twin.physics.block import MachineSlot
from twin.simulation.braking import governed_radps, press
from twin.simulation.driver import ackermann, drive
from twin.simulation.records import Records

Array = NDArray[np.float64]

CONTROLS = (
    "throttle", "clutch_pedal", "brake", "steer_left", "steer_right", "lift",
    "differential_lock", "front_drive",
)  # fmt: skip
"""Actuators that the driver sets, in the order in which `decide` writes them."""
DEPTH_SLOT = block.MACHINE_SLOTS + int(MachineSlot.DEPTH_M)
DRAFT_SLOT = block.MACHINE_SLOTS + int(MachineSlot.DRAFT_N)

x_axis = inlined_law(quaternion.x_axis)


@law
def observe(
    qpos: Array, qvel: Array, userdata: Array, world_from_ground: Array, links: int, seen: Records
) -> None:
    """Place, heading and speed on the ground's line, depth and draft, hitch.

        along = x . p    left = y . p    heading = atan2(y . a, x . a)

    Args:
        qpos: position p of the rear-axle centre, attitude with x axis a, joints (nsim, nq).
        qvel: velocity of the rear-axle centre, rates (nsim, nv).
        userdata: the callback's report (nsim, nuserdata).
        world_from_ground: rotation whose columns are x along the line and y to its left
            (nsim, 3, 3).
        links: where qpos has the angle of the lower links; negative for none.
        seen: written, an Observation of each (nsim,).
    """
    for i in range(len(seen)):
        r = world_from_ground[i]
        px, py, pz = qpos[i, 0], qpos[i, 1], qpos[i, 2]
        ax, ay, az = x_axis(qpos[i, 3], qpos[i, 4], qpos[i, 5], qpos[i, 6])
        now = seen[i]
        now.along_m = px * r[0, 0] + py * r[1, 0] + pz * r[2, 0]
        now.left_m = px * r[0, 1] + py * r[1, 1] + pz * r[2, 1]
        ahead = ax * r[0, 0] + ay * r[1, 0] + az * r[2, 0]
        left = ax * r[0, 1] + ay * r[1, 1] + az * r[2, 1]
        now.heading_rad = math.atan2(left, ahead)
        now.depth_m = userdata[i, DEPTH_SLOT]
        now.draft_n = userdata[i, DRAFT_SLOT]
        now.hitch_rad = qpos[i, links] if links >= 0 else 0.0
        vx, vy, vz = qvel[i, 0], qvel[i, 1], qvel[i, 2]
        now.speed_mps = math.sqrt(vx * vx + vy * vy + vz * vz)


@law
def decide(
    tasks: Records,
    drivetrain: Records,
    seen: Records,
    engine_radps: Array,
    drivers: Records,
    pedals: Records,
    controls: Array,
    dt_s: float,
) -> None:
    """The controls for the next interval, and what the drivers remember.

    Args:
        tasks: a DriverTask of each (nsim,).
        drivetrain: a Drivetrain of each (nsim,).
        seen: an Observation of each (nsim,).
        engine_radps: engine speeds (nsim,).
        drivers: read and written, a DriverState of each (nsim,).
        pedals: read and written, a BrakePedal of each (nsim,).
        controls: written, the values of CONTROLS (nsim, 8).
        dt_s: the interval.
    """
    for i in range(len(tasks)):
        known, task, driver, pedal = drivetrain[i], tasks[i], drivers[i], pedals[i]
        new = drive(task, driver, seen[i], dt_s)
        driver.steer_rad, driver.bias_rad = new.steer_rad, new.bias_rad
        driver.lift_rad, driver.trim_rad = new.lift_rad, new.trim_rad
        driver.felt_n, driver.full_depth_at_m = new.felt_n, new.full_depth_at_m
        driver.working = new.working
        asked_radps = governed_radps(known, task.throttle)
        foot = press(known, pedal, engine_radps[i], asked_radps, dt_s)
        pedal.asked_radps, pedal.felt_mps = foot.asked_radps, foot.felt_mps
        pedal.held_mps2, pedal.pedal = foot.held_mps2, foot.pedal
        left, right = ackermann(new.steer_rad, task.wheelbase_m, task.track_m)
        controls[i, 0], controls[i, 1] = task.throttle, task.clutch_pedal
        controls[i, 2] = max(foot.pedal if task.brakes else 0.0, task.brake_pedal)
        controls[i, 3], controls[i, 4], controls[i, 5] = left, right, new.lift_rad
        controls[i, 6] = 1.0 if task.differential_lock and new.working else 0.0
        controls[i, 7] = 1.0 if task.front_drive else 0.0
