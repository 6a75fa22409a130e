"""The smallest error that slip and sideslip can have, given the sensors and the motion.

For a linear Gaussian model the posterior Cramer-Rao bound is the covariance of the Riccati
equation: of the filter for a causal estimator, of the smoother for one that works offline. The
model here is a vector autoregression of the motion, fitted to the truth itself. No estimator knows
a better autoregressive model of the motion.

All streams of the estimators count: GNSS, accelerometer, gyro, counters, a camera's speeds, and
the loads of the machine's bus as far as slip depends on them.

Errors that are constant over a run (radius, mounting angle, a camera's height, bias) are left out:
score the bias apart.

Source: Tichavsky, Muravchik and Nehorai 1998, IEEE Trans. SP 46, 1386.

One module, because every part serves one bound and is used nowhere else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators import riccati
from estimators.riccati import System
from twin.streams import Setup, Streams, Table

Array = NDArray[np.float64]

ORDER = 10
"""Order of the autoregression: 0.2 s at 50 Hz, the phase of a 2 Hz pitching."""
ACCEL_BIAS_PSD = 1e-8
"""A bias that is all but constant [m2/s5]."""
GYRO_BIAS_PSD = 1e-12
"""The same of a gyro [rad2/s3]."""
LOADS = ("draft_pin_n", "axle_torque_nm", "engine_load", "fuel_lph", "engine_radps", "hitch_m")
"""Columns of the machine's bus from which slip is estimated."""
EXACT = 1e-10
"""Variance of a row whose noise is a state."""
HIDDEN_PERIODS = 3.0
"""GNSS counts as hidden without a speed for this many of its periods."""


@dataclass(frozen=True, kw_only=True)
class Bound:
    """Standard deviations no unbiased estimator is better than.

    NaN where the sensors do not determine the quantity.
    """

    slip_causal: float
    """Slip, with what has arrived."""
    slip_offline: float
    """Slip, with everything there will be."""
    speed_causal_mps: float
    """Ground speed, with what has arrived."""
    sideslip_causal_rad: float
    """Sideslip angle at the rear axle, with what has arrived."""
    sideslip_offline_rad: float
    """Sideslip angle, with everything."""


def bound(
    setup: Setup,
    streams: Streams,
    truth: Table,
    window_s: tuple[float, float],
    within_s: tuple[float, float] | None = None,
) -> Bound:
    """The bounds of a run.

    Where GNSS is hidden for a time, the covariance is followed through the gap, and the bound is
    the root of its mean. Blind, an estimator still knows how far slip usually goes: the variance of
    the slip bounds it too, and the two are joined as independent knowledge, 1 / (1/a + 1/b).

    Args:
        setup: noise of the sensors by their data sheets.
        streams: which sensors there are, how late and how often. The noise of the accelerometer is
            taken from the truth, because no data sheet has the engine's vibration.
        truth: speed_mps, slip and v_y_rear_mps at a steady rate; the angles of the wheels against
            the body, if any, give the wheels' errors under changing load.
        window_s: first and last second of the motion that the model is fitted to.
        within_s: first and last second of the bound; those of `window_s` if None.

    Raises:
        ValueError: fewer than 200 samples in the window.
    """
    time = truth["epoch_ns"] * 1e-9
    inside = (time >= window_s[0]) & (time <= window_s[1])
    if inside.sum() < 20 * ORDER:
        raise ValueError(f"{inside.sum()} samples are too few for a bound; {20 * ORDER} would do")
    step_s = float(np.median(np.diff(time)))
    part = {name: column[inside] for name, column in truth.items()}
    motion = _motion(part, setup, step_s)
    along = _along(setup, streams, part, motion, step_s, truth)
    hidden = _hidden(streams, part["epoch_ns"])
    first, last = within_s or window_s
    wanted = (time[inside] >= first) & (time[inside] <= last)
    slip, speed = (_variances(along, hidden, wanted, along.at[name]) for name in ("slip", "speed"))
    mean_speed = max(float(np.mean(np.abs(part["speed_mps"]))), 0.05)
    across = _across(setup, streams, part, step_s)
    side = (np.nan, np.nan)
    if across is not None:
        side = _variances(across, hidden, wanted, across.at["v_y"])
    unseen, usual = float(np.var(motion.unseen)), float(np.var(motion.slip))
    known = [1.0 / (1.0 / each + 1.0 / usual) if hidden.any() else each for each in slip]
    return Bound(
        slip_causal=float(np.sqrt(known[0] + unseen)),
        slip_offline=float(np.sqrt(known[1] + unseen)),
        speed_causal_mps=float(np.sqrt(speed[0])),
        sideslip_causal_rad=float(np.sqrt(side[0])) / mean_speed,
        sideslip_offline_rad=float(np.sqrt(side[1])) / mean_speed,
    )


