"""The filter's state, how it goes on, and what each sensor says of it. Arrays are changed in place.

Body axes at the rear-axle centre, in the ground plane: x ahead, y left. v_y is the lateral speed at
the camera, measured without the gyro. The gyro's noise therefore enters only the slides of other
points (rear axle, centre of gravity), which are reached through the yaw rate.

One module, because a state, its rates and its Jacobian are read together.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.sideslip_ekf import plane
from twin.streams import Setup

Array = NDArray[np.float64]

(
    V_X, V_Y, HEADING, GYRO_BIAS, HEADING_BIAS, CAMERA_YAW, CAMERA_SCALE, WHEEL_SCALE,
    SLIDE, SLIDE_REAR, CAMERA_PULL, GYRO_SCALE, ASIDE,
) = range(13)  # fmt: skip
"""ASIDE is the camera's path to the left since the last frame."""
STATES = 13
GATE = 100.0
"""A squared normalised innovation beyond this is not believed: ten sd, as a slide that begins comes
to seven."""
MOST_PSD = 0.1
"""Of the lateral speed [m2/s3]: 60 mm/s from one frame to the next."""
FREE_RAD2 = 10.0
"""Variance of a heading that nothing is known of."""


@dataclass(frozen=True, kw_only=True)
class Tuning:
    """What the data sheets do not say; sd at the start, densities of random walks."""

    accel_x_psd: float = 0.05
    """Of the forward speed [m2/s3]."""
    accel_y_psd: float = 0.0007
    """Of the lateral speed at first [m2/s3]: 5 mm/s from one frame to the next."""
    accel_y_least_psd: float = 1e-6
    """It is found from how well frames are foretold, but never less than this [m2/s3]."""
    accel_y_memory_s: float = 0.5
    """Over which time [s]."""
    jump_mps: float = 0.3
    """A lateral speed that changes by less from frame to frame, 1 g, is a slide that begins."""
    heading_bias_sd_rad: float = math.radians(0.2)
    """The baseline's mounting."""
    camera_yaw_sd_rad: float = math.radians(1.0)
    """The camera's mounting."""
    camera_scale_sd: float = 0.02
    """Its height, and how far its tilt makes the ground seem nearer."""
    camera_ahead_sd: float = 0.003
    """A frame's own error of scale: a chassis that bounces."""
    camera_pull_sd_mps: float = 0.01e-3
    """Lateral speed that all frames of a drive err by alike: detail finer than the pixels pulls a
    displacement by 0.0002 px rms of 1.6 mm at 30 frames/s, on the calibration and on the run."""
    wheel_scale_sd: float = 0.005
    """Rolling radius of the towed wheels."""
    wheel_sd_mps: float = 0.02
    """Their speed, beside that."""
    level_sd_mps: float = 0.0003
    """Lateral speed of the rear axle where nothing pulls it aside: straight on, on level ground,
    each 20 ms anew; 40 s tell it to 0.01 mm/s."""
    gyro_scale_sd: float = 1e-3
    """Of a calibrated unit."""
    gyro_bias_psd: float = 1e-11
    """Of the gyro's bias [rad2/s3]."""


@dataclass(frozen=True)
class Nominal:
    """What of the set-up is needed."""

    cg_x_m: float
    antenna_m: tuple[float, float, float]
    mount_rad: float
    velocity_sd_mps: float
    heading_sd_rad: float
    gyro_density: float
    gyro_sd_radps: float
    """Of one of its samples."""
    gyro_bias_sd_radps: float
    camera_m: tuple[float, float, float]

    @classmethod
    def of(cls, setup: Setup) -> Nominal:
        """The numbers of a set-up; data-sheet values of the usual kind where it has none."""
        gnss, imu, camera = setup.gnss, setup.imu, setup.camera
        density = imu.gyro_noise_radps_rthz if imu else 1e-3
        return cls(
            cg_x_m=setup.cg_x_m,
            antenna_m=gnss.lever_arm_m if gnss else (0.0, 0.0, 0.0),
            mount_rad=gnss.heading_mount_rad if gnss else 0.0,
            velocity_sd_mps=gnss.velocity_sd_mps if gnss else 0.05,
            heading_sd_rad=(gnss.heading_sd_rad if gnss else 0.0) or 0.005,
            gyro_density=density,
            gyro_sd_radps=density * math.sqrt(imu.rate_hz if imu else 50.0),
            gyro_bias_sd_radps=imu.gyro_bias_sd_radps if imu else 0.0,
            camera_m=camera.lever_arm_m if camera else (0.0, 0.0, 0.0),
        )


