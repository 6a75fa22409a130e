"""The smallest sd of a total sideslip, without a camera: what GNSS, gyro and level ground tell.

A total is mostly the antennas' mounting angle times the way. So unlike the other bounds this one
has the constant errors, with what the drive before the run tells of them, and follows the
covariance from its first sample on. Before the truth begins nothing slides, and the ground is
level; a filter has to find that out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.bounds.motion import DRIVING_MPS, ORDER, autoregression, drives_at
from estimators.bounds.noises import EXACT, hidden_at, period_s
from estimators.layout import FIXED
from estimators.riccati import System, measured, predicted
from twin.streams import GnssSetup, ImuSetup, Setup, Streams, Table

Array = NDArray[np.float64]

NOW, HEADING, BIAS, ASKEW, STANCE, EAST, NORTH, OFF_E, OFF_N, TOTAL = range(ORDER, ORDER + 10)
"""After ORDER increments of v_y: v_y, error of the heading, the gyro's bias, mounting angle of the
antennas, pitch of the body against level ground, place, lasting error of positions, total."""
SIZE = TOTAL + 1
ASKEW_SD_RAD = math.radians(0.5)
"""Of the mounting angle before anything is driven; a drive before the run leaves little of it."""
STANCE_SD_RAD = 0.0015
"""Of the body's pitch on level ground: an axle that is 2 mm lower, 2.3 m before the other."""
WHITE_SHARE, LASTING_SHARE, LASTING_S = 0.52, 0.85, 60.0
"""Parts of a fixed position's error over its sd, and how long the second one lasts [s]: 4 and
6.5 mm of 7.6 mm, as a receiver of the UM980's class has near its base."""
GYRO_BIAS_PSD = 1e-12
"""Of a bias that is all but constant [rad2/s3]."""
GAP_S = 1.0
"""After a longer gap heading and place are new."""
FREE_RAD2, FREE_M2, FREE_M2PS2 = 10.0, 1e4, 1.0
"""Variances of what nothing is known of."""


@dataclass(frozen=True, kw_only=True)
class _Drive:
    """The motion that is known, sample for sample, shapes (n,); and the sensors."""

    epoch_ns: NDArray[np.int64]
    speed_mps: Array
    heading_rad: Array
    sunk_rad: Array
    """Roll of the body against the ground."""
    runs: NDArray[np.bool_]
    """Whether it is the run, in which the machine slides."""
    sds: Array
    """Of the heading [rad], the velocity [m/s] and the white part of a position [m], infinite
    where GNSS does not measure it; (n, 3)."""
    gnss: GnssSetup
    imu: ImuSetup
    arm_m: float
    """From the rear axle to the centre of gravity."""
    gnss_hz: float


def total_sd_m(
    setup: Setup, streams: Streams, truth: Table, window_s: tuple[float, float],
    lean_rad: float = 0.0,
) -> float:  # fmt: skip
    """Least sd of what the centre of gravity slides by within a window, told at its end [m].

    The states of `NOW` to `TOTAL` move from sample to sample, with the true speed v, heading and
    roll, and the arm c from the rear axle to the centre of gravity:

        v_y' = v_y + d,  d ~ the autoregression of the true v_y        zero before the run
        heading' = heading - bias dt + w,  w ~ N^2 dt
        (east, north)' = (east, north) + (v heading + v_y) dt to the left
        off' = exp(-dt / 60 s) off + white
        total' = total + v_y dt + c (w - bias dt)

    GNSS measures, at its rate and with the sd that it states, or else its data sheet,

        heading + askew - tan(roll - lean) stance,   v heading + v_y,   (east, north) + off

    Where the body leans with the ground, how it noses down turns its way as it turns the baseline.
    Positions count where they are fixed. Speed, roll and gravity's direction count as known, which
    makes the bound smaller, if at all. A prior of how tyres slide under an implement is not
    counted.

    Args:
        setup: noise of the sensors by their data sheets.
        streams: of the whole drive; a camera is not counted.
        truth: of the run: speed_mps, v_y_rear_mps and the attitude qw, qx, qy, qz.
        window_s: first and last second of the total.
        lean_rad: how the ground leans across the run, its left up.

    Raises:
        ValueError: the set-up has no GNSS or IMU, or fewer than 200 samples of driving are in the
            window.
    """
    if setup.gnss is None or setup.imu is None:
        raise ValueError("a total's bound needs setup.gnss and setup.imu")
    drive = _whole(setup, setup.gnss, setup.imu, streams, truth, lean_rad)
    first_ns, last_ns = (round(end * 1e9) for end in window_s)
    slides = _autoregression(truth, first_ns, last_ns)
    p = _first(setup.gnss, setup.imu)
    if drive.runs[0]:
        _anew(p, NOW, FREE_M2PS2)
    for k in range(1, int(np.searchsorted(drive.epoch_ns, last_ns, side="right"))):
        dt = (drive.epoch_ns[k] - drive.epoch_ns[k - 1]) * 1e-9
        if dt > GAP_S:
            for state, variance in ((HEADING, FREE_RAD2), (EAST, FREE_M2), (NORTH, FREE_M2)):
                _anew(p, state, variance)
            dt = 0.0
        step = _step(drive, k, dt, slides)
        p = predicted(step, p)
        if drive.runs[k] and not drive.runs[k - 1]:
            _anew(p, NOW, FREE_M2PS2)
        if drive.epoch_ns[k - 1] < first_ns <= drive.epoch_ns[k]:
            _anew(p, TOTAL, 0.0)
        if dt > 0.0:
            p = measured(step, p)
    return math.sqrt(p[TOTAL, TOTAL])


