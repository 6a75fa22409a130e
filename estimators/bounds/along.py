"""The motion along the body, and what measures it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.bounds.model import Model
from estimators.bounds.motion import ORDER, Motion, autoregression, centred, first_order
from estimators.bounds.noises import (
    EXACT,
    accel_var,
    camera_var,
    frames_seen,
    late_steps,
    period_s,
    travel_var,
)
from estimators.riccati import System
from twin.streams import Setup, Streams, Table

Array = NDArray[np.float64]

ACCEL_BIAS_PSD = 1e-8
"""A bias that is all but constant [m2/s5]."""
LOADS = ("draft_pin_n", "axle_torque_nm", "engine_load", "fuel_lph", "engine_radps", "hitch_m")
"""Columns of the machine's bus from which slip is estimated."""


def along_body(
    setup: Setup, streams: Streams, part: Table, motion: Motion, step_s: float, truth: Table
) -> Model:
    """The motion along the body, and what measures it.

    States: ORDER past increments of (v, s), v, s, past v, travels, accelerometer bias, skid, the
    whole slip, and the error of the slip that is estimated from the loads. Skid, the whole slip
    less s, and the error of the loads' slip all follow the load: they are one vector process.
    """
    speed, drives = np.asarray(part["speed_mps"], np.float64), motion.drives
    late = {s: late_steps(streams, s, step_s) for s in ("gnss", "imu", "camera")}
    past = max(late["gnss"], late["camera"], 1)
    v, s = 2 * ORDER, 2 * ORDER + 1
    rear, front, bias, skid, unseen, load = (2 * ORDER + 2 + past + i for i in range(6))
    size = load + 1
    f, q = np.zeros((size, size)), np.zeros((size, size))
    weights, noise = autoregression(np.diff(np.stack([speed, motion.slip], 1), axis=0), drives)
    f[:2, : 2 * ORDER], q[:2, :2] = weights, noise
    f[2 : 2 * ORDER, : 2 * ORDER - 2] = np.eye(2 * ORDER - 2)
    for state, increment in ((v, 0), (s, 1)):
        f[state, : 2 * ORDER] = weights[increment]
        f[state, state] = 1.0
        for other, j in ((v, 0), (s, 1)):
            q[state, other] = noise[increment, j]
        q[state, :2] = q[:2, state] = noise[increment]
    f[s + 1, v] = 1.0
    f[s + 2 : s + 1 + past, s + 1 : s + past] = np.eye(past - 1)
    mean_v, mean_s = float(np.mean(np.abs(speed[drives]))), float(np.mean(motion.slip[drives]))
    ratio = 1.0 / max(1.0 - mean_s, 0.05)
    f[rear, [rear, v, s]] = 1.0, step_s * ratio, step_s * mean_v * ratio**2
    f[front, [front, v, skid]] = 1.0, step_s, step_s * mean_v
    f[bias, bias], q[bias, bias] = 1.0, ACCEL_BIAS_PSD * step_s
    off = np.zeros_like(speed)
    off[drives] = _off_by_load(streams, part["epoch_ns"][drives], motion.slip[drives])
    errors = np.stack([motion.skid, motion.unseen, off], 1)
    of_errors = slice(skid, load + 1)
    f[of_errors, of_errors], q[of_errors, of_errors] = first_order(errors, motion.counted)
    q += np.eye(size) * 1e-14
    rows, variances, of = [], [], []

    def measure(sensor: str, at: dict[int, float], variance: float) -> None:
        row = np.zeros(size)
        for state, weight in at.items():
            row[state] = weight
        rows.append(row)
        variances.append(variance)
        of.append(sensor)

    if setup.gnss is not None and "gnss" in streams and len(streams["gnss"]["epoch_ns"]):
        per_step = step_s / period_s(streams, "gnss")
        measure("gnss", {_ago(v, s, late["gnss"]): 1.0}, setup.gnss.velocity_sd_mps**2 / per_step)
    if frames_seen(streams, "v_x_mps") > 1:
        variance = camera_var(streams, "var_x_m2ps2", step_s)
        measure("camera", {_ago(v, s, late["camera"]): 1.0}, variance)
    if off.any():
        measure("machine", {s: 1.0, load: 1.0}, EXACT)
    if "imu" in streams and "accel_x_mps2" in streams["imu"]:
        at = 2 * min(late["imu"], ORDER - 1)
        measure("imu", {at: 1.0 / step_s, bias: 1.0}, accel_var(streams, truth, part))
    for state, pair in ((front, ("fl", "fr")), (rear, ("rl", "rr"))):
        variance = travel_var(setup, streams, pair)
        if np.isfinite(variance):
            measure("wheels", {state: 1.0}, variance)
        elif f"speed_{pair[0]}_mps" in streams.tables.get("wheels", {}):
            sd = float(np.nanmedian(streams.column("wheels", "speed_sd_mps")))
            sd = sd if np.isfinite(sd) else 0.05
            scale = {v: 1.0, skid: mean_v} if state == front else {v: ratio, s: mean_v * ratio**2}
            measure("wheels", scale, sd**2)
    system = System(
        transition=f, process=q, rows=np.reshape(rows, (-1, size)), variances=np.array(variances)
    )
    if not motion.unseen.any():
        return Model(system=system, of=of, at={"speed": v, "slip": s})
    return Model(system=_summed(system, unseen, s), of=of, at={"speed": v, "slip": unseen})


def _summed(system: System, state: int, other: int) -> System:
    """The same system with the sum of two states in the place of the first."""
    to_sum, back = np.eye(len(system.transition)), np.eye(len(system.transition))
    to_sum[state, other], back[state, other] = 1.0, -1.0
    return System(
        transition=to_sum @ system.transition @ back,
        process=to_sum @ system.process @ to_sum.T,
        rows=system.rows @ back,
        variances=system.variances,
    )


def _ago(now: int, before: int, steps: int) -> int:
    """Index of the speed of `steps` steps ago; past speeds begin after `before`."""
    return before + steps if steps else now


def _off_by_load(streams: Streams, epoch_ns: NDArray[np.int64], slip: Array) -> Array:
    """Error of the least-squares estimate of slip from the loads; zeros without loads.

    u = c . (1, loads) fitted to the slip explains a share r2 of its variance. Then u / r2 is the
    slip and an error that is independent of it.
    """
    table = streams.tables.get("machine", {})
    loads = [table[name].astype(np.float64) for name in LOADS if name in table]
    loads = [each for each in loads if np.isfinite(each).sum() > ORDER]
    if not loads:
        return np.zeros_like(slip)
    known = []
    for each in loads:  # held from its arrival on
        there = np.isfinite(each)
        newest = np.searchsorted(table["arrival_ns"][there], epoch_ns, side="right") - 1
        known.append(each[there][np.maximum(newest, 0)])
    alike = np.stack([centred(x) / max(float(np.std(x)), 1e-12) for x in known], 1)
    wanted = centred(slip)
    fitted = alike @ np.linalg.lstsq(alike, wanted, rcond=1e-9)[0]
    explained = float(np.mean(fitted**2)) / max(float(np.mean(wanted**2)), 1e-18)
    return np.zeros_like(slip) if explained < 0.01 else np.asarray(fitted / explained - wanted)
