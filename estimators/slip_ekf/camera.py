"""A camera's forward speed: its height is not known, and moves."""

from __future__ import annotations

import math

from estimators.kalman import Array, Record
from estimators.layout import STALE_S
from estimators.slip_ekf import rows
from estimators.slip_ekf.judge import accepted, note_speed
from estimators.slip_ekf.layout import FROM_CAMERA, FROM_GNSS, NUMBER, V
from estimators.slip_ekf.update import take
from twin.compute.compiled import array_law

CAMERA_SD = 0.005
"""sd of the quick part of a camera's relative error, as the chassis shakes."""
MOVING_MPS = 0.5
"""Above this speed a camera's scale is learnt [m/s]."""
CAMERA_SHARE, CAMERA_STEP_S, CAMERA_RATE, MOST_CAMERA = 0.03, 2.0, 0.25, 1e-3
"""Share of a frame in the mean of a second, time between two of them [s], share of one step in the
density of the walk, and the most that it does [1/s]."""


@array_law
def take_camera(signal: Record, age: float, h: Array, tuning: Record, memory: Record) -> None:
    """A camera's forward speed; its own height is not known, and moves."""
    speed = signal.v_x_mps
    if not (math.isfinite(speed) and math.isfinite(signal.v_sd_mps)):
        return
    note_speed(NUMBER[FROM_CAMERA], signal.epoch_ns, speed, memory)
    white = signal.v_sd_mps**2 + (CAMERA_SD * speed) ** 2
    _learn_walk(speed, signal.epoch_ns, tuning.camera_psd, memory)
    if not memory.known:
        waited_s = (signal.epoch_ns - memory.first_ns) * 1e-9
        if not math.isfinite(memory.first_mps) or waited_s > STALE_S:
            memory.first_mps, memory.first_ns = speed, signal.epoch_ns
            memory.first_var = white + (tuning.scale_sd * speed) ** 2
        return
    error = speed - rows.camera(memory.x, age, h)
    if accepted(NUMBER[FROM_CAMERA], h, error, white, 0.0, tuning, memory):
        take(memory, h, error, white)
        memory.measured_ns = signal.epoch_ns


@array_law
def _learn_walk(speed: float, epoch_ns: int, least: float, memory: Record) -> None:
    """Density of the walk of a camera's scale, from what GNSS and wheels make of it.

    c = speed / v - 1 over a second,   E (c_k - c_k-1)^2 = psd dt + 2 var v / v^2

    Until it is seen to be steady, a camera of unknown height measures how speed changes, and
    not how large it is.
    """
    known_enough = memory.known and memory.refused_ns[FROM_GNSS] < 0
    known_enough = (
        known_enough
        and epoch_ns - memory.seen_ns[FROM_GNSS] < 1.5e9
        and abs(memory.x[V]) > MOVING_MPS
    )
    if not known_enough:
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
            memory.camera_psd += CAMERA_RATE * (min(walked, MOST_CAMERA) - memory.camera_psd)
            memory.camera_psd = max(memory.camera_psd, least)
        memory.camera_scale[1], memory.camera_ns = memory.camera_scale[0], epoch_ns
