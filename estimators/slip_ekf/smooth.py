"""The offline smoother: slip-ekf forward, then Rauch, Tung and Striebel's smoother backward.

It sees the whole log, so it is not causal, and what it says depends on where the log was cut.

Source: Rauch, Tung and Striebel 1965, AIAA Journal 3, 1445.

One module, because the backward pass undoes what the forward pass keeps.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from estimators import signals
from estimators.estimate import SLOW_MPS
from estimators.kalman import Array, Record
from estimators.layout import GNSS, OUT_OF_ORDER
from estimators.slip_ekf import SLIP_EKF, SlipEkf, State, model
from estimators.slip_ekf.driven import radius
from estimators.slip_ekf.filter import advance, measure
from estimators.slip_ekf.layout import QUICK_RADIUS, RADIUS, REAR_TRAVEL, SIZE, USUAL, V, W
from estimators.slip_ekf.raised import USED, lifted
from twin.compute.compiled import compiled
from twin.streams import Setup, Streams, Table

NUDGE = 1e-5
"""Half-width of the central difference that gives the transition."""


@dataclass(frozen=True, kw_only=True)
class SlipEkfSmooth:
    """Slip, speeds and sideslip with everything there is before and after.

    Give it the whole log.
    """

    filter: SlipEkf = SLIP_EKF
    """The filter it runs forward."""

    offline = True
    """Neither causal nor the same for every cutting into chunks."""

    def init(self, setup: Setup) -> State:
        """The filter's state before the first sample."""
        return self.filter.init(setup)

    def run(self, state: State, chunk: Streams) -> tuple[State, Table]:
        """The filter's state after the chunk, and its estimates smoothed over the whole chunk.

        The rows are those of the filter.
        """
        after, table = self.filter.run(state, chunk)
        if not len(table["epoch_ns"]):
            return after, table
        reader, samples = signals.read(state.reader, chunk, USED)
        _, raised = lifted(state.lift, chunk)
        memory, steps = state.memory.copy(), len(samples) + 1
        track = Track(
            epoch_ns=np.full(steps, -1, np.int64),
            before=np.zeros((steps, SIZE)),
            before_cov=np.zeros((steps, SIZE, SIZE)),
            after=np.zeros((steps, SIZE)),
            after_cov=np.zeros((steps, SIZE, SIZE)),
            shift=np.zeros((steps, SIZE)),
            cut=np.ones((steps, SIZE), np.int64),
            rim=np.zeros(steps),
            forgotten_s=np.ones(steps),
        )
        nominal, tuning = reader.nominal[0], state.tuning[0]
        count = _forward(samples, raised, nominal, tuning, memory[0], *track.arrays())
        _backward(count, tuning, *track.arrays())
        return after, _estimates(table, track, count, chunk, samples, reader.nominal[0], tuning)


@dataclass(frozen=True, kw_only=True)
class Track:
    """The filter at every instant.

    Predicted (`before`) and with all that was measured (`after`).
    """

    epoch_ns: np.ndarray[Any, np.dtype[np.int64]]
    before: Array
    before_cov: Array
    after: Array
    after_cov: Array
    shift: Array
    cut: np.ndarray[Any, np.dtype[np.int64]]
    rim: Array
    forgotten_s: Array

    def arrays(self) -> tuple[Any, ...]:
        """In the order compiled code takes them."""
        return (
            self.epoch_ns,
            self.before,
            self.before_cov,
            self.after,
            self.after_cov,
            self.shift,
            self.cut,
            self.rim,
            self.forgotten_s,
        )


@compiled
def _forward(
    samples: Any,
    raised: Array,
    nominal: Record,
    tuning: Record,
    memory: Record,
    epoch_ns: Any,
    before: Array,
    before_cov: Array,
    after: Array,
    after_cov: Array,
    shift: Array,
    cut: Any,
    rim: Array,
    forgotten_s: Array,
) -> int:
    """Run the filter and keep it at every instant; returns how many there were."""
    n, known_at = -1, 0
    h, predicted = np.zeros(SIZE), np.zeros((SIZE, SIZE))
    for i in range(len(samples)):
        signal = samples[i]
        if signal.flags & OUT_OF_ORDER:
            continue
        was_ns = memory.time_ns
        advance(signal.epoch_ns, nominal, tuning, memory)
        if memory.time_ns > was_ns or n < 0:
            n += 1
            epoch_ns[n] = memory.time_ns
            before[n], before_cov[n] = memory.x, memory.cov
            predicted[:, :] = memory.cov
            known_at = memory.known
        measure(signal, raised[i], h, nominal, tuning, memory)
        after[n], after_cov[n], rim[n] = memory.x, memory.cov, memory.rim_mps
        forgotten_s[n] = memory.forgotten_s
        if known_at and memory.known:
            shift[n], cut[n] = memory.shift, memory.cut
            # what grew the covariance within an instant belongs to its prediction
            before_cov[n] = predicted + memory.grown
    return n + 1


