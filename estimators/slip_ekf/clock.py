"""A clock that is set back: what it repeats is time that has passed.

Samples whose stamps are no newer than their sensor's last are left out. While a clock repeats them
no stamp is new, though time passes: by as much as the stamps of a sensor run, if they run up to the
newest. Samples that come late or again do not.
"""

from __future__ import annotations

from estimators.kalman import Record
from estimators.slip_ekf.layout import LAGS, SOURCES
from twin.compute.compiled import array_law

NEAR_STEPS = 2.0
"""Stamps that run up to so many of their own steps before the newest go on beyond it."""


@array_law
def note_out_of_order(signal: Record, memory: Record) -> None:
    """A sample is out of order: it goes on with those of its sensor, or begins anew."""
    sensor, epoch_ns = signal.sensor, signal.epoch_ns
    if memory.again_count[sensor] == 0 or epoch_ns <= memory.again_ns[sensor, 1]:
        memory.again_count[sensor] = 0
        memory.again_ns[sensor, 0] = epoch_ns
    memory.again_ns[sensor, 1] = epoch_ns
    memory.again_count[sensor] += 1


@array_law
def catch_up(memory: Record) -> None:
    """Before a new epoch: move all stamps of the past back by the time that passed unseen.

    Every time difference is true again. So the prediction spans the time that was missed, and its
    covariance grows as over a gap.
    """
    by = 0
    for sensor in range(len(memory.again_count)):
        steps = memory.again_count[sensor] - 1
        if steps > 0:
            first_ns, last_ns = memory.again_ns[sensor]
            if memory.time_ns - last_ns < NEAR_STEPS * (last_ns - first_ns) / steps:
                by = max(by, last_ns - first_ns)
    memory.again_count[:] = 0
    if by == 0:
        return
    for source in range(SOURCES):
        memory.seen_ns[source] -= by
        memory.refused_ns[source] -= by
        memory.white_ns[source] -= by
    for i in range(LAGS):
        memory.accel_ns[i] -= by
    memory.time_ns -= by
    memory.measured_ns -= by
    memory.first_ns -= by
    memory.wheels_ns -= by
    memory.imu_ns -= by
    memory.changed_ns -= by
    memory.mean_innovation_ns -= by
    memory.camera_ns -= by