def _whole(
    setup: Setup, gnss: GnssSetup, imu: ImuSetup, streams: Streams, truth: Table, lean_rad: float
) -> _Drive:
    """The drive before the run by GNSS's own samples, the run by the truth's."""
    table, start_ns = streams["gnss"], truth["epoch_ns"][0]
    before = {name: column[table["epoch_ns"] < start_ns] for name, column in table.items()}
    speed = np.hypot(before["v_east_mps"], before["v_north_mps"])
    count, runs = len(speed), len(truth["epoch_ns"])
    w, x, y, z = (truth[f"q{axis}"] for axis in "wxyz")
    heading = np.unwrap(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    sds = _sds(gnss, streams)
    newest = np.searchsorted(table["epoch_ns"], truth["epoch_ns"], side="right") - 1
    during = sds[np.maximum(newest, 0)]
    during[~drives_at(truth) | hidden_at(streams, truth["epoch_ns"]) | (newest < 0)] = np.inf
    sds = sds[:count]
    sds[~(speed > DRIVING_MPS)] = np.inf
    return _Drive(
        epoch_ns=np.concatenate([before["epoch_ns"], truth["epoch_ns"]]),
        speed_mps=np.concatenate([np.nan_to_num(speed), truth["speed_mps"]]),
        heading_rad=np.concatenate(
            [np.nan_to_num(before["heading_rad"]) - gnss.heading_mount_rad, heading]
        ),
        sunk_rad=np.concatenate([np.zeros(count), roll - lean_rad]),
        runs=np.concatenate([np.zeros(count, bool), np.ones(runs, bool)]),
        sds=np.concatenate([sds, during]),
        gnss=gnss,
        imu=imu,
        arm_m=setup.cg_x_m,
        gnss_hz=1.0 / period_s(streams, "gnss"),
    )


def _sds(gnss: GnssSetup, streams: Streams) -> Array:
    """Sds of all samples of GNSS as `_Drive.sds` has them, by the set-up where none is stated.

    Returns:
        Shape (samples, 3).
    """
    table = streams["gnss"]
    sds = np.empty((len(table["epoch_ns"]), 3))
    for i, (measured_by, stated, nominal) in enumerate(
        (
            ("heading_rad", "heading_sd_rad", gnss.heading_sd_rad),
            ("v_north_mps", "velocity_sd_mps", gnss.velocity_sd_mps),
            ("north_m", "position_sd_m", gnss.position_sd_m),
        )
    ):
        own = streams.column("gnss", stated).astype(np.float64)
        sds[:, i] = np.where(own > 0.0, own, nominal)
        sds[~np.isfinite(streams.column("gnss", measured_by)), i] = np.inf
    sds[:, 2] *= WHITE_SHARE
    if "quality" in table:
        sds[table["quality"] != FIXED, 2] = np.inf
    return sds


def _autoregression(truth: Table, first_ns: int, last_ns: int) -> tuple[Array, float]:
    """Weights of the last ORDER steps of v_y, and variance of what they leave."""
    inside = (truth["epoch_ns"] >= first_ns) & (truth["epoch_ns"] <= last_ns)
    drives = drives_at({name: column[inside] for name, column in truth.items()})
    if drives.sum() < 20 * ORDER:
        raise ValueError(f"{drives.sum()} samples are too few for a bound; {20 * ORDER} would do")
    v_y = np.asarray(truth["v_y_rear_mps"][inside], np.float64)
    weights, noise = autoregression(np.diff(v_y)[:, None], drives)
    return weights[0], float(noise[0, 0])


def _first(gnss: GnssSetup, imu: ImuSetup) -> Array:
    """The covariance before the first sample."""
    lasting = (LASTING_SHARE * gnss.position_sd_m) ** 2
    p = np.zeros((SIZE, SIZE))
    for state, variance in (
        (HEADING, FREE_RAD2), (EAST, FREE_M2), (NORTH, FREE_M2), (ASKEW, ASKEW_SD_RAD**2),
        (BIAS, imu.gyro_bias_sd_radps**2), (STANCE, STANCE_SD_RAD**2),
        (OFF_E, lasting), (OFF_N, lasting),
    ):  # fmt: skip
        p[state, state] = variance
    return p


def _anew(p: Array, state: int, variance: float) -> None:
    """A state that nothing is known of any more, in place."""
    p[state, :] = p[:, state] = 0.0
    p[state, state] = variance


def _step(drive: _Drive, k: int, dt: float, slides: tuple[Array, float]) -> System:
    """From sample k - 1 to k, and what GNSS measures there."""
    gnss, imu, speed, arm = drive.gnss, drive.imu, drive.speed_mps[k], drive.arm_m
    cos, sin = math.cos(drive.heading_rad[k]), math.sin(drive.heading_rad[k])
    f, q = np.eye(SIZE), np.zeros((SIZE, SIZE))
    f[:ORDER, :ORDER] = 0.0
    if drive.runs[k]:
        weights, noise = slides
        f[0, :ORDER], f[NOW, :ORDER] = weights, weights
        f[1:ORDER, : ORDER - 1] = np.eye(ORDER - 1)
        q[np.ix_([0, NOW], [0, NOW])] = noise
    f[HEADING, BIAS] = -dt
    f[EAST, HEADING], f[NORTH, HEADING] = -sin * speed * dt, cos * speed * dt
    f[EAST, NOW], f[NORTH, NOW] = -sin * dt, cos * dt
    f[TOTAL, NOW], f[TOTAL, BIAS] = dt, -arm * dt
    turned = np.zeros(SIZE)
    turned[HEADING], turned[TOTAL] = 1.0, arm
    q += imu.gyro_noise_radps_rthz**2 * dt * np.outer(turned, turned)
    q[BIAS, BIAS] += GYRO_BIAS_PSD * dt
    keep = math.exp(-dt / LASTING_S)
    for off in (OFF_E, OFF_N):
        f[off, off] = keep
        q[off, off] = (LASTING_SHARE * gnss.position_sd_m) ** 2 * (1.0 - keep**2)
    rows = np.zeros((4, SIZE))
    rows[0, HEADING] = rows[0, ASKEW] = 1.0
    rows[0, STANCE] = _by_pitch(gnss.heading_mount_rad, drive.sunk_rad[k])
    rows[1, HEADING], rows[1, NOW] = speed, 1.0
    rows[2, EAST] = rows[2, OFF_E] = rows[3, NORTH] = rows[3, OFF_N] = 1.0
    heading_sd, velocity_sd, white_m = drive.sds[k]
    variances = np.maximum(np.square([heading_sd, velocity_sd, white_m, white_m]), EXACT)
    seen = np.isfinite(variances)
    share = max(drive.gnss_hz * dt, EXACT)  # of a GNSS sample in this step
    return System(transition=f, process=q, rows=rows[seen], variances=variances[seen] / share)


def _by_pitch(mount_rad: float, roll_rad: float) -> float:
    """Derivative of a leaning baseline's azimuth by the body's pitch, near pitch 0."""
    ahead, left = math.cos(mount_rad), math.sin(mount_rad)
    aside = left * math.cos(roll_rad)
    return -left * math.sin(roll_rad) * aside / (ahead**2 + aside**2)
