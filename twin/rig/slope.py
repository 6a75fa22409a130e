"""The slope rig: the tractor holds a line across a slope; its steady crab angle."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import root

from twin.errors import BadInput, TwinError, check_range
from twin.physics.block import WheelSlot
from twin.rig.table import Measured
from twin.rig.tractor import Statics, drive, mean, statics, tractor
from twin.rig.tyre import Tyre
from twin.rig.wheel import towed, wheel
from twin.scenario import Field, Soil
from twin.simulation.simulation import Simulation
from twin.vehicle import files

Array = NDArray[np.float64]

APPROACH_S = 30.0
"""Time in which the driver finds the steady line [s]: 60 m, ten of his looks ahead."""
WINDOW_S = 5.0
"""Time over which it is averaged [s]."""

LOAD_ITERATIONS = 3
"""Iterations of the axle loads, which the axle torque changes by some per cent."""
BALANCED = 1e-4
"""Most that a force may remain, over the weight."""


class NoBalance(TwinError, ArithmeticError):
    """The closed form has no steady state: the slope is more than the tyres hold."""


@dataclass(frozen=True, kw_only=True)
class CrabAngles(Measured):
    """Steady driving across slopes, one value per slope. Shape (n,)."""

    cross_slope_deg: Array
    crab_angle_rad: Array
    """From the path to the tractor's axis, positive turned to the left; uphill on a slope that
    rises to the left."""
    steer_rad: Array
    slip: Array
    """Mean of the rear wheels."""
    upper_load_n: Array
    """Load of the rear wheel on the left [N]."""
    lower_load_n: Array
    """Load of the rear wheel on the right [N]."""


def slope(soil: Soil, cross_slope_deg: ArrayLike, *, machine: str = files.USUAL) -> CrabAngles:
    """Drive along each cross-slope for 30 s, then average crab angle, slip and loads over 5 s.

    Args:
        soil: the soil, the same everywhere.
        cross_slope_deg: slopes across the course, rising to the left [deg] (n,).
        machine: a name of `twin list`, or a file.

    Raises:
        OutOfRange: a slope beyond what a scenario may have.
        BadInput: no slope is given.
        UnknownName: there is no such machine.
    """
    slopes = np.atleast_1d(np.asarray(cross_slope_deg, dtype=np.float64))
    if not slopes.size:
        raise BadInput("cross_slope_deg is empty; give at least one slope [deg]")
    return CrabAngles(
        **_stacked(slopes, [_driven(soil, float(angle), machine) for angle in slopes])
    )


def _driven(soil: Soil, cross_slope_deg: float, machine: str) -> tuple[float, ...]:
    field = Field(cross_slope_deg=cross_slope_deg)
    simulation = Simulation(tractor("rig-slope", soil, field, machine=machine))
    drive(simulation, APPROACH_S)
    slots = mean(drive(simulation, WINDOW_S))
    rear = slots.wheels[2:]
    forward, left = rear[:, WheelSlot.SPEED_X_MPS].mean(), rear[:, WheelSlot.SPEED_Y_MPS].mean()
    upper, lower = rear[:, WheelSlot.LOAD_N]
    crab = math.atan2(-left, forward)
    return crab, slots.steer_rad, float(rear[:, WheelSlot.SLIP].mean()), float(upper), float(lower)


def _stacked(slopes: Array, rows: list[tuple[float, ...]]) -> dict[str, Array]:
    crab, steer, slip, upper, lower = np.array(rows).T
    return {
        "cross_slope_deg": slopes, "crab_angle_rad": crab, "steer_rad": steer, "slip": slip,
        "upper_load_n": upper, "lower_load_n": lower,
    }  # fmt: skip


def expected(soil: Soil, cross_slope_deg: ArrayLike, *, machine: str = files.USUAL) -> CrabAngles:
    """Crab angle, steering and slip from the equilibrium of a rigid tractor on the rig's wheels.

    In the tractor's axes, with the crab angle beta and gravity G = W sin(theta) down the slope:

        sum F_x = G sin(beta)   sum F_y = G cos(beta)   sum (x F_y - y F_x) = x_cg G cos(beta)

    over four wheels whose forces the wheel rig measures at the slip angles beta (rear) and
    beta + delta (front, towed), and whose loads are

        (N_lower - N_upper) t / 2 = F_yf h_pivot in front,  G h_cg - F_yf h_pivot behind

    because the front axle swings; axle torque T and towed force move load to the rear,

        N_f = (x_cg W cos(theta) + (z_f - z_r) F_f - T) / L

    The locked differential gives both rear wheels one speed; their radii differ with their loads.
    What the tyres' deflection adds by rolling the tractor is left out.

    Raises:
        NoBalance: the tyres do not hold the tractor on this slope.
    """
    slopes = np.atleast_1d(np.asarray(cross_slope_deg, dtype=np.float64))
    body = statics(soil, machine)
    tyres = Tyre(machine=machine, axle="front"), Tyre(machine=machine, axle="rear")
    return CrabAngles(**_stacked(slopes, [_balanced(soil, body, tyres, float(a)) for a in slopes]))


@dataclass(frozen=True)
class _Wheels:
    """What the wheel rig gives for the four wheels at one guess; left before right."""

    front_x_n: Array
    """In the tractor's axes, as the steered wheels return it."""
    front_y_n: Array
    rear_x_n: Array
    rear_y_n: Array
    axle_torque_nm: float


