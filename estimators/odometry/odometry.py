"""Visual odometry: frames in, the camera's velocity in body axes with its covariance out."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from estimators.odometry import lens as optics
from estimators.odometry import orb, phase_ecc, symmetric
from estimators.odometry.lens import Array, Lens, Picture, Reason
from estimators.odometry.match import Match, Matcher
from estimators.odometry.tilt import Tilt, bent, leans, seen

METHODS: dict[str, Matcher] = {
    "orb-printed": orb.match_printed,
    "orb-similarity": orb.match_similarity,
    "phase-ecc": phase_ecc.match,
}
"""Matcher by name: (a), (b) and (c)."""

LONGEST_NS = 250_000_000
"""A frame older than this is not compared with."""


@dataclass(frozen=True, kw_only=True)
class State:
    """What odometry carries from frame to frame."""

    lens: Lens
    method: str
    epoch_ns: int = 0
    """Of the last frame that could be used."""
    picture: Picture | None = None
    """That frame at its working size."""
    shape: tuple[int, ...] = ()
    """Its own size."""
    turn_rad: Array | None
    """Rotation of the body since then, as a vector in body axes; None without gyros."""
    moved_pxps: Array | None = None
    """Of the principal point, back from the last picture to the one before, per second."""
    tilt: Tilt = field(default_factory=Tilt)
    """Tilt of the camera's axis from the ground's normal."""


@dataclass(frozen=True, kw_only=True)
class Motion:
    """Velocity of the camera's optical centre over one interval, or why there is none."""

    epoch_ns: int
    """Middle of the interval; the frame's own epoch where there is no velocity."""
    reason: Reason
    interval_s: float = math.nan
    velocity_mps: Array
    """Forward and left in the ground plane, axes of the body at the middle; shape (2,), or NaN."""
    covariance: Array
    """Shape (2, 2)."""
    yaw_rad: float = math.nan
    """Turn of the picture over the interval, counter-clockwise from above; NaN if not measured."""
    scale: float = math.nan
    """Height of this frame over that of the one before."""
    tilt_rad: tuple[float, float] = (math.nan, math.nan)
    """How far the ground's normal leans forward and left in the camera's axes."""
    quality: float = 0.0

    @property
    def used(self) -> bool:
        """Whether there is a velocity."""
        return self.reason == Reason.USED


def begin(lens: Lens, method: str = "phase-ecc") -> State:
    """The state before the first frame."""
    return State(lens=lens, method=method, turn_rad=np.zeros(3))


def step(
    state: State,
    frame: NDArray[np.uint8] | None,
    epoch_ns: int,
    turn_rad: Array | None = None,
) -> tuple[State, Motion]:
    """Take in one frame.

    A frame that cannot be used leaves the last good one to be compared with the next.

    Args:
        state: after the frame before.
        frame: None for one that is missing.
        epoch_ns: the instant it shows.
        turn_rad: the gyros' integral since the call before, body axes, shape (3,); None without.

    Returns:
        The state after it, and the motion since the last good frame.
    """
    turn = None if state.turn_rad is None or turn_rad is None else state.turn_rad + turn_rad
    state = replace(state, turn_rad=turn)
    picture, reason = optics.picture(frame, state.lens)
    if picture is None or frame is None:
        return state, nothing(epoch_ns, reason)
    previous, shape = state.picture, frame.shape[:2]
    after = replace(state, epoch_ns=epoch_ns, picture=picture, shape=shape, turn_rad=np.zeros(3))
    if previous is None or epoch_ns - state.epoch_ns > LONGEST_NS or epoch_ns <= state.epoch_ns:
        return replace(after, moved_pxps=None), nothing(epoch_ns, Reason.FIRST)
    if state.shape != shape:
        return replace(after, moved_pxps=None), nothing(epoch_ns, Reason.SIZE)
    if np.array_equal(previous, picture):
        return state, nothing(epoch_ns, Reason.FROZEN)
    interval_s = (epoch_ns - state.epoch_ns) * 1e-9
    moved_px = None if state.moved_pxps is None else state.moved_pxps * interval_s
    angle_rad = float(_camera_turn(state)[2])
    match = METHODS[state.method](previous, picture, angle_rad, moved_px)
    if match is None:
        return replace(after, moved_pxps=None), nothing(epoch_ns, Reason.UNMATCHED)
    warp, centre = match.previous_from_current, optics.centre_px(picture.shape)
    after = replace(after, moved_pxps=(warp[:, :2] @ centre + warp[:, 2] - centre) / interval_s)
    if match.stretches:
        tilt = seen(state.tilt, warp, picture.shape, _focal(state, picture), interval_s)
        state, after = replace(state, tilt=tilt), replace(after, tilt=tilt)
    return after, motion(state, epoch_ns, picture, match)