@dataclass(frozen=True)
class Frame:
    """What a frame tells of the lateral speed."""

    ahead_mps: float
    """Mean since the frame before, in the camera's axes."""
    left_mps: float
    variance: float
    interval_s: float
    follows: bool
    """Whether the path since that frame is the filter's own."""


def begin(nominal: Nominal, tuning: Tuning) -> tuple[Array, Array]:
    """Mean and covariance before the first sample."""
    sd = np.zeros(STATES)
    sd[GYRO_BIAS] = nominal.gyro_bias_sd_radps
    sd[HEADING_BIAS] = tuning.heading_bias_sd_rad
    sd[CAMERA_YAW], sd[CAMERA_SCALE] = tuning.camera_yaw_sd_rad, tuning.camera_scale_sd
    sd[WHEEL_SCALE], sd[GYRO_SCALE] = tuning.wheel_scale_sd, tuning.gyro_scale_sd
    x, p = np.zeros(STATES), np.diag(sd**2)
    forget(x, p, tuning)
    return x, p


def forget(x: Array, p: Array, tuning: Tuning) -> None:
    """Speeds, heading and the pixels' pull become unknown, as after a gap; the rest stays.

    What slid in a gap nobody knows: the slides' sd counts from here on.
    """
    pull = tuning.camera_pull_sd_mps**2
    for i, variance in ((V_X, 100.0), (V_Y, 0.1), (HEADING, FREE_RAD2), (CAMERA_PULL, pull)):
        p[i, :] = p[:, i] = 0.0
        x[i], p[i, i] = 0.0, variance
    for i in (SLIDE, SLIDE_REAR, ASIDE):
        p[i, :] = p[:, i] = 0.0
    x[ASIDE] = 0.0


def predict(
    x: Array, p: Array, dt: float, gyro_radps: float, psd: float, nominal: Nominal, tuning: Tuning
) -> None:
    """Carry the state through dt.

    v_x' = w_x,  v_y' = w_y,  heading' = r,  r = gyro (1 - scale) - bias
    slide_rear' = v_y - x_c r,  slide' = v_y - (x_c - x_cg) r

    from the rear axle to the camera x_c, to the centre of gravity x_cg; `psd` is that of w_y.
    """
    rate = turning(x, gyro_radps)
    turned = np.zeros(STATES)
    turned[HEADING] = 1.0
    turned[SLIDE_REAR] = -nominal.camera_m[0]
    turned[SLIDE] = nominal.cg_x_m - nominal.camera_m[0]
    f = np.eye(STATES)
    f[:, GYRO_BIAS] -= turned * dt
    f[:, GYRO_SCALE] -= turned * gyro_radps * dt
    f[SLIDE_REAR, V_Y] = f[SLIDE, V_Y] = f[ASIDE, V_Y] = dt
    x += turned * rate * dt
    x[SLIDE_REAR] += x[V_Y] * dt
    x[SLIDE] += x[V_Y] * dt
    x[ASIDE] += x[V_Y] * dt
    p[:, :] = f @ p @ f.T
    p[V_X, V_X] += tuning.accel_x_psd * dt
    add_walk(p, psd, dt)
    p += nominal.gyro_density**2 * dt * np.outer(turned, turned)
    p[GYRO_BIAS, GYRO_BIAS] += tuning.gyro_bias_psd * dt


