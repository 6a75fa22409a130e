"""Throttle, gear, depth and draft mix of the actions, each through the lag of what moves it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from twin.compute.compiled import inlined_law, law
from twin.env import levers
from twin.physics.block import CLUTCH_NM, GEAR_RATIO
from twin.simulation.controls import within
from twin.simulation.records import Records

Array = NDArray[np.float64]

SLOWEST_KMH, FASTEST_KMH = 3.0, 15.0
"""Speeds without slip at rated engine speed between which the gear action chooses [km/h]."""
THROTTLE_PS = 1.0
"""How fast the governor's set point moves, shares of its range [1/s]; assumed."""
RATIO_PS = 0.5
"""How fast a continuously variable transmission changes the logarithm of its ratio [1/s]: from 6 to
12 km/h in 1.4 s; assumed."""
SHIFT_S = 1.0
"""Least time between two shifts of a transmission with gears [s]; assumed."""
SAME_RATIO = 1e-6


class Gearbox(NamedTuple):
    """Numbers by which a gear action becomes a ratio."""

    longest: float
    """Least ratio that an action chooses: the fastest gear."""
    shortest: float
    inertia_kgm2: float
    """The engine's, at the crank."""
    clutch_nm: float
    """The clutch's capacity at the crank."""
    rim_m: float
    """Radius of the driven tyres that rolls."""
    draft_npm: float
    """Draft set point over depth set point of the hitch's lever [N/m]."""


def asked_ratio(gear: float, box: Gearbox) -> float:
    """Ratio of a gear action in [-1, 1], linear in the logarithm."""
    share = 0.5 * (gear + 1.0)
    return float(box.shortest * np.exp(share * np.log(box.longest / box.shortest)))


@law
def nearest(ratios: Array, ratio: float) -> float:
    """The one of some ratios that is nearest, by its logarithm; the ratio itself of none."""
    best, least = ratio, math.inf
    for known in ratios:
        off = abs(math.log(known / ratio))
        if off < least:
            best, least = known, off
    return best


_lift_sine, _governor = inlined_law(levers.lift_sine), inlined_law(levers.governor)
_depth_set_m, _asked_ratio = inlined_law(levers.depth_set_m), inlined_law(asked_ratio)


@law
def set_field_levers(
    actions: Array,
    lever: Records,
    box: Records,
    ratios: Array,
    tasks: Records,
    drivetrain: Records,
    wait_s: Array,
    work_rad: Array,
    blocks: Array,
    armature: Array,
    spin: Array,
    dt_s: float,
) -> None:
    """What the actions ask for, as far as its actuators get in a control step.

        throttle   towards the action's, no faster than 1/s of its range
        ratio      d ln i/dt within 0.5/s; with gears the nearest of them, 1 s after the last shift
        lever      angle of the lower links, and the draft set point D_0 = d depth
        mix        (1 + action) / 2

    A change of ratio keeps the engine's speed, and the clutch slips until the axle's fits.

    Args:
        actions: (nsim, 4).
        lever, box: the Levers and the Gearbox (1,).
        ratios: of the gears; none of a continuously variable transmission.
        tasks, drivetrain: of the drivers, written (nsim,).
        wait_s: time until the next shift, read and written (nsim,).
        work_rad: written, angle of the lower links that the lever asks for (nsim,).
        blocks: written, the parameter blocks (nsim, size).
        armature: written, the drive shaft's inertia (nsim,).
        spin: read and written, speed of the drive shaft (nsim,).
        dt_s: the interval.
    """
    known = box[0]
    for i in range(len(actions)):
        task = tasks[i]
        moved = _governor(actions[i, 0], lever[0]) - task.throttle
        task.throttle += within(-THROTTLE_PS * dt_s, moved, THROTTLE_PS * dt_s)
        depth_m = _depth_set_m(actions[i, 2], lever[0].deepest_m)
        work_rad[i] = math.asin(_lift_sine(depth_m, lever[0]))
        task.draft_n = known.draft_npm * max(depth_m, 0.01)
        task.mix = 0.5 * (actions[i, 3] + 1.0)
        before = drivetrain[i].gear_ratio
        ratio = nearest(ratios, _asked_ratio(actions[i, 1], known))
        wait_s[i] = max(0.0, wait_s[i] - dt_s)
        if len(ratios) == 0:
            most = RATIO_PS * dt_s
            ratio = before * math.exp(within(-most, math.log(ratio / before), most))
        elif wait_s[i] > 0.0:
            ratio = before
        if abs(ratio / before - 1.0) > SAME_RATIO:
            wait_s[i] = SHIFT_S
            spin[i] *= before / ratio
            set_ratio(i, ratio, known, drivetrain, blocks, armature)


@law
def set_ratio(
    i: int, ratio: float, box: Gearbox, drivetrain: Records, blocks: Array, armature: Array
) -> None:
    """One tractor's ratio: in its block, its drive shaft's inertia, and what its driver knows."""
    blocks[i, GEAR_RATIO] = ratio
    blocks[i, CLUTCH_NM] = box.clutch_nm * ratio
    armature[i] = box.inertia_kgm2 * ratio * ratio
    drivetrain[i].gear_ratio = ratio
    drivetrain[i].mps_per_radps = box.rim_m / ratio