@dataclass(frozen=True, kw_only=True)
class _Model:
    system: System
    of: list[str]
    """The sensor that each row is of."""
    at: dict[str, int]
    """Index of the states whose bounds are wanted."""


def _variances(
    model: _Model, hidden: NDArray[np.bool_], wanted: NDArray[np.bool_], state: int
) -> tuple[float, float]:
    """Mean variance of a state over the wanted steps, by filter and by smoother."""
    seen = np.empty((len(hidden), len(model.of)), bool)
    for row, sensor in enumerate(model.of):
        seen[:, row] = (sensor != "gnss") | ~hidden
    causal, offline = riccati.through(model.system, seen, state)
    return float(np.mean(causal[wanted])), float(np.mean(offline[wanted]))


def _hidden(streams: Streams, epoch_ns: NDArray[np.int64]) -> NDArray[np.bool_]:
    """At which epochs GNSS has had no speed for HIDDEN_PERIODS."""
    if "gnss" not in streams or len(streams["gnss"]["epoch_ns"]) < 2:
        return np.zeros(len(epoch_ns), bool)
    gnss = streams["gnss"]
    measured = gnss["epoch_ns"][np.isfinite(streams.column("gnss", "v_east_mps"))]
    if not len(measured):
        return np.ones(len(epoch_ns), bool)
    before = np.searchsorted(measured, epoch_ns, side="right") - 1
    since = np.where(before >= 0, epoch_ns - measured[np.maximum(before, 0)], np.inf)
    return np.asarray(since > HIDDEN_PERIODS * 1e9 * _period_s(streams, "gnss"))


@dataclass(frozen=True, kw_only=True)
class _Motion:
    slip: Array
    """Slip of the wheels against the body: what counters can show."""
    unseen: Array
    """What the load does to the driven radius, in slip; no sensor shows it."""
    skid: Array
    """Relative error of the towed wheels' travel, its mean taken out."""


def _motion(part: Table, setup: Setup, step_s: float) -> _Motion:
    slip = np.asarray(part["slip"], np.float64)
    none = np.zeros_like(slip)
    angles = [f"joint_{w}_spin_rad" for w in ("fl", "fr", "rl", "rr")]
    if setup.wheels is None or any(a not in part for a in angles) or setup.driven != ("rl", "rr"):
        return _Motion(slip=slip, unseen=none, skid=none)
    rims = [
        setup.wheels.radius_m[a[6:8]] * np.gradient(np.asarray(part[a], np.float64), step_s)
        for a in angles
    ]
    front, rear = 0.5 * (rims[0] + rims[1]), 0.5 * (rims[2] + rims[3])
    speed, wheel = part["speed_mps"], part["wheel_speed_mps"]
    against_body = 1.0 - speed / np.maximum(rear, 0.05)
    turned = setup.wheels.radius_m["rl"] * _pitch_rate(part, step_s)
    unseen = slip - (1.0 - speed / np.maximum(rear + turned, 0.05))
    skid = (front + turned) / np.maximum(speed, 0.05) - 1.0
    kept = np.abs(wheel) > 0.3
    return _Motion(
        slip=against_body, unseen=_centred(unseen[kept]), skid=np.where(kept, _centred(skid), 0.0)
    )


def _pitch_rate(part: Table, step_s: float) -> Array:
    """Rate of nosing down from the attitude [rad/s]."""
    up = 2.0 * (part["qx"] * part["qz"] - part["qw"] * part["qy"])
    return np.asarray(np.gradient(-np.arcsin(np.clip(up, -1.0, 1.0)), step_s))


def _centred(values: Array) -> Array:
    return np.asarray(values - np.mean(values))


