"""Actions of Plough-v0 as set points: governor speed of the engine, angle of the lower links."""

from __future__ import annotations

from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from twin.compute.compiled import inlined_law, law
from twin.simulation.records import Records

Array = NDArray[np.float64]
Number = TypeVar("Number", float, Array)

RAISED_M = -0.10
"""Depth set point at which the plough is carried: the shares this much above the ground [m]."""
DEEPEST_M = 0.35
"""Deepest depth set point of the usual implement [m]; another has its own greatest depth."""
SLOWEST, FASTEST = 1.125, 0.99
"""No-load engine speeds between which the throttle sets the governor: over idle, and over the
greatest."""


class Levers(NamedTuple):
    """Limits and link geometry by which actions in [-1, 1] become set points."""

    idle_rpm: float
    no_load_rpm: float
    """No-load engine speeds with the throttle lever at 0 and at 1."""
    slowest_rpm: float
    fastest_rpm: float
    """No-load engine speeds that the throttle actions -1 and 1 set."""
    deepest_m: float
    """Greatest depth set point of the plough below the unploughed surface [m]."""
    sole_m: float
    """Height of the hitch points above the sole of the level plough."""
    axle_m: float
    """Height of the axle's middle; the wheels of one side run at working depth."""
    pivot_m: float
    """Height of the front pivot of the lower links above the rear axle."""
    length_m: float
    """Length of the lower links, from the front pivot to the hitch point."""


def lift_sine(depth_set_m: Number, lever: Levers) -> Number:
    """Sine of the lower links' angle above the horizontal at a depth set point; elementwise [-].

    sine = (sole_m - depth_set_m - axle_m - pivot_m) / length_m, limited to [-1, 1].
    Above the ground, the hitch points are at sole_m - depth_set_m, the pivot at axle_m + pivot_m.
    """
    rise_m = lever.sole_m - depth_set_m - lever.axle_m - lever.pivot_m
    sine: Number = np.maximum(-1.0, np.minimum(1.0, rise_m / lever.length_m))
    return sine


def governor(throttle: Number, lever: Levers) -> Number:
    """Control of a throttle action in [-1, 1], linear in the no-load speed it sets; elementwise."""
    set_rpm = lever.slowest_rpm + 0.5 * (throttle + 1.0) * (lever.fastest_rpm - lever.slowest_rpm)
    return (set_rpm - lever.idle_rpm) / (lever.no_load_rpm - lever.idle_rpm)


def depth_set_m(hitch: Number, deepest_m: float = DEEPEST_M) -> Number:
    """Depth set point of a hitch action in [-1, 1], up to the deepest; elementwise [m]."""
    return RAISED_M + 0.5 * (hitch + 1.0) * (deepest_m - RAISED_M)


_lift_sine, _governor = inlined_law(lift_sine), inlined_law(governor)
_depth_set_m = inlined_law(depth_set_m)


@law
def set_levers(actions: Array, lever: Records, tasks: Records, sine: Array) -> None:
    """Throttle of the actions into the tasks, and the sine of the lower links' angle."""
    for i in range(len(actions)):
        tasks[i].throttle = _governor(actions[i, 0], lever[0])
        sine[i] = _lift_sine(_depth_set_m(actions[i, 1], lever[0].deepest_m), lever[0])
