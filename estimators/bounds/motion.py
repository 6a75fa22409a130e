"""The true motion as linear models see it: where it drives, its steps, its slow errors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from twin.streams import Setup, Table

Array = NDArray[np.float64]

ORDER = 10
"""Order of the autoregression: 0.2 s at 50 Hz, the phase of a 2 Hz pitching."""
DRIVING_MPS = 0.3
"""The tractor drives where ground or driven wheels are at least so fast [m/s], as in the scores."""

MOST_FACTOR = 0.99999
"""From step to step an error keeps at most this share: 2000 s at 50 Hz."""


@dataclass(frozen=True, kw_only=True)
class Motion:
    """Slip and the errors of the wheels' counts. Shapes (n,)."""

    slip: Array
    """Slip of the wheels against the body: what counters can show."""
    unseen: Array
    """What the load does to the driven radius, in slip, less its mean; no sensor shows it."""
    skid: Array
    """Relative error of the towed wheels' travel, less its mean."""
    drives: NDArray[np.bool_]
    """Where the tractor drives; elsewhere the slip is the last one of driving."""
    counted: NDArray[np.bool_]
    """Where `unseen` and `skid` are known; elsewhere they are 0."""


def drives_at(part: Table) -> NDArray[np.bool_]:
    """Where ground or driven wheels are at least DRIVING_MPS fast; everywhere if nowhere slow."""
    speeds = [np.abs(part[n]) for n in ("speed_mps", "wheel_speed_mps") if n in part]
    return np.asarray(np.max(speeds, axis=0) >= DRIVING_MPS)


def held(values: Array, drives: NDArray[np.bool_]) -> Array:
    """Values of driving, the last of them held through what lies between; the first before them."""
    last = np.maximum.accumulate(np.where(drives, np.arange(len(values)), -1))
    return np.asarray(values[np.where(last < 0, np.argmax(drives), last)])


def motion_of(part: Table, setup: Setup, step_s: float, drives: NDArray[np.bool_]) -> Motion:
    """The motion of a part of the truth; without wheels' angles no counter errs."""
    slip = np.asarray(part["slip"], np.float64)
    none = np.zeros_like(slip)
    angles = [f"joint_{w}_spin_rad" for w in ("fl", "fr", "rl", "rr")]
    if setup.wheels is None or any(a not in part for a in angles) or setup.driven != ("rl", "rr"):
        return Motion(
            slip=held(slip, drives), unseen=none, skid=none, drives=drives, counted=drives
        )
    rims = [
        setup.wheels.radius_m[a[6:8]] * np.gradient(np.asarray(part[a], np.float64), step_s)
        for a in angles
    ]
    front, rear = 0.5 * (rims[0] + rims[1]), 0.5 * (rims[2] + rims[3])
    speed, wheel = part["speed_mps"], part["wheel_speed_mps"]
    against_body = 1.0 - speed / _off_zero(rear)
    turned = setup.wheels.radius_m["rl"] * _pitch_rate(part, step_s)
    unseen = slip - (1.0 - speed / _off_zero(rear + turned))
    skid = (front + turned) / _off_zero(speed) - 1.0
    kept = (np.abs(wheel) > DRIVING_MPS) & (np.abs(speed) > DRIVING_MPS)
    return Motion(
        slip=held(against_body, drives),
        unseen=np.where(kept, unseen - np.mean(unseen[kept]), 0.0),
        skid=np.where(kept, skid - np.mean(skid[kept]), 0.0),
        drives=drives,
        counted=kept,
    )


def _off_zero(speed: Array) -> Array:
    """A speed that may divide: at least 0.05 m/s either way."""
    return np.copysign(np.maximum(np.abs(speed), 0.05), speed)


def _pitch_rate(part: Table, step_s: float) -> Array:
    """Rate of nosing down from the attitude [rad/s]."""
    up = 2.0 * (part["qx"] * part["qz"] - part["qw"] * part["qy"])
    return np.asarray(np.gradient(-np.arcsin(np.clip(up, -1.0, 1.0)), step_s))


def centred(values: Array) -> Array:
    """The values less their mean."""
    return np.asarray(values - np.mean(values))


def autoregression(steps: Array, drives: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Least-squares weights of the last ORDER steps, and covariance of what they leave.

    Only steps count that begin and end driving, and whose last ORDER did, too.

    Returns:
        weights: (m, ORDER m), newest first. residual: (m, m).
    """
    m = steps.shape[1]
    past = np.concatenate([steps[ORDER - 1 - i : len(steps) - 1 - i] for i in range(ORDER)], axis=1)
    counts = sliding_window_view(drives, ORDER + 2).all(axis=1)
    past, now = past[counts], steps[ORDER:][counts]
    ridge = 1e-9 * np.eye(past.shape[1]) * max(float(np.mean(past**2)), 1e-18)
    weights = np.linalg.solve(past.T @ past + ridge * len(past), past.T @ now).T
    left = now - past @ weights.T
    return weights, left.T @ left / len(left) + np.eye(m) * 1e-16


def first_order(values: Array, known: NDArray[np.bool_]) -> tuple[Array, Array]:
    """The first-order vector process x' = A x + w, w ~ Q, with the moments of some values.

        C = E x x^T,   A = E x' x^T C^-1,   Q = C - A C A^T

    Values that are always 0 stay 0. The largest eigenvalue of A is at most MOST_FACTOR.

    Args:
        values: shape (n, m), without a mean.
        known: which rows count, shape (n,).

    Returns:
        A and Q, shape (m, m) each.
    """
    scale = np.sqrt(np.mean(values[known] ** 2, axis=0))
    scale = np.where(scale > 0.0, scale, 1.0)
    x = values / scale
    follows = known[1:] & known[:-1]
    cov = x[known].T @ x[known] / known.sum()
    lagged = x[1:][follows].T @ x[:-1][follows] / follows.sum()
    weights = lagged @ np.linalg.pinv(cov, rcond=1e-9, hermitian=True)
    largest = float(np.max(np.abs(np.linalg.eigvals(weights))))
    weights *= min(1.0, MOST_FACTOR / max(largest, MOST_FACTOR))
    left, axes = np.linalg.eigh(cov - weights @ cov @ weights.T)
    noise = (axes * np.maximum(left, 0.0)) @ axes.T
    return weights * scale[:, None] / scale, noise * scale[:, None] * scale
