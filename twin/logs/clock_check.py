"""Lag of the GNSS speed behind the wheel speed, from starts and stops with slip."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.streams import Array

MOST_LAG_S, STEP_S = 2.0, 0.01
STANDING_MPS = 0.2
SHORTEST_S = 2.0
MARGIN_S = 2.0
"""Standing before and after a start and stop that counts with it."""
SMOOTHING_S = 0.3
LOCKED_SHARE = 0.25
"""Wheels that differ by more of the top speed from the law lock or spin, and give no lag."""
FEWEST = 6
"""Fewest samples of GNSS in a start and stop."""
_GRID_S = 0.05


def lags_s(gnss_s: Array, gnss_mps: Array, wheel_s: Array, wheel_mps: Array) -> NDArray[np.float64]:
    """Lag of the GNSS speed in each start and stop [s]; positive if GNSS is late.

        v(t) = w(t - lag) (c - k a(t - lag))

    v: GNSS speed [m/s]. w: wheel speed [m/s]. a: acceleration of the wheels [m/s^2]. c [-], k
    [s^2/m]: scale, and change of slip with acceleration. For each trial lag, least squares give c
    and k; the lag with the smallest residual is the result. Slip appears as a lead of the wheels
    that is proportional to w (k w), and the lag is equal at all w, so the two can be separated.

    Args:
        gnss_s, gnss_mps: times and ground speeds, shape (n,); unknown speeds are left out.
        wheel_s, wheel_mps: times and wheel speeds, shape (m,).

    Returns:
        One lag for each start and stop between standstills that has samples enough; NaN where the
        wheels locked or spun.
    """
    seen, known = np.isfinite(wheel_mps), np.isfinite(gnss_mps)
    if seen.sum() < 2 or known.sum() < FEWEST:
        return np.empty(0)
    grid_s = np.arange(wheel_s[seen][0], wheel_s[seen][-1], _GRID_S)
    wheel = np.interp(grid_s, wheel_s[seen], wheel_mps[seen])
    width = 2 * int(0.5 * SMOOTHING_S / _GRID_S) + 1
    wheel = np.convolve(np.pad(wheel, width // 2, mode="edge"), np.ones(width) / width, "valid")
    found = [
        _lag_s(gnss_s[known & near], gnss_mps[known & near], grid_s, wheel)
        for first_s, last_s in _pulses(grid_s, wheel)
        if (known & (near := (gnss_s >= first_s) & (gnss_s <= last_s))).sum() >= FEWEST
    ]
    return np.array(found)


def _pulses(time_s: Array, speed_mps: Array) -> list[tuple[float, float]]:
    """From just before each start to just after its stop."""
    moving = np.concatenate([[False], speed_mps > STANDING_MPS, [False]])
    edges = np.flatnonzero(np.diff(moving.astype(np.int8)))
    spans = [(time_s[a], time_s[b - 1]) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    return [(a - MARGIN_S, b + MARGIN_S) for a, b in spans if b - a >= SHORTEST_S]


def _lag_s(gnss_s: Array, gnss_mps: Array, grid_s: Array, wheel_mps: Array) -> float:
    accel = np.gradient(wheel_mps, grid_s)
    lags = np.arange(-MOST_LAG_S, MOST_LAG_S + 0.5 * STEP_S, STEP_S)
    residuals = []
    for lag in lags:
        speed, change = (np.interp(gnss_s - lag, grid_s, column) for column in (wheel_mps, accel))
        design = np.column_stack([speed, speed * change])
        fit, *_ = np.linalg.lstsq(design, gnss_mps, rcond=None)
        residuals.append(gnss_mps - design @ fit)
    best = int(np.argmin(np.sum(np.square(residuals), axis=1)))
    locked = np.max(np.abs(residuals[best])) > LOCKED_SHARE * np.max(gnss_mps)
    return np.nan if locked else float(lags[best])