def turning(x: Array, gyro_radps: float) -> float:
    """Yaw rate, r = gyro (1 - scale) - bias."""
    return gyro_radps * (1.0 - float(x[GYRO_SCALE])) - float(x[GYRO_BIAS])


INTEGRALS = (SLIDE, SLIDE_REAR, ASIDE)


def add_walk(p: Array, psd: float, dt: float) -> None:
    """What the lateral acceleration adds to v_y and to its integrals."""
    p[V_Y, V_Y] += psd * dt
    for i in INTEGRALS:
        p[V_Y, i] += psd * dt * dt / 2.0
        p[i, V_Y] += psd * dt * dt / 2.0
        for j in INTEGRALS:
            p[i, j] += psd * dt**3 / 3.0


def update(x: Array, p: Array, h: Array, innovation: float, variance: float) -> bool:
    """Take one scalar measurement unless it is beyond the gate; whether it was taken."""
    ph = p @ h
    total = float(h @ ph) + variance
    if innovation * innovation > GATE * total:
        return False
    gain = ph / total
    x += gain * innovation
    p -= np.outer(gain, ph)
    p[:, :] = 0.5 * (p + p.T)
    return True


def take_ahead(
    x: Array, p: Array, seen: float, variance: float, gyro_radps: float, n: Nominal, t: Tuning
) -> bool:
    """Forward speed in the camera's own axes at the middle of two frames.

        u = (v_x - y_c r, v_y),   z_x = (1 + k) (cos(c) u_x + sin(c) u_y)

    with the camera's yaw c and scale k.
    """
    left = n.camera_m[1]
    u_x, u_y = x[V_X] - left * turning(x, gyro_radps), x[V_Y]
    cos, sin, k = math.cos(x[CAMERA_YAW]), math.sin(x[CAMERA_YAW]), 1.0 + x[CAMERA_SCALE]
    z_x, z_y = cos * u_x + sin * u_y, cos * u_y - sin * u_x
    h = np.zeros(STATES)
    h[[V_X, V_Y, CAMERA_YAW, CAMERA_SCALE]] = k * cos, k * sin, k * z_y, z_x
    h[GYRO_BIAS] = k * left * cos
    return update(x, p, h, seen - k * z_x, variance + (t.camera_ahead_sd * u_x) ** 2)


def take_aside(x: Array, p: Array, frame: Frame, psd: float, t: Tuning) -> tuple[bool, float]:
    """Path to the left from the frame before, at this one, from both components that were seen.

        cos(c) z_y + sin(c) z_x = (1 + k) path / T + pull

    So no error of the forward speed comes in by a camera that is turned, and nothing that happens
    between two frames is lost, however rough. Where the filter does not know the path since the
    frame before, v_y stands for path / T.

    The density q of the lateral speed's walk follows the innovation i and its variance s,
    q += 3 (i^2 - s) / memory; an i beyond three sd is a slide that begins, a walk of 3 i^2 / T.

    Returns:
        Whether it was taken, and q.
    """
    span, k = frame.interval_s, 1.0 + x[CAMERA_SCALE]
    cos, sin = math.cos(x[CAMERA_YAW]), math.sin(x[CAMERA_YAW])
    ahead, left = frame.ahead_mps, frame.left_mps
    u_y = x[ASIDE] / span if frame.follows else x[V_Y]
    h = np.zeros(STATES)
    h[[CAMERA_YAW, CAMERA_SCALE, CAMERA_PULL]] = sin * left - cos * ahead, u_y, 1.0
    h[ASIDE if frame.follows else V_Y] = k / span if frame.follows else k
    variance = frame.variance + (sin * t.camera_ahead_sd * ahead) ** 2
    variance += 0.0 if frame.follows else psd * span / 3.0
    innovation = float(cos * left + sin * ahead - k * u_y - x[CAMERA_PULL])
    total = float(h @ p @ h) + variance
    if frame.follows and 9.0 * total < innovation**2 < t.jump_mps**2:
        add_walk(p, 3.0 * innovation**2 / span, span)
    memory_s = max(t.accel_y_memory_s, span)
    psd = min(max(psd + 3.0 * (innovation**2 - total) / memory_s, t.accel_y_least_psd), MOST_PSD)
    taken = update(x, p, h, innovation, variance)
    x[ASIDE], p[ASIDE, :], p[:, ASIDE] = 0.0, 0.0, 0.0
    return taken, psd


