"""Noise of the accelerometer and process noise of the motion, estimated from the accelerometer.

The vibration depends on the engine and the motion on the field; neither is on a data sheet.
"""

from __future__ import annotations

import math

import numpy as np

from estimators.kalman import Array, Record
from estimators.slip_ekf.layout import LAGS
from twin.compute.compiled import compiled

SETTLE = 100.0
"""Samples over which the variance is averaged."""
JERK_SETTLE = 500.0
"""Samples over which the density of the jerk is."""
CLIP = 9.0
"""A square counts at most as three standard deviations: an event is not noise."""


JERK_CLIP = 4.0
"""A square counts at most as two standard deviations in the density of the jerk."""


@compiled
def listen(accel: float, epoch_ns: int, floor_var: float, memory: Record) -> float:
    """Variance of the white part of an acceleration, never below the data sheet's.

    d = a_k - 2 a_k-1 + a_k-2,   E d^2 = 6 var             for white noise; motion hardly enters d
    c = a_k - a_k-10,            E c^2 = 2 var + psd tau   for white jerk

    The second gives `memory.jerk_psd`.
    """
    if memory.accel_count == 0:
        memory.accel_var = floor_var
    if memory.accel_count >= 2:
        square = (accel - 2.0 * memory.accel[0] + memory.accel[1]) ** 2 / 6.0
        gain = 1.0 / min(SETTLE, memory.accel_count + 10.0)
        if math.isfinite(square):
            limit = CLIP * max(memory.accel_var, floor_var)
            memory.accel_var += gain * (min(square, limit) - memory.accel_var)
    variance = max(memory.accel_var, floor_var)
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
    return float(variance)


@compiled
def jerk_psd(tuning: Record, memory: Record) -> float:
    """Density of the ground speed's white jerk [m2/s5]."""
    return float(max(tuning.restless * memory.jerk_psd, tuning.jerk_psd))


@compiled
def unrest(felt: bool, tuning: Record, memory: Record) -> Array:
    """Densities of the noise on a', on w'' and of both together, and how long both last.

    Under load the wheels, held by the governor, keep their speed: what makes slip grow, w s', is a
    share of what slows the ground and goes against it. With w' = a + w s',

        psd of w''  = spin jerk (1 + share^2 - 2 c share)
        together    = jerk (1 - c share)

    Only accelerations show the load. Slow motion is the driver's, who changes both speeds: without
    an accelerometer c = 0.
    """
    jerk = jerk_psd(tuning, memory)
    share, c, tau = tuning.slip_share, tuning.load_correlation, tuning.accel_tau
    if not felt:
        share, c, tau = tuning.unheard_share, 0.0, tuning.unheard_tau
    wheel = memory.spin * jerk * (1.0 + share**2 - 2.0 * c * share)
    return np.array([jerk, wheel, jerk * (1.0 - c * share), tau])
