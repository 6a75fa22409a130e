"""A counter turns with the body: what it counts while the machine pitches is not rolling.

    angle = rolled angle - pitch,   pitch = integral of q, nose down

so a travel counted is short by R (pitch - pitch before). At 2 Hz and 1 deg/s that is 0.8 % of a
ploughing speed, several times what the counters themselves are off.
"""

from __future__ import annotations

from estimators.kalman import Record
from twin.compute.compiled import compiled

AHEAD_S = 0.06
"""No further ahead of the newest gyro sample is the pitch predicted."""
PITCH_PERIOD_S = 0.5
"""Step longer than this and the gyro's integral means nothing."""


@compiled
def turn(rate: float, epoch_ns: int, memory: Record) -> None:
    """Integrate a pitch rate q [rad/s], positive nose down, by the trapezoid rule."""
    dt = (epoch_ns - memory.imu_ns) * 1e-9
    if memory.imu_ns >= 0 and 0.0 < dt < PITCH_PERIOD_S:
        memory.pitch_rad += 0.5 * (memory.pitch_rate + rate) * dt
        memory.pitch_accel = (rate - memory.pitch_rate) / dt
    else:
        memory.pitch_accel = 0.0
    memory.pitch_rate = rate


@compiled
def turned(epoch_ns: int, memory: Record) -> float:
    """Pitch since the last wheel sample [rad]; the newest gyro samples are carried on to now.

    pitch(t) = pitch + q tau + dq/dt tau^2 / 2

    What is too much now is given back at the next sample.
    """
    ahead = min(max((epoch_ns - memory.imu_ns) * 1e-9, 0.0), AHEAD_S)
    if memory.imu_ns < 0:
        ahead = 0.0
    now = memory.pitch_rad + memory.pitch_rate * ahead + 0.5 * memory.pitch_accel * ahead**2
    since = now - memory.pitch_held_rad
    memory.pitch_held_rad = now
    return float(since)


@compiled
def rate_now(memory: Record) -> float:
    """Pitch rate at the newest epoch of any sensor: q + dq/dt tau; 0 without a gyro [rad/s]."""
    ahead = (memory.time_ns - memory.imu_ns) * 1e-9
    if memory.imu_ns < 0 or not 0.0 <= ahead < PITCH_PERIOD_S:
        return 0.0
    return float(memory.pitch_rate + memory.pitch_accel * min(ahead, AHEAD_S))
