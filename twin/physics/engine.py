"""A diesel with a mechanical governor, or an electric motor with a speed controller."""

from __future__ import annotations

import math

from twin.compute.compiled import law
from twin.physics.block import Engine, Key
from twin.physics.shapes import Array

ELECTRIC = 1.0
POINTS = int(Engine.POINTS)
OFF, START = int(Key.OFF), int(Key.START)
MOTORED_PA, MOTORED_PA_PER_RPM, MOTORED_PA_S2PM2 = 75e3, 48.0, 400.0
"""Mean effective pressure that turns an unfuelled diesel of direct injection: at rest [Pa], per
speed [Pa/rpm], and per square of the mean piston speed [Pa s^2/m^2]."""
STALLED_RPM, FIRING_RPM = 300.0, 500.0
"""Below FIRING_RPM the torque of a diesel falls; at STALLED_RPM it is 0: the engine has died."""
TURNING_RPM = 50.0
"""Speed below which the parasitic torque is proportional to the speed [rpm]."""
STARTER_RPM, STARTER_SHARE = 600.0, 0.4
"""Speed at which a starter turns freely, and its torque at rest over the rated torque [rpm, -]: it
turns a warm diesel at some 300 rpm until it fires; assumed."""


@law
def _torque_of(power_w: float, rpm: float) -> float:
    """P / |w|."""
    return power_w / max(abs(rpm) * math.pi / 30.0, 1e-6)


@law
def _measured_torque_nm(engine: Array, rpm: float) -> float:
    """Linear between the measured points, in the order of their speeds."""
    count, at = int(engine[Engine.POINT_COUNT]), POINTS
    torque = engine[at + 1]
    for i in range(1, count):
        low, high = engine[at + 2 * i - 2], engine[at + 2 * i]
        share = min(max((rpm - low) / (high - low), 0.0), 1.0)
        torque += share * (engine[at + 2 * i + 1] - engine[at + 2 * i - 1])
    return torque


@law
def full_load_torque_nm(engine: Array, rpm: float) -> float:
    """Full-load torque of a diesel, or the torque limit of an electric motor [N m].

    A diesel's is a parabola with its vertex at the peak torque, through the rated torque, and no
    more than its maximum power allows. From 500 to 300 rpm it falls to 0.

        T_p = T_r rise ;  u = (n - n_p) / (n_r - n_p) ;  f = clip((n - 300) / (500 - 300), 0, 1)
        T = f min(max(0, T_p - (T_p - T_r) u**2), P_max / w)

    Where torque was measured by speed, T is linear between the points in place of the parabola, and
    constant below the first and above the last. A motor's limit is

        T = min(T_r, P_max / |w|) ;  the power of regeneration replaces P_max for n < 0

    Args:
        engine: part of the block that `Engine` indexes.
        rpm: engine speed n; w is the same in rad/s.
    """
    rated = engine[Engine.RATED_TORQUE_NM]
    most = _torque_of(engine[Engine.MAX_POWER_W], rpm)
    if engine[Engine.KIND] == ELECTRIC:
        if rpm < 0.0:
            most = _torque_of(engine[Engine.REGENERATION_W], rpm)
        return min(rated, most)
    peak = rated * engine[Engine.TORQUE_RISE]
    u = (rpm - engine[Engine.PEAK_RPM]) / (engine[Engine.RATED_RPM] - engine[Engine.PEAK_RPM])
    fuelled = min(max((rpm - STALLED_RPM) / (FIRING_RPM - STALLED_RPM), 0.0), 1.0)
    if engine[Engine.POINT_COUNT] > 0.0:
        return fuelled * min(_measured_torque_nm(engine, rpm), most)
    return fuelled * min(max(0.0, peak - (peak - rated) * u * u), most)


@law
def braking_torque_nm(engine: Array, rpm: float) -> float:
    """Greatest braking torque of a diesel without fuel, or of a motor that regenerates [N m].

    A four-stroke diesel is turned against the mean effective pressure of its friction and gas
    exchange, and of its exhaust brake where that is closed:

        T = (p + p_exhaust) V / (4 pi)
        p = 75 kPa + 48 kPa n / (1000 rpm) + 0.4 kPa (S / (1 m/s))**2 ;  S = 2 L n / 60

    with the mean piston speed S of the stroke L and the displacement V. The oil, water and fuel
    pumps are in it, the fan and the generator are not. An electric motor takes

        T = min(T_r, P_regenerated / |w|)

    Source: Millington and Hartles (SAE 680590, 1968) as Heywood (1988) quotes it for direct
    injection; from memory, not compared with the print.
    """
    if engine[Engine.KIND] == ELECTRIC:
        most = _torque_of(engine[Engine.REGENERATION_W], rpm)
        return min(engine[Engine.RATED_TORQUE_NM], most)
    turning = abs(rpm)
    piston_mps = 2.0 * engine[Engine.STROKE_M] * turning / 60.0
    pressure = MOTORED_PA + MOTORED_PA_PER_RPM * turning
    pressure += MOTORED_PA_S2PM2 * piston_mps * piston_mps + engine[Engine.EXHAUST_BRAKE_PA]
    return pressure * engine[Engine.DISPLACEMENT_M3] / (4.0 * math.pi)


@law
def engine_torque_nm(engine: Array, throttle: float, rpm: float) -> float:
    """Torque of the governed engine [N m]: droop from the no-load set speed, up to full load.

        n0 = n_idle + throttle (n_max - n_idle)
        T  = (n0 - n) / (droop n_max / n0)      between -braking torque and the full-load torque

    The droop grows as 1/n0 because a flyweight's force falls with the square of its speed.
    Above n0 the fuel is shut off, and an exhaust brake that is switched on closes.

    With the key off, a diesel is braked to rest, and a motor gives nothing:
        T  = -braking torque clip(n / 50 rpm, -1, 1)
    With the key at start, the starter of a diesel adds
        T  = 0.4 T_r max(0, 1 - n / 600 rpm)
    """
    key = engine[Engine.KEY]
    if key == OFF:
        turning = min(max(rpm / TURNING_RPM, -1.0), 1.0)
        return 0.0 if engine[Engine.KIND] == ELECTRIC else -turning * braking_torque_nm(engine, rpm)
    idle, top = engine[Engine.IDLE_RPM], engine[Engine.NO_LOAD_RPM]
    set_rpm = idle + throttle * (top - idle)
    droop = engine[Engine.DROOP_RPM_PER_NM] * top / set_rpm
    torque = (set_rpm - rpm) / droop
    torque = min(max(torque, -braking_torque_nm(engine, rpm)), full_load_torque_nm(engine, rpm))
    if key == START and engine[Engine.KIND] != ELECTRIC:
        starter = STARTER_SHARE * engine[Engine.RATED_TORQUE_NM]
        torque += starter * max(0.0, 1.0 - rpm / STARTER_RPM)
    return torque


@law
def parasitic_torque_nm(engine: Array, rpm: float) -> float:
    """Torque of fan, pumps and generator [N m]: T_p clip(n / 50 rpm, -1, 1); n is `rpm`."""
    return engine[Engine.PARASITIC_NM] * min(max(rpm / TURNING_RPM, -1.0), 1.0)


@law
def axle_torque_nm(engine: Array, torque_nm: float, rpm: float) -> float:
    """Torque at the driven axle [N m]: engine torque T less parasitic torque, times the gear ratio.

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
