"""Visual odometry over streams: integrates the gyros between frames, and tables the velocities."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from estimators.odometry import odometry
from estimators.odometry.lens import Array, Lens
from estimators.odometry.odometry import Motion
from twin.streams import COLUMNS, Setup, Streams, Table

KEPT = 256
"""Gyro samples that are remembered: over a second at 200 Hz, longer than any frame is late."""
HELD_S = 0.25
"""Longest time over which the last rate goes on, and over which rates are interpolated [s]."""
SLOW_S = 2.0
"""Rolling and pitching slower than this is the gyros' bias, or a turning that they see askew: no
chassis goes on rolling over its wheels. Of 8 degrees of turning a gyro 0.2 degree askew would make
0.2 mm of lateral displacement under a camera 0.5 m up [s]."""
MOST_RADPS = 5e-3
"""What a rate is off that mean by counts no further: the bias of a gyro is 0.3 degree/s at most,
and a body that drops into a furrow rolls faster, to stay so (assumed)."""
_GYRO = ("gyro_x_radps", "gyro_y_radps", "gyro_z_radps")
_SENSORS = tuple(COLUMNS)


@dataclass(frozen=True, kw_only=True)
class Gyros:
    """The last gyro samples and their integral."""

    epoch_ns: tuple[int, ...] = ()
    angle_rad: tuple[tuple[float, float, float], ...] = ()
    """Integral of the rates up to each epoch."""
    rate_radps: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """The last rates."""
    slow_radps: tuple[float, float] = (0.0, 0.0)
    """Mean rates of roll and pitch over SLOW_S."""
    seen_s: float = 0.0
    """Time that is in them."""


@dataclass(frozen=True, kw_only=True)
class State:
    """What odometry carries from chunk to chunk."""

    odometry: odometry.State
    gyros: Gyros = field(default_factory=Gyros)
    epoch_ns: int | None = None
    """The last frame; None before the first."""
    angle_rad: tuple[float, float, float] | None = None
    """The integral of the gyros at that frame; None before their first sample."""


def init(setup: Setup, method: str = "phase-ecc") -> State:
    """The state before the first sample.

    Raises:
        ValueError: the set-up has no camera, or no method has that name.
    """
    if setup.camera is None:
        raise ValueError("visual odometry needs setup.camera, the intrinsics; there is none")
    if method not in odometry.METHODS:
        known = ", ".join(odometry.METHODS)
        raise ValueError(f"no odometry method is called '{method}'; there are: {known}")
    return State(odometry=odometry.begin(Lens.of(setup.camera), method))


def run(state: State, chunk: Streams) -> tuple[State, Table]:
    """The velocities of a chunk's frames, in order of arrival.

    Gyro samples that arrived before a frame say how the body turned up to it; from the last of
    them its rate goes on. A frame that `chunk.frames` does not have is a missing one.

    Returns:
        The state after it, and a table with one row per frame: see `table`.
    """
    motions: list[Motion] = []
    gyro = np.column_stack([chunk.column("imu", name) for name in _GYRO])
    for sensor, row in zip(*chunk.merge_order(), strict=True):
        if _SENSORS[sensor] == "imu":
            epoch_ns = int(chunk["imu"]["epoch_ns"][row])
            state = replace(state, gyros=integrate(state.gyros, epoch_ns, gyro[row]))
        elif _SENSORS[sensor] == "camera":
            state, motion = _frame(state, chunk, int(row))
            motions.append(motion)
    return state, table(motions)


def _frame(state: State, chunk: Streams, row: int) -> tuple[State, Motion]:
    camera = chunk["camera"]
    epoch_ns, number = int(camera["epoch_ns"][row]), int(camera["frame"][row])
    angle, turn = angle_at(state.gyros, epoch_ns), None
    before = None if state.angle_rad is None else np.array(state.angle_rad)
    if before is None and state.epoch_ns is not None:  # gyro samples may have come since
        before = angle_at(state.gyros, state.epoch_ns)
    if state.epoch_ns is None and angle is not None:
        turn = np.zeros(3)
    elif angle is not None and before is not None:
        turn = angle - before
        assert state.epoch_ns is not None  # there was a frame before
        turn[:2] -= np.array(state.gyros.slow_radps) * (epoch_ns - state.epoch_ns) * 1e-9
    frame = None if chunk.frames is None else chunk.frames.get(number)
    after, motion = odometry.step(state.odometry, frame, epoch_ns, turn)
    kept = None if angle is None else (float(angle[0]), float(angle[1]), float(angle[2]))
    return replace(state, odometry=after, epoch_ns=epoch_ns, angle_rad=kept), motion


def integrate(gyros: Gyros, epoch_ns: int, rate_radps: Array) -> Gyros:
    """Add a sample by the trapezoidal rule; one that is NaN or not newer changes nothing.

    Over a longer gap than HELD_S nothing is integrated, and nothing before it is remembered.
    """
    if not np.all(np.isfinite(rate_radps)):
        return gyros
    rate = (float(rate_radps[0]), float(rate_radps[1]), float(rate_radps[2]))
    if not gyros.epoch_ns:
        return Gyros(epoch_ns=(epoch_ns,), angle_rad=((0.0, 0.0, 0.0),), rate_radps=rate)
    step_s = (epoch_ns - gyros.epoch_ns[-1]) * 1e-9
    if step_s <= 0.0:
        return gyros
    last = gyros.angle_rad[-1]
    if step_s > HELD_S:
        return replace(gyros, epoch_ns=(epoch_ns,), angle_rad=(last,), rate_radps=rate)
    x, y, z = (
        a + 0.5 * step_s * (r0 + r1) for a, r0, r1 in zip(last, gyros.rate_radps, rate, strict=True)
    )
    gain = step_s / min(gyros.seen_s + step_s, SLOW_S)
    roll, pitch = (
        slow + gain * min(max(r - slow, -MOST_RADPS), MOST_RADPS)
        for slow, r in zip(gyros.slow_radps, rate, strict=False)
    )
    return Gyros(
        epoch_ns=(*gyros.epoch_ns[1 - KEPT :], epoch_ns),
        angle_rad=(*gyros.angle_rad[1 - KEPT :], (x, y, z)),
        rate_radps=rate,
        slow_radps=(roll, pitch),
        seen_s=gyros.seen_s + step_s,
    )


def angle_at(gyros: Gyros, epoch_ns: int) -> Array | None:
    """The integral at an epoch: linear between samples, at the last rate after them.

    None where the last sample is older than HELD_S, or there is none.
    """
    if not gyros.epoch_ns:
        return None
    last_ns = gyros.epoch_ns[-1]
    angles = np.array(gyros.angle_rad)
    if epoch_ns >= last_ns:
        beyond_s = (epoch_ns - last_ns) * 1e-9
        return angles[-1] + np.array(gyros.rate_radps) * beyond_s if beyond_s <= HELD_S else None
    since_ns = np.array(gyros.epoch_ns) - last_ns  # small numbers, exact as floats
    return np.array([np.interp(epoch_ns - last_ns, since_ns, a) for a in angles.T])


def table(motions: list[Motion]) -> Table:
    """The motions as columns.

    epoch_ns interval_s v_x_mps v_y_mps var_x_m2ps2 var_y_m2ps2 cov_xy_m2ps2 yaw_rad scale
    tilt_ahead_rad tilt_left_rad quality used reason: as in `Motion`; the velocity is of the optical
    centre, `reason` is a `Reason`.
    """
    velocity = np.array([m.velocity_mps for m in motions]).reshape(-1, 2)
    covariance = np.array([m.covariance for m in motions]).reshape(-1, 2, 2)
    return {
        "epoch_ns": np.array([m.epoch_ns for m in motions], np.int64),
        "interval_s": np.array([m.interval_s for m in motions], float),
        "v_x_mps": velocity[:, 0],
        "v_y_mps": velocity[:, 1],
        "var_x_m2ps2": covariance[:, 0, 0],
        "var_y_m2ps2": covariance[:, 1, 1],
        "cov_xy_m2ps2": covariance[:, 0, 1],
        "yaw_rad": np.array([m.yaw_rad for m in motions], float),
        "scale": np.array([m.scale for m in motions], float),
        "tilt_ahead_rad": np.array([m.tilt_rad[0] for m in motions], float),
        "tilt_left_rad": np.array([m.tilt_rad[1] for m in motions], float),
        "quality": np.array([m.quality for m in motions], float),
        "used": np.array([m.used for m in motions], bool),
        "reason": np.array([int(m.reason) for m in motions], np.int8),
    }