def nothing(epoch_ns: int, reason: Reason) -> Motion:
    """A frame that gave no velocity."""
    nan = np.full((2, 2), np.nan)
    return Motion(epoch_ns=epoch_ns, reason=reason, velocity_mps=nan[0], covariance=nan)


def motion(state: State, epoch_ns: int, picture: Picture, match: Match) -> Motion:
    """Velocity from the map between two pictures.

        d = W c - c                            where the principal point was      [px]
        d = d - bent                           what an affine map is off there
        d = d - f (R e_z)_xy / (R e_z)_z       what the body's roll and pitch did
        d = R2(-a / 2) d                       axes at the middle of the interval
        v = B d h / f / dt
        P = (h / f / dt)^2 var I + (sd_h / h)^2 v v^T

    W maps the current picture to the previous, c is the principal point, R the camera's rotation by
    the gyros, a its turn about the ground's normal, to which the camera is tilted as it has seen,
    B turns picture axes into body axes, h is the
    nominal height and f the focal length at the working size. The map has a turn of its own, but a
    camera that is tilted by 0.3 degree sees one of 0.02 rad/s at 2 m/s that is none: it is taken
    only where there are no gyros.
    """
    lens = state.lens
    focal = _focal(state, picture)
    centre = optics.centre_px(picture.shape)
    warp = match.previous_from_current
    camera_turn = _camera_turn(state)
    axis = optics.turn_of(camera_turn)[:, 2]
    d_px = warp @ np.append(centre, 1.0) - centre - focal * axis[:2] / axis[2]
    if match.stretches:
        d_px -= bent(state.tilt, warp, picture.shape, focal, symmetric.edge_px(picture.shape))
    seen = _angle(warp) if match.turns else math.nan
    angle = seen if state.turn_rad is None and match.turns else float(camera_turn[2])
    d_px = phase_ecc.turned_about(np.zeros(2), -angle / 2)[:, :2] @ d_px
    interval_ns = epoch_ns - state.epoch_ns
    to_mps = lens.height_m / focal / (interval_ns * 1e-9)
    velocity = to_mps * (optics.BODY_FROM_IMAGE @ d_px)
    covariance = to_mps**2 * match.variance_px2 * np.eye(2)
    covariance += lens.height_sd**2 * np.outer(velocity, velocity)
    return Motion(
        epoch_ns=state.epoch_ns + interval_ns // 2,
        reason=Reason.USED,
        interval_s=interval_ns * 1e-9,
        velocity_mps=velocity,
        covariance=covariance,
        yaw_rad=-seen,
        scale=math.sqrt(abs(float(np.linalg.det(warp[:, :2])))) if match.turns else math.nan,
        tilt_rad=leans(state.tilt) if match.stretches else (math.nan, math.nan),
        quality=match.quality,
    )


def _focal(state: State, picture: Picture) -> float:
    return optics.working_focal_px(state.lens, picture.shape)


def _camera_turn(state: State) -> Array:
    """Rotation of the camera since the last frame, camera axes; zero where it is not known.

    The body turns about the ground's normal, which is not the optical axis of a tilted camera.
    """
    if state.turn_rad is None:
        return np.zeros(3)
    turn: Array = optics.CAMERA_FROM_BODY @ state.turn_rad
    turn[:2] += turn[2] * np.array(state.tilt.normal)
    return turn


def _angle(warp: Array) -> float:
    """Angle of the rotation nearest to a map's linear part."""
    return math.atan2(warp[1, 0] - warp[0, 1], warp[0, 0] + warp[1, 1])
