"""What no data sheet knows, learnt from the streams: noise of the sensors and of the motion."""

from __future__ import annotations

import math

from estimators.kalman import Record
from estimators.slip_ekf.layout import FROM_GNSS, LAGS, V
from twin.compute.compiled import array_law

SETTLE, JERK_SETTLE = 100.0, 500.0
"""Samples over which variances, and the density of the jerk, are averaged."""
CLIP, JERK_CLIP = 9.0, 4.0
"""A square counts at most as so many variances: an event is not noise."""
QUICK_S = 0.25
"""A source with longer steps than this shows the motion in its second differences [s]."""
GAIN_SLOW_S, GAIN_S, GAIN_PRIOR_MPS = 0.5, 30.0, 0.01
"""What lasts longer than the first of these is slow, the gain is learnt over the second [s], and
the prior of it counts as much as swings of the last [m/s]."""
MOVING_MPS = 0.5
"""Above this speed a camera's scale is learnt [m/s]."""
CAMERA_SHARE, CAMERA_STEP_S, CAMERA_PACE, MOST_CAMERA = 0.03, 2.0, 0.25, 1e-3
"""Share of a frame in the mean of a second, time between two of them [s], share of one step in the
density of the walk, and the most that it does [1/s]."""
PACE = 0.01
"""How fast a factor follows normalised innovations that are too large on average."""


@array_law
def accel_var(accel: float, epoch_ns: int, floor_var: float, memory: Record) -> float:
    """Variance of the white part of an acceleration, never below the data sheet's.

    d = a_k - 2 a_k-1 + a_k-2,   E d^2 = 6 var             for white noise; motion hardly enters d
    c = a_k - a_k-10,            E c^2 = 2 var + psd tau   for white jerk

    The second gives `memory.jerk_psd`.
    """
    if memory.accel_count == 0:
        memory.accel_var = floor_var
    if memory.accel_count >= 2:
        square = (accel - 2.0 * memory.accel[0] + memory.accel[1]) ** 2 / 6.0
        square = min(square, CLIP * max(memory.accel_var, floor_var))
        memory.accel_var += (square - memory.accel_var) / min(SETTLE, memory.accel_count + 10.0)
    tau = (epoch_ns - memory.accel_ns[LAGS - 1]) * 1e-9
    if memory.accel_count >= LAGS and 0.0 < tau < 1.0:
        white = 2.0 * memory.accel_var
        limit = JERK_CLIP * (white + max(memory.jerk_psd, 0.0) * tau)
        square = min((accel - memory.accel[LAGS - 1]) ** 2, limit)
        gain = 1.0 / min(JERK_SETTLE, memory.accel_count)
        memory.jerk_psd += gain * ((square - white) / tau - memory.jerk_psd)
    for i in range(LAGS - 1, 0, -1):
        memory.accel[i], memory.accel_ns[i] = memory.accel[i - 1], memory.accel_ns[i - 1]
    memory.accel[0], memory.accel_ns[0] = accel, epoch_ns
    memory.accel_count += 1
    return float(max(memory.accel_var, floor_var))


@array_law
def white_var(source: int, speed: float, epoch_ns: int, told_var: float, memory: Record) -> float:
    """Variance of the white noise of a source of speeds, never below what it tells.

    d = z_k - 2 z_k-1 + z_k-2,   E d^2 = 6 var    for white noise; motion hardly enters d

    Slower sources are taken at their word: there the motion enters.
    """
    since = (epoch_ns - memory.white_ns[source]) * 1e-9
    last = memory.white_last[source]
    if memory.white_ns[source] < 0 or since > QUICK_S:
        memory.white_ns[source] = epoch_ns
        last[0] = speed
        last[1] = math.nan
        return told_var
    square = (speed - 2.0 * last[0] + last[1]) ** 2 / 6.0
    if math.isfinite(square):
        square = min(square, CLIP * max(memory.white_var[source], told_var))
        memory.white_var[source] += (square - memory.white_var[source]) / SETTLE
    last[1] = last[0]
    last[0] = speed
    memory.white_ns[source] = epoch_ns
    return float(max(memory.white_var[source], told_var))


@array_law
def gain(ground: float, wheel: float, dt: float, prior: float, memory: Record) -> None:
    """Learn how much of what the ground speed changes by quickly the driven wheels do, too.

    gain = E (w - slow w) (v - slow v) / E (v - slow v)^2

    A load slows the ground and leaves governed wheels most of their speed; a throttle changes both.
    """
    share = min(dt / GAIN_SLOW_S, 1.0)
    swings = memory.swings
    if swings[1] == 0.0:
        memory.slow[0], memory.slow[1] = ground, wheel
        swings[1] = GAIN_PRIOR_MPS**2 * GAIN_S
        swings[0] = prior * swings[1]
    memory.slow[0] += share * (ground - memory.slow[0])
    memory.slow[1] += share * (wheel - memory.slow[1])
    v, w = ground - memory.slow[0], wheel - memory.slow[1]
    keep = max(1.0 - dt / GAIN_S, 0.0)
    swings[0] = keep * swings[0] + v * w * dt
    swings[1] = max(keep * swings[1] + v * v * dt, 1e-9)


@array_law
def camera_walk(speed: float, epoch_ns: int, least: float, memory: Record) -> None:
    """Density of the walk of a camera's scale, from what GNSS and wheels make of it.

    c = speed / v - 1 over a second,   E (c_k - c_k-1)^2 = psd dt + 2 var v / v^2

    Until it is seen to be steady, a camera whose height nobody knows says how speed changes, and
    not how large it is.
    """
    told = memory.known and memory.refused_ns[FROM_GNSS] < 0
    told = told and epoch_ns - memory.seen_ns[FROM_GNSS] < 1.5e9 and abs(memory.x[V]) > MOVING_MPS
    if not told:
        memory.camera_ns = -1
        return
    scale = speed / memory.x[V] - 1.0
    if memory.camera_ns < 0 or epoch_ns - memory.camera_ns > 10e9:
        memory.camera_ns, memory.camera_scale[0] = epoch_ns, scale
        memory.camera_scale[1] = math.nan
        return
    memory.camera_scale[0] += CAMERA_SHARE * (scale - memory.camera_scale[0])
    dt = (epoch_ns - memory.camera_ns) * 1e-9
    if dt > CAMERA_STEP_S:
        step = memory.camera_scale[0] - memory.camera_scale[1]
        if math.isfinite(step):
            walked = max(step**2 - 2.0 * memory.p[V, V] / memory.x[V] ** 2, 0.0) / dt
            memory.camera_psd += CAMERA_PACE * (min(walked, MOST_CAMERA) - memory.camera_psd)
            memory.camera_psd = max(memory.camera_psd, least)
        memory.camera_scale[1], memory.camera_ns = memory.camera_scale[0], epoch_ns


@array_law
def factor(now: float, nis: float, due: float, least: float, most: float) -> float:
    """A factor of a variance that grows while e^2 / S is on average above what is due.

    ln f <- ln f + pace (min(e^2 / S, 9) - due),   least <= f <= most
    """
    return min(max(now * math.exp(PACE * (min(max(nis, -CLIP), CLIP) - due)), least), most)