def _wheels(
    soil: Soil, tyres: tuple[Tyre, Tyre], loads_n: Array, radii_m: Array, unknown: Array
) -> _Wheels:
    """Forces at a crab angle, steering angle and mean slip of the rear wheels."""
    crab, steer, slip = (float(v) for v in unknown)
    slips = 1.0 - (1.0 - slip) * radii_m.mean() / radii_m  # of one angular speed
    rear = wheel(tyres[1], soil, slip=slips, load_n=loads_n[2:], slip_angle_rad=crab)
    front = towed(tyres[0], soil, load_n=loads_n[:2], slip_angle_rad=crab + steer)
    cos, sin = math.cos(steer), math.sin(steer)
    return _Wheels(
        front_x_n=front.net_pull_n * cos - front.lateral_n * sin,
        front_y_n=front.lateral_n * cos + front.net_pull_n * sin,
        rear_x_n=rear.net_pull_n,
        rear_y_n=rear.lateral_n,
        axle_torque_nm=float(rear.axle_torque_nm.sum()),
    )


def _unbalanced(body: Statics, theta_rad: float, crab_rad: float, seen: _Wheels) -> Array:
    """Forces ahead and to the left and the turning moment that remain, over weight. Shape (3,)."""
    downhill_n = body.weight_n * math.sin(theta_rad)
    side_n = downhill_n * math.cos(crab_rad)
    half = np.array([0.5, -0.5])
    turning = body.wheelbase_m * seen.front_y_n.sum() - body.cg_ahead_m * side_n
    turning -= body.rear_track_m * float(half @ seen.rear_x_n)
    turning -= body.front_track_m * float(half @ seen.front_x_n)
    ahead = seen.rear_x_n.sum() + seen.front_x_n.sum() - downhill_n * math.sin(crab_rad)
    left = seen.rear_y_n.sum() + seen.front_y_n.sum() - side_n
    return np.array([ahead, left, turning / body.wheelbase_m]) / body.weight_n


def _balanced(
    soil: Soil, body: Statics, tyres: tuple[Tyre, Tyre], cross_slope_deg: float
) -> tuple[float, ...]:
    """Crab angle, steering, slip, and the rear wheels' loads in equilibrium."""
    check_range("cross_slope_deg", cross_slope_deg, -25.0, 25.0)
    theta = math.radians(cross_slope_deg)
    solution = np.array([0.2 * theta, 0.05 * theta, 0.015 + 0.1 * theta**2])
    loads = _loads(body, theta, 0.0, 0.0)
    for _ in range(LOAD_ITERATIONS):
        radii = towed(tyres[1], soil, load_n=loads[2:]).rolling_radius_m

        def residual(unknown: Array, loads: Array = loads, radii: Array = radii) -> Array:
            seen = _wheels(soil, tyres, loads, radii, unknown)
            return _unbalanced(body, theta, float(unknown[0]), seen)

        found = root(residual, solution, method="hybr", options={"eps": 1e-4, "xtol": 1e-5})
        if np.max(np.abs(found.fun)) > BALANCED:
            raise NoBalance(
                f"the tyres do not hold the tractor on cross_slope_deg = {cross_slope_deg:g}"
            )
        solution = found.x
        seen = _wheels(soil, tyres, loads, radii, solution)
        loads = _loads(body, theta, seen.axle_torque_nm, float(seen.front_x_n.sum()))
    crab, steer, slip = (float(v) for v in solution)
    return crab, steer, slip, float(loads[2]), float(loads[3])


def _loads(body: Statics, theta_rad: float, torque_nm: float, front_x_n: float) -> Array:
    """Loads of fl fr rl rr on a cross slope that rises to the left. Shape (4,)."""
    normal_n = body.weight_n * math.cos(theta_rad)
    downhill_n = body.weight_n * math.sin(theta_rad)
    pitch = (body.front_hub_m - body.rear_hub_m) * front_x_n - torque_nm
    front_n = (body.cg_ahead_m * normal_n + pitch) / body.wheelbase_m
    front_moment = body.cg_ahead_m / body.wheelbase_m * downhill_n * body.front_hub_m
    rear_moment = downhill_n * body.cg_height_m - front_moment
    front, rear = 0.5 * front_n, 0.5 * (normal_n - front_n)
    d_front, d_rear = front_moment / body.front_track_m, rear_moment / body.rear_track_m
    return np.array([front - d_front, front + d_front, rear - d_rear, rear + d_rear])