@compiled
def _transition(x: Array, rim: float, forgotten_s: float, dt: float, tuning: Record) -> Array:
    """d carry(x) / dx by central differences, (SIZE, SIZE); what goes with `rim`, as forwards."""
    f, unused = np.zeros((SIZE, SIZE)), np.zeros((SIZE, SIZE))
    restless = np.array([0.0, 0.0, 0.0, forgotten_s])
    for j in range(SIZE):
        up, down = x.copy(), x.copy()
        up[j] += NUDGE
        down[j] -= NUDGE
        model.carry(up, unused, rim, restless, dt, tuning)
        model.carry(down, unused, rim, restless, dt, tuning)
        f[:, j] = (up - down) / (2.0 * NUDGE)
    f[REAR_TRAVEL, RADIUS] = f[REAR_TRAVEL, QUICK_RADIUS] = dt * rim
    f[W, USUAL] = dt / tuning.usual_tau * rim * model.gearing(x[USUAL])
    return f


@compiled
def _backward(
    n: int,
    tuning: Record,
    epoch_ns: Any,
    before: Array,
    before_cov: Array,
    after: Array,
    after_cov: Array,
    shift: Array,
    cut: Any,
    rim: Array,
    forgotten_s: Array,
) -> None:
    """x_k <- x_k + G (x_k+1 - x-_k+1),  P_k <- P_k + G (P_k+1 - P-_k+1) G^T, in place.

    G = P_k F^T (P-_k+1)^-1

    Where a state began anew at k+1, nothing of it goes back.
    """
    for k in range(n - 2, -1, -1):
        dt = (epoch_ns[k + 1] - epoch_ns[k]) * 1e-9
        if cut[k + 1].all():
            continue
        f = _transition(after[k], rim[k], forgotten_s[k + 1], dt, tuning)
        # a covariance of lengths, speeds and ratios: scaled to ones on its diagonal
        scale = np.sqrt(np.maximum(np.diag(before_cov[k + 1]), 1e-18))
        scaled = before_cov[k + 1] / np.outer(scale, scale) + 1e-9 * np.eye(SIZE)
        gain = np.linalg.solve(scaled, (f @ after_cov[k]) / scale.reshape(-1, 1)).T
        gain = gain / scale.reshape(1, -1)
        moved = after[k + 1] - shift[k + 1] - before[k + 1]
        change = after_cov[k + 1] - before_cov[k + 1]
        for i in range(SIZE):
            if cut[k + 1, i]:
                moved[i] = 0.0
                change[i, :] = 0.0
                change[:, i] = 0.0
        after[k] += gain @ moved
        smoothed = after_cov[k] + gain @ change @ gain.T
        after_cov[k] = 0.5 * (smoothed + smoothed.T)


def _estimates(
    table: Table,
    track: Track,
    count: int,
    chunk: Streams,
    samples: Any,
    nominal: Any,
    tuning: Any,
) -> Table:
    """The filter's table with the smoothed values in their places."""
    at = np.searchsorted(track.epoch_ns[:count], table["epoch_ns"])
    known = np.isfinite(table["slip"])
    speed = track.after[at, V]
    pitching = radius(nominal, 1.0) * _pitch_rate(chunk, table["epoch_ns"])
    rim = np.array([model.rim_speed(track.after[k], track.rim[k]) for k in at]) + pitching
    variance = np.array(
        [
            model.slip_var(track.after_cov[k], v, w, track.rim[k], SLOW_MPS)
            for k, v, w in zip(at, speed, rim, strict=True)
        ]
    )
    slip = (rim - speed) / np.maximum(np.maximum(np.abs(rim), np.abs(speed)), SLOW_MPS)
    v_y, v_y_var = _across(samples, table["epoch_ns"], float(tuning["v_y_psd"]))
    yaw_rate = (table["v_y_mps"] - _forward_v_y(table)) / max(float(nominal["cg_x_m"]), 1e-9)
    v_y_cg = v_y + float(nominal["cg_x_m"]) * yaw_rate
    fast, moving = np.abs(speed) >= SLOW_MPS, np.maximum(np.abs(speed), SLOW_MPS)
    mount = float(tuning["mount_sd"])
    found = {
        "speed_mps": speed,
        "wheel_speed_mps": rim,
        "slip": slip,
        "slip_sd": np.sqrt(variance),
    }
    across = {
        "v_y_mps": v_y_cg,
        "sideslip_rad": np.where(fast, np.arctan2(v_y_cg, speed), np.nan),
        "sideslip_rear_rad": np.where(fast, np.arctan2(v_y, speed), np.nan),
        "sideslip_sd_rad": np.where(fast, np.hypot(np.sqrt(v_y_var) / moving, mount), np.nan),
    }
    seen = known & np.isfinite(table["v_y_mps"]) & np.isfinite(v_y_cg)
    smoothed = dict(table)
    for columns, rows in ((found, known), (across, seen)):
        for name, values in columns.items():
            smoothed[name] = np.where(rows, values, table[name])
    return smoothed