def _along(
    setup: Setup, streams: Streams, part: Table, motion: _Motion, step_s: float, truth: Table
) -> _Model:
    """The motion along the body, and what measures it.

    States: ORDER past increments of (v, s), v, s, past v, travels, accelerometer bias, skid, and
    the error of the slip that is estimated from the loads.
    """
    speed = np.asarray(part["speed_mps"], np.float64)
    late = {s: _late_steps(streams, s, step_s) for s in ("gnss", "imu", "camera")}
    past = max(late["gnss"], late["camera"], 1)
    v, s = 2 * ORDER, 2 * ORDER + 1
    rear, front, bias, skid, load = (2 * ORDER + 2 + past + i for i in range(5))
    size = load + 1
    f, q = np.zeros((size, size)), np.zeros((size, size))
    weights, noise = _autoregression(np.diff(np.stack([speed, motion.slip], 1), axis=0))
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
    mean_v, mean_s = float(np.mean(speed)), float(np.mean(motion.slip))
    ratio = 1.0 / max(1.0 - mean_s, 0.05)
    f[rear, [rear, v, s]] = 1.0, step_s * ratio, step_s * mean_v * ratio**2
    f[front, [front, v, skid]] = 1.0, step_s, step_s * mean_v
    f[bias, bias], q[bias, bias] = 1.0, ACCEL_BIAS_PSD * step_s
    f[skid, skid], q[skid, skid] = _gauss_markov(motion.skid)
    off = _off_by_load(streams, part, motion.slip)
    f[load, load], q[load, load] = _gauss_markov(off)
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
        per_step = step_s / _period_s(streams, "gnss")
        measure("gnss", {_ago(v, s, late["gnss"]): 1.0}, setup.gnss.velocity_sd_mps**2 / per_step)
    if _seen(streams, "v_x_mps") > 1:
        variance = _camera_var(streams, "var_x_m2ps2", step_s)
        measure("camera", {_ago(v, s, late["camera"]): 1.0}, variance)
    if off.any():
        measure("machine", {s: 1.0, load: 1.0}, EXACT)
    if "imu" in streams and "accel_x_mps2" in streams["imu"]:
        at = 2 * min(late["imu"], ORDER - 1)
        measure("imu", {at: 1.0 / step_s, bias: 1.0}, _accel_var(streams, truth, part))
    for state, pair in ((front, ("fl", "fr")), (rear, ("rl", "rr"))):
        variance = _travel_var(setup, streams, pair)
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
    return _Model(system=system, of=of, at={"speed": v, "slip": s})


def _ago(now: int, before: int, steps: int) -> int:
    """Index of the speed of `steps` steps ago; past speeds begin after `before`."""
    return before + steps if steps else now


def _across(setup: Setup, streams: Streams, part: Table, step_s: float) -> _Model | None:
    """The motion across the body, by GNSS, gyro and camera; None where none of them measures it.

    States: past increments of v_y, how far the heading is off the gyro's integral, and the gyro's
    bias, v_y now and before, each as many steps back as GNSS and camera are late. Without a gyro
    a past heading says nothing of the present one: its walk is as wide as a circle.
    """
    if "v_y_rear_mps" not in part:
        return None
    v_y, speed = np.asarray(part["v_y_rear_mps"], np.float64), float(np.mean(part["speed_mps"]))
    gnss = setup.gnss is not None and "heading_rad" in streams.tables.get("gnss", {})
    camera = _seen(streams, "v_y_mps") > 1
    if not gnss and not camera:
        return None
    late = {s: _late_steps(streams, s, step_s) for s in ("gnss", "camera")}
    past = max(*late.values(), 1)
    weights, noise = _autoregression(np.diff(v_y)[:, None])
    bias, off, now = ORDER, ORDER + 1, ORDER + 2 + past  # off and its past, then v_y and its past
    size = now + past + 1
    f, q = np.zeros((size, size)), np.zeros((size, size))
    f[0, :ORDER], q[0, 0] = weights[0], noise[0, 0]
    f[1:ORDER, : ORDER - 1] = np.eye(ORDER - 1)
    f[now, :ORDER], f[now, now] = weights[0], 1.0
    q[now, now] = q[0, now] = q[now, 0] = noise[0, 0]
    for first in (off, now):
        f[first + 1 : first + 1 + past, first : first + past] = np.eye(past)
    if setup.imu is not None and "gyro_z_radps" in streams.tables.get("imu", {}):
        f[off, off], f[off, bias], f[bias, bias] = 1.0, step_s, 1.0
        q[off, off] = setup.imu.gyro_noise_radps_rthz**2 * step_s
        q[bias, bias] = GYRO_BIAS_PSD * step_s
    else:
        q[off, off] = np.pi**2
    rows, variances, of = [], [], []
    if gnss and setup.gnss is not None:
        per_step, ago = step_s / _period_s(streams, "gnss"), late["gnss"]
        for at, sd in (
            ({off + ago: 1.0}, setup.gnss.heading_sd_rad),
            ({off + ago: speed, now + ago: 1.0}, setup.gnss.velocity_sd_mps),
        ):
            rows.append([at.get(i, 0.0) for i in range(size)])
            variances.append(max(sd**2 / per_step, EXACT))
            of.append("gnss")
    if camera:
        rows.append([float(i == now + late["camera"]) for i in range(size)])
        variances.append(_camera_var(streams, "var_y_m2ps2", step_s))
        of.append("camera")
    system = System(
        transition=f, process=q + np.eye(size) * 1e-14,
        rows=np.array(rows), variances=np.array(variances),
    )  # fmt: skip
    return _Model(system=system, of=of, at={"v_y": now})


