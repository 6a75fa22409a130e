"""The offline smoother: slip-ekf forward, then Rauch, Tung and Striebel's smoother backward.

It sees the whole log, so it is not causal, and its estimates depend on where the log is cut.

Source: Rauch, Tung and Striebel 1965, AIAA Journal 3, 1445.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators import signals
from estimators.estimate import SLOW_MPS
from estimators.kalman import Array, Record
from estimators.layout import OUT_OF_ORDER
from estimators.slip_ekf import SLIP_EKF, SlipEkf, State, motion
from estimators.slip_ekf.clock import catch_up, note_out_of_order
from estimators.slip_ekf.filter import advance, measure
from estimators.slip_ekf.held import USED, held
from estimators.slip_ekf.jerk import fading_s
from estimators.slip_ekf.layout import SIZE, V_Y, V
from estimators.slip_ekf.report import MOUNT_SD_RAD, slip
from twin.compute.compiled import array_law
from twin.streams import Setup, Streams, Table

GIVEN, RIM = 5, 4
"""What the transition to an instant needs beside the state, and the averaged rim speed then."""


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
        _, slow = held(state.held, chunk)
        memory, steps = state.memory.copy(), len(samples) + 1
        memory["keeps"] = 1
        nominal, tuning = reader.nominal[0], state.tuning[0]
        epoch_ns = np.full(steps, -1, np.int64)
        before, mean = np.zeros((steps, SIZE)), np.zeros((steps, SIZE))
        before_cov, cov = np.zeros((steps, SIZE, SIZE)), np.zeros((steps, SIZE, SIZE))
        cut, given = np.ones((steps, SIZE), np.int64), np.zeros((steps, GIVEN))
        count = _forward(
            samples, slow, nominal, tuning, memory[0], epoch_ns, before, before_cov, mean, cov,
            cut, given,
        )  # fmt: skip
        at = np.searchsorted(epoch_ns[:count], table["epoch_ns"])
        rim = given[at, RIM]
        # the body's pitching now, which is part of the estimate and not of the state
        turned = table["wheel_speed_mps"] - _slips(mean[at], cov[at], rim, np.zeros(len(rim)))[0]
        _backward(count, tuning, before, before_cov, mean, cov, cut, given)
        return after, _estimates(table, mean[at], cov[at], rim, np.nan_to_num(turned))


@array_law
def _forward(
    samples: Any, slow: Array, nominal: Record, tuning: Record, memory: Record,
    epoch_ns: NDArray[np.int64], before: Array, before_cov: Array, mean: Array, cov: Array,
    cut: NDArray[np.int64], given: Array,
) -> int:  # fmt: skip
    """Run the filter and keep it at every instant; returns how many there were.

    `before` is the prediction with all that has changed it since but measurements, `given` what
    the transition to there needs: rim speed, turning of the front axle, fading time and step; then
    the rim speed after it.
    """
    n, known = -1, 0
    h, first, first_cov = np.zeros(SIZE), np.zeros(SIZE), np.zeros((SIZE, SIZE))
    f, q, scratch = np.zeros((SIZE, SIZE)), np.zeros((SIZE, SIZE)), np.zeros((SIZE, SIZE))
    for i in range(len(samples)):
        signal = samples[i]
        if signal.flags & OUT_OF_ORDER:
            note_out_of_order(signal, memory)
            continue
        if signal.epoch_ns > memory.time_ns:
            catch_up(memory)
        was_ns = memory.time_ns
        rim, turn = memory.rim_mps, nominal.wheelbase_m * memory.yaw_rate
        fading = fading_s(tuning, memory)
        advance(signal.epoch_ns, nominal, tuning, memory, f, q, scratch)
        if memory.time_ns > was_ns or n < 0:
            n += 1
            epoch_ns[n], known = memory.time_ns, memory.known
            given[n, 0], given[n, 1], given[n, 2] = rim, turn, fading
            given[n, 3] = (memory.time_ns - was_ns) * 1e-9
            first[:] = memory.x
            first_cov[:, :] = memory.p
        measure(signal, slow[i], h, nominal, tuning, memory)
        given[n, RIM] = memory.rim_mps
        mean[n, :] = memory.x
        cov[n, :, :] = memory.p
        if known and memory.known:
            for j in range(SIZE):
                cut[n, j] = memory.cut[j]
            for j in range(SIZE):
                whole = cut[n, j] == 0
                before[n, j] = memory.x[j] - memory.gained[j] if whole else first[j]
                for k in range(SIZE):
                    grown = memory.p[j, k] + memory.lost[j, k]
                    before_cov[n, j, k] = grown if whole and cut[n, k] == 0 else first_cov[j, k]
    return n + 1


@array_law
def _backward(
    n: int, tuning: Record, before: Array, before_cov: Array, mean: Array, cov: Array,
    cut: NDArray[np.int64], given: Array,
) -> None:  # fmt: skip
    """x_k <- x_k + G (x_k+1 - x-_k+1),  P_k <- P_k + G (P_k+1 - P-_k+1) G^T, in place.

    G = P_k F^T (P-_k+1)^-1

    A state that began anew at k+1 stands apart from the others there: nothing of it goes back.
    """
    f, x, ahead = np.zeros((SIZE, SIZE)), np.zeros(SIZE), np.zeros((SIZE, SIZE))
    for k in range(n - 2, -1, -1):
        whole = 0
        for i in range(SIZE):
            whole += 1 - cut[k + 1, i]
        if whole == 0:
            continue
        x[:] = mean[k]
        g = given[k + 1]
        motion.step(x, g[0], g[1], g[2], g[3], tuning, f)
        # a covariance of lengths, speeds and ratios: scaled to ones on its diagonal
        scale = np.sqrt(np.maximum(np.diag(before_cov[k + 1]), 1e-18))
        scaled = before_cov[k + 1] / np.outer(scale, scale) + 1e-9 * np.eye(SIZE)
        ahead[:, :] = (f @ cov[k]) / scale.reshape(-1, 1)
        for i in range(SIZE):
            if cut[k + 1, i]:
                scaled[i, :] = scaled[:, i] = ahead[i, :] = 0.0
                scaled[i, i] = 1.0
        gain = np.linalg.solve(scaled, ahead).T
        gain = np.ascontiguousarray(gain / scale.reshape(1, -1))
        moved = mean[k + 1] - before[k + 1]
        change = cov[k + 1] - before_cov[k + 1]
        for i in range(SIZE):
            if cut[k + 1, i]:
                moved[i] = 0.0
                change[i, :] = 0.0
                change[:, i] = 0.0
        mean[k] += gain @ moved
        smoothed = cov[k] + gain @ change @ np.ascontiguousarray(gain.T)
        cov[k] = 0.5 * (smoothed + smoothed.T)


@array_law
def _slips(mean: Array, cov: Array, rim: Array, turned: Array) -> Array:
    """Speed of the driven wheels [m/s], slip and its sd of each row, (3, n); see `report.slip`."""
    found, h = np.empty((3, len(mean))), np.zeros(SIZE)
    for i in range(len(mean)):
        found[0, i], found[1, i], found[2, i] = slip(mean[i], cov[i], rim[i], turned[i], h)
    return found


def _estimates(table: Table, mean: Array, cov: Array, rim: Array, turned: Array) -> Table:
    """The filter's table with the smoothed values in their places.

    Args:
        table: the filter's.
        mean, cov, rim: smoothed state, its covariance, and the averaged rim speed of each row.
        turned: what pitching adds to the wheels' speed over the ground [m/s].
    """
    known = np.isfinite(table["slip"])
    speed = mean[:, V]
    wheel, slips, sd = _slips(mean, cov, rim, turned)
    v_y = mean[:, V_Y]
    turning = table["v_y_mps"] - table["speed_mps"] * np.tan(table["sideslip_rear_rad"])
    v_y_cg = v_y + np.nan_to_num(turning)
    fast, moving = np.abs(speed) >= SLOW_MPS, np.maximum(np.abs(speed), SLOW_MPS)
    across_sd = np.hypot(np.sqrt(np.maximum(cov[:, V_Y, V_Y], 0.0)) / moving, MOUNT_SD_RAD)
    found = {
        "speed_mps": speed,
        "wheel_speed_mps": wheel,
        "slip": slips,
        "slip_sd": sd,
    }
    across = {
        "v_y_mps": v_y_cg,
        "sideslip_rad": np.where(fast, np.arctan2(v_y_cg, speed), np.nan),
        "sideslip_rear_rad": np.where(fast, np.arctan2(v_y, speed), np.nan),
        "sideslip_sd_rad": np.where(fast, across_sd, np.nan),
    }
    seen = known & np.isfinite(table["v_y_mps"])
    smoothed = dict(table)
    for columns, rows in ((found, known), (across, seen)):
        for name, values in columns.items():
            smoothed[name] = np.where(rows, values, table[name])
    return smoothed


SLIP_EKF_SMOOTH = SlipEkfSmooth()
"""Rauch-Tung-Striebel smoother of slip-ekf: it needs the whole log."""
