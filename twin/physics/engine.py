"""A diesel with a mechanical governor."""

from __future__ import annotations

import math

from twin.compiled import law
from twin.physics.block import Engine
from twin.physics.shapes import Array

MOTORING_NM = 60.0
"""Drag of the unfuelled engine beside its parasitic torque [N m]; assumed."""
ELECTRIC = 1.0
STALLED_RPM, FIRING_RPM = 300.0, 500.0
"""A diesel that is pulled below the second loses torque, and below the first has died [rpm]."""
TURNING_RPM = 50.0
"""Speed within which the parasitic torque changes its sign about rest [rpm]."""


@law
def full_load_torque_nm(engine: Array, rpm: float) -> float:
    """Full-load torque of a diesel, or the torque limit of an electric motor.

    A diesel's is a parabola through peak and rated torque, and falls to nothing at a stall.

    T = T_p - (T_p - T_r) ((n - n_p) / (n_r - n_p))**2 ;  T_p = T_r rise
    times clip((n - 300) / (500 - 300), 0, 1)

    A motor's is T = min(T_r, P / w).
    """
    rated = engine[Engine.RATED_TORQUE_NM]
    if engine[Engine.KIND] == ELECTRIC:
        return min(rated, engine[Engine.POWER_W] / max(rpm * math.pi / 30.0, 1e-6))
    peak = rated * engine[Engine.TORQUE_RISE]
    u = (rpm - engine[Engine.PEAK_RPM]) / (engine[Engine.RATED_RPM] - engine[Engine.PEAK_RPM])
    fuelled = min(max((rpm - STALLED_RPM) / (FIRING_RPM - STALLED_RPM), 0.0), 1.0)
    return fuelled * max(0.0, peak - (peak - rated) * u * u)


@law
def engine_torque_nm(engine: Array, throttle: float, rpm: float) -> float:
    """Torque of the governed engine: droop from the no-load set speed, within the full-load curve.

        n0 = n_idle + throttle (n_max - n_idle)
        T  = (n0 - n) / (droop n_max / n0)      between -motoring drag and the full-load torque

    The droop grows as 1/n0 because a flyweight's force falls with the square of its speed.
    """
    idle, top = engine[Engine.IDLE_RPM], engine[Engine.NO_LOAD_RPM]
    set_rpm = idle + throttle * (top - idle)
    droop = engine[Engine.DROOP_RPM_PER_NM] * top / set_rpm
    torque = (set_rpm - rpm) / droop
    return min(max(torque, -MOTORING_NM), full_load_torque_nm(engine, rpm))


@law
def parasitic_torque_nm(engine: Array, rpm: float) -> float:
    """Torque of fan, pumps and generator against the motion: T_p clip(n / 50 rpm, -1, 1)."""
    return engine[Engine.PARASITIC_NM] * min(max(rpm / TURNING_RPM, -1.0), 1.0)


@law
def axle_torque_nm(engine: Array, torque_nm: float, rpm: float) -> float:
    """Torque at the driven axle: the rest after parasitic load, through the transmission.

        c      = clip(n / 50 rpm, -1, 1)
        T_axle = i (T - T_p c) eta**(c sgn(T - T_p c))

    Losses act against the motion and the flow of power: a stalled engine pushed backwards is
    braked, and the efficiency divides when the wheels drive the engine.
    """
    net = torque_nm - parasitic_torque_nm(engine, rpm)
    turning = min(max(rpm / TURNING_RPM, -1.0), 1.0)
    kept = engine[Engine.TRANSMISSION_EFFICIENCY] ** (turning if net > 0.0 else -turning)
    return net * engine[Engine.GEAR_RATIO] * kept


@law
def radps_to_rpm(rate_radps: float) -> float:
    """Revolutions per minute."""
    return rate_radps * 30.0 / math.pi