def _seen(streams: Streams, column: str) -> int:
    """Number of a camera's frames with a speed."""
    if column not in streams.tables.get("camera", {}):
        return 0
    used = streams.column("camera", "used") == 1.0
    return int((used & np.isfinite(streams.column("camera", column))).sum())


def _camera_var(streams: Streams, column: str, step_s: float) -> float:
    """Variance of a camera's speed by step, with the share of frames that are used."""
    used = streams.column("camera", "used") == 1.0
    variance = streams.column("camera", column).astype(np.float64)[used]
    per_step = step_s / _period_s(streams, "camera") * float(np.mean(used))
    return max(float(np.nanmedian(variance)) / per_step, EXACT)


def _off_by_load(streams: Streams, part: Table, slip: Array) -> Array:
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
        newest = np.searchsorted(table["arrival_ns"][there], part["epoch_ns"], side="right") - 1
        known.append(each[there][np.maximum(newest, 0)])
    centred = np.stack([_centred(x) / max(float(np.std(x)), 1e-12) for x in known], 1)
    wanted = _centred(slip)
    fitted = centred @ np.linalg.lstsq(centred, wanted, rcond=1e-9)[0]
    explained = float(np.mean(fitted**2)) / max(float(np.mean(wanted**2)), 1e-18)
    return np.zeros_like(slip) if explained < 0.01 else np.asarray(fitted / explained - wanted)


def _autoregression(steps: Array) -> tuple[Array, Array]:
    """Least-squares weights of the last ORDER steps, and covariance of what they leave.

    Returns:
        weights: (m, ORDER m), newest first. residual: (m, m).
    """
    m = steps.shape[1]
    past = np.concatenate([steps[ORDER - 1 - i : len(steps) - 1 - i] for i in range(ORDER)], axis=1)
    now = steps[ORDER:]
    ridge = 1e-9 * np.eye(past.shape[1]) * max(float(np.mean(past**2)), 1e-18)
    weights = np.linalg.solve(past.T @ past + ridge * len(past), past.T @ now).T
    left = now - past @ weights.T
    return weights, left.T @ left / len(left) + np.eye(m) * 1e-16


def _gauss_markov(values: Array) -> tuple[float, float]:
    """Step-to-step factor and noise variance of a first-order process like these values."""
    variance = float(np.var(values))
    if variance <= 0.0:
        return 0.0, 0.0
    factor = float(np.mean(values[1:] * values[:-1]) / variance)
    factor = min(max(factor, 0.0), 0.99999)
    return factor, variance * (1.0 - factor**2)


def _late_steps(streams: Streams, sensor: str, step_s: float) -> int:
    """By how many steps a sample arrives later than the wheels' of the same epoch."""
    if sensor not in streams or not len(streams[sensor]["epoch_ns"]):
        return 0
    late = np.median(streams[sensor]["arrival_ns"] - streams[sensor]["epoch_ns"]) * 1e-9
    return int(np.floor(float(late) / step_s))


def _period_s(streams: Streams, sensor: str) -> float:
    return float(np.median(np.diff(streams[sensor]["epoch_ns"]))) * 1e-9


def _travel_var(setup: Setup, streams: Streams, pair: tuple[str, str]) -> float:
    """Variance of the mean travel two counters show, rounding alone: (2 pi R / N)^2 / 24."""
    table = streams.tables.get("wheels", {})
    counted = [w for w in pair if f"ticks_{w}" in table]
    if not counted or setup.wheels is None or not setup.wheels.counts_per_turn:
        return np.nan
    per_tick = 2.0 * np.pi * setup.wheels.radius_m[counted[0]] / setup.wheels.counts_per_turn
    return float(per_tick**2 / 12.0 / len(counted))


def _accel_var(streams: Streams, truth: Table, part: Table) -> float:
    """White part of what the accelerometer is off by: E (e_k - 2 e_k-1 + e_k-2)^2 / 6."""
    imu = streams["imu"]
    start = truth["epoch_ns"][0]
    time = (truth["epoch_ns"] - start) * 1e-9
    at = (imu["epoch_ns"] - start) * 1e-9
    motion = np.interp(at, time, np.gradient(np.asarray(truth["speed_mps"], np.float64), time))
    first, last = (part["epoch_ns"][i] for i in (0, -1))
    inside = (imu["epoch_ns"] >= first) & (imu["epoch_ns"] <= last)
    error = (np.asarray(imu["accel_x_mps2"], np.float64) - motion)[inside]
    second = error[2:] - 2.0 * error[1:-1] + error[:-2]
    return max(float(np.nanmean(second**2)) / 6.0, 1e-8)