def _forward_v_y(table: Table) -> Array:
    """v_y at the rear axle as the filter had it: speed tan(sideslip)."""
    return np.asarray(table["speed_mps"] * np.tan(table["sideslip_rear_rad"]))


def _pitch_rate(chunk: Streams, epoch_ns: np.ndarray[Any, np.dtype[np.int64]]) -> Array:
    """Pitch rate without the gyro's bias at given epochs [rad/s]; 0 without a gyro."""
    if "imu" not in chunk:
        return np.zeros(len(epoch_ns))
    rate = chunk.column("imu", "gyro_y_radps")
    own_ns = chunk["imu"]["epoch_ns"]
    newest = np.maximum.accumulate(np.concatenate([[-1], own_ns[:-1]]))
    kept = np.isfinite(rate) & (own_ns > newest)
    if kept.sum() < 2:
        return np.zeros(len(epoch_ns))
    start = epoch_ns[0]
    at, own = (epoch_ns - start) * 1e-9, (own_ns[kept] - start) * 1e-9
    return np.asarray(np.interp(at, own, rate[kept] - np.mean(rate[kept])))


def _across(
    samples: Any, epoch_ns: np.ndarray[Any, np.dtype[np.int64]], psd: float
) -> tuple[Array, Array]:
    """Smoothed random walk of v_y at given epochs, and its variance; NaN where there is none."""
    used = samples[(samples["sensor"] == GNSS) & np.isfinite(samples["v_x_mps"])]
    used = used[np.isfinite(used["v_y_held_mps"]) & (used["v_y_held_sd_mps"] > 0.0)]
    if len(used) < 2:
        return np.full(len(epoch_ns), np.nan), np.full(len(epoch_ns), np.nan)
    mean, variance = _walk(
        (used["epoch_ns"] - used["epoch_ns"][0]) * 1e-9,
        used["v_y_held_mps"].copy(),
        used["v_y_held_sd_mps"] ** 2,
        psd,
    )
    at = (epoch_ns - used["epoch_ns"][0]) * 1e-9
    own = (used["epoch_ns"] - used["epoch_ns"][0]) * 1e-9
    return np.interp(at, own, mean), np.interp(at, own, variance)


@compiled
def _walk(time: Array, measured: Array, noise: Array, psd: float) -> tuple[Array, Array]:
    """Filter and smooth a random walk."""
    n = len(time)
    mean, variance = np.zeros(n), np.zeros(n)
    mean[0], variance[0] = measured[0], noise[0]
    for k in range(1, n):
        predicted = variance[k - 1] + psd * (time[k] - time[k - 1])
        error, total = measured[k] - mean[k - 1], predicted + noise[k]
        gain = predicted / total if error * error < 12.0 * total else 0.0
        mean[k], variance[k] = mean[k - 1] + gain * error, predicted * (1.0 - gain)
    for k in range(n - 2, -1, -1):
        predicted = variance[k] + psd * (time[k + 1] - time[k])
        gain = variance[k] / predicted
        mean[k] += gain * (mean[k + 1] - mean[k])
        variance[k] += gain * gain * (variance[k + 1] - predicted)
    return mean, variance


SLIP_EKF_SMOOTH = SlipEkfSmooth()
"""Rauch-Tung-Striebel smoother of slip-ekf: it needs the whole log."""
