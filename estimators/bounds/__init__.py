"""The smallest error that slip and sideslip can have, given the sensors and the motion.

For a linear Gaussian model the posterior Cramer-Rao bound is the covariance of the Riccati
equation: of the filter for a causal estimator, of the smoother for one that works offline. The
model here is a vector autoregression of the motion, fitted to the truth itself. No estimator knows
a better autoregressive model of the motion.

All streams of the estimators count: GNSS, accelerometer, gyro, counters, a camera's speeds, and
the loads of the machine's bus as far as slip depends on them.

Only the time in which the tractor drives counts, as in the scores: at a stand slip and angle are
ratios of two noises.

Errors that are constant over a run (radius, mounting angle, a camera's height, bias) are left out:
score the bias apart. The bound of a total sideslip, which is hardly anything else, has them
(`total_sd_m`).

Source: Tichavsky, Muravchik and Nehorai 1998, IEEE Trans. SP 46, 1386.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from estimators.bounds.across import across_body
from estimators.bounds.along import along_body
from estimators.bounds.model import variances
from estimators.bounds.motion import ORDER, drives_at, motion_of
from estimators.bounds.noises import hidden_at
from estimators.bounds.total import total_sd_m
from twin.streams import Setup, Streams, Table

__all__ = ["Bound", "bound", "total_sd_m"]


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
        ValueError: fewer than 200 samples of driving in the window.
    """
    time = truth["epoch_ns"] * 1e-9
    inside = (time >= window_s[0]) & (time <= window_s[1])
    part = {name: column[inside] for name, column in truth.items()}
    drives = drives_at(part)
    if drives.sum() < 20 * ORDER:
        raise ValueError(f"{drives.sum()} samples are too few for a bound; {20 * ORDER} would do")
    step_s = float(np.median(np.diff(time)))
    motion = motion_of(part, setup, step_s, drives)
    along = along_body(setup, streams, part, motion, step_s, truth)
    hidden = hidden_at(streams, part["epoch_ns"])
    first, last = within_s or window_s
    wanted = (time[inside] >= first) & (time[inside] <= last) & drives
    slip, speed = (variances(along, hidden, wanted, along.at[name]) for name in ("slip", "speed"))
    mean_speed = max(float(np.mean(np.abs(part["speed_mps"][drives]))), 0.05)
    across = across_body(setup, streams, part, step_s, drives)
    side = (np.nan, np.nan)
    if across is not None:
        side = variances(across, hidden, wanted, across.at["v_y"])
    usual = float(np.var((motion.slip + motion.unseen)[drives]))
    known = [1.0 / (1.0 / each + 1.0 / usual) if hidden.any() else each for each in slip]
    return Bound(
        slip_causal=float(np.sqrt(known[0])),
        slip_offline=float(np.sqrt(known[1])),
        speed_causal_mps=float(np.sqrt(speed[0])),
        sideslip_causal_rad=float(np.sqrt(side[0])) / mean_speed,
        sideslip_offline_rad=float(np.sqrt(side[1])) / mean_speed,
    )