def take_heading(
    x: Array, p: Array, azimuth_rad: float, sd: float, rotation: Array, nominal: Nominal
) -> None:
    """Azimuth of the baseline; a heading that is unknown begins with it."""
    if p[HEADING, HEADING] >= FREE_RAD2:
        direct = plane.heading(rotation, azimuth_rad - x[HEADING_BIAS])
        x[HEADING] = direct - nominal.mount_rad
    seen, slope = plane.azimuth(rotation, x[HEADING] + nominal.mount_rad)
    h = np.zeros(STATES)
    h[HEADING], h[HEADING_BIAS] = slope, 1.0
    update(x, p, h, plane.wrap(azimuth_rad - seen - x[HEADING_BIAS]), sd**2)


def take_velocity(
    x: Array, p: Array, east_north: Array, sd: float, rotation: Array, spin: Array, n: Nominal
) -> bool:
    """Horizontal velocity of the antenna, which moves along the ground plane but for its swinging.

    (v_e, v_n) = P_2x2 R(heading) (v_x + (w x l)_x, v_y - x_c r + (w x l)_y) + P_2z (w x l)_z
    """
    (roll, pitch, yaw), (l_x, l_y, l_z) = spin, n.antenna_m
    swing = np.array([pitch * l_z - yaw * l_y, yaw * l_x - roll * l_z, roll * l_y - pitch * l_x])
    flat = east_north - rotation[:2, 2] * swing[2]
    ahead, left = np.linalg.solve(rotation[:2, :2], flat)
    cos, sin = math.cos(x[HEADING]), math.sin(x[HEADING])
    z_x, z_y = cos * ahead + sin * left, cos * left - sin * ahead
    variance = sd**2 / float(rotation[2, 2]) ** 2
    before, taken = x.copy(), True
    for row, seen, turned in (
        (V_Y, z_y - swing[1] + n.camera_m[0] * yaw, z_x),
        (V_X, z_x - swing[0], -z_y),
    ):
        h = np.zeros(STATES)
        h[row], h[HEADING] = 1.0, turned
        moved = float(h @ (x - before))
        taken &= update(x, p, h, seen - before[row] - moved, variance)
    return taken


def take_wheels(x: Array, p: Array, speed_mps: float, sd: float, t: Tuning) -> None:
    """Mean speed of the towed wheels, (1 + e) v_x."""
    h = np.zeros(STATES)
    h[V_X], h[WHEEL_SCALE] = 1.0 + x[WHEEL_SCALE], x[V_X]
    expected = (1.0 + x[WHEEL_SCALE]) * x[V_X]
    update(x, p, h, speed_mps - expected, sd**2 + t.wheel_sd_mps**2)


def take_level(x: Array, p: Array, gyro_radps: float, nominal: Nominal, t: Tuning) -> None:
    """Straight on, on level ground, nothing pulls the rear axle aside: v_y - x_c r = 0.

    The gyro's scale is left out: where nothing turns, its noise would be taken for one.
    """
    ahead = nominal.camera_m[0]
    h = np.zeros(STATES)
    h[V_Y], h[GYRO_BIAS] = 1.0, ahead
    variance = t.level_sd_mps**2 + (ahead * nominal.gyro_sd_radps) ** 2
    update(x, p, h, -rear_mps(x, gyro_radps, nominal), variance)


def rear_mps(x: Array, gyro_radps: float, nominal: Nominal) -> float:
    """Lateral speed of the rear axle."""
    return float(x[V_Y]) - nominal.camera_m[0] * turning(x, gyro_radps)
