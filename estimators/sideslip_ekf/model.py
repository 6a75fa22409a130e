"""The filter's state, how it goes on, and what each sensor says of it. Arrays are changed in place.

Body axes at the rear-axle centre, in the ground plane: x ahead, y left.
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
    SLIDE, SLIDE_REAR, CAMERA_PULL,
) = range(11)  # fmt: skip
STATES = 11
GATE = 100.0
"""A squared normalised innovation beyond this is not believed: ten sd, as a slide that begins comes
to seven."""
FREE_RAD2 = 10.0
"""Variance of a heading that nothing is known of."""


@dataclass(frozen=True, kw_only=True)
class Tuning:
    """What the data sheets do not say; sd at the start, densities of random walks."""

    accel_x_psd: float = 0.05
    """Of the forward speed [m2/s3]."""
    accel_y_psd: float = 0.0007
    """Of the lateral speed [m2/s3]: 5 mm/s from one frame to the next."""
    heading_bias_sd_rad: float = math.radians(0.2)
    """The baseline's mounting."""
    camera_yaw_sd_rad: float = math.radians(1.0)
    """The camera's mounting."""
    camera_scale_sd: float = 0.02
    """Its height, and how far its tilt makes the ground seem nearer."""
    camera_ahead_sd: float = 0.003
    """A frame's own error of scale: a chassis that bounces."""
    camera_pull_sd_mps: float = 0.2e-3
    """Lateral speed that all frames of a drive err by alike: odometry pulls a displacement towards
    whole pixels, by 0.003 px rms of 1.6 mm at 30 frames/s, on the calibration and on the run."""
    wheel_scale_sd: float = 0.005
    """Rolling radius of the towed wheels."""
    wheel_sd_mps: float = 0.02
    """Their speed, beside that."""
    level_sd_mps: float = 0.002
    """Lateral speed of the rear axle where nothing pulls it aside: straight on, on level ground."""
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
    gyro_bias_sd_radps: float
    camera_m: tuple[float, float, float]

    @classmethod
    def of(cls, setup: Setup) -> Nominal:
        """The numbers of a set-up; data-sheet values of the usual kind where it has none."""
        gnss, imu, camera = setup.gnss, setup.imu, setup.camera
        return cls(
            cg_x_m=setup.cg_x_m,
            antenna_m=gnss.lever_arm_m if gnss else (0.0, 0.0, 0.0),
            mount_rad=gnss.heading_mount_rad if gnss else 0.0,
            velocity_sd_mps=gnss.velocity_sd_mps if gnss else 0.05,
            heading_sd_rad=(gnss.heading_sd_rad if gnss else 0.0) or 0.005,
            gyro_density=imu.gyro_noise_radps_rthz if imu else 1e-3,
            gyro_bias_sd_radps=imu.gyro_bias_sd_radps if imu else 0.0,
            camera_m=camera.lever_arm_m if camera else (0.0, 0.0, 0.0),
        )


def begin(nominal: Nominal, tuning: Tuning) -> tuple[Array, Array]:
    """Mean and covariance before the first sample."""
    sd = np.zeros(STATES)
    sd[GYRO_BIAS] = nominal.gyro_bias_sd_radps
    sd[HEADING_BIAS] = tuning.heading_bias_sd_rad
    sd[CAMERA_YAW], sd[CAMERA_SCALE] = tuning.camera_yaw_sd_rad, tuning.camera_scale_sd
    sd[WHEEL_SCALE] = tuning.wheel_scale_sd
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
    for i in (SLIDE, SLIDE_REAR):
        p[i, :] = p[:, i] = 0.0


def predict(
    x: Array, p: Array, dt: float, gyro_radps: float, nominal: Nominal, tuning: Tuning
) -> None:
    """Carry the state through dt.

    v_x' = w_x,  v_y' = w_y,  heading' = r,  r = gyro - bias
    slide_rear' = v_y,  slide' = v_y + x_cg r          (x_cg: from rear axle to centre of gravity)
    """
    rate = gyro_radps - x[GYRO_BIAS]
    arm = nominal.cg_x_m
    f = np.eye(STATES)
    f[HEADING, GYRO_BIAS] = -dt
    f[SLIDE_REAR, V_Y] = f[SLIDE, V_Y] = dt
    f[SLIDE, GYRO_BIAS] = -arm * dt
    x[SLIDE_REAR] += x[V_Y] * dt
    x[SLIDE] += (x[V_Y] + arm * rate) * dt
    x[HEADING] += rate * dt
    p[:, :] = f @ p @ f.T
    p[V_X, V_X] += tuning.accel_x_psd * dt
    _add_walk(p, tuning.accel_y_psd, dt)
    turn = nominal.gyro_density**2 * dt
    p[HEADING, HEADING] += turn
    p[SLIDE, SLIDE] += arm * arm * turn
    p[HEADING, SLIDE] += arm * turn
    p[SLIDE, HEADING] += arm * turn
    p[GYRO_BIAS, GYRO_BIAS] += tuning.gyro_bias_psd * dt


def _add_walk(p: Array, psd: float, dt: float) -> None:
    """What the lateral acceleration adds to v_y and to its two integrals."""
    p[V_Y, V_Y] += psd * dt
    for i in (SLIDE, SLIDE_REAR):
        p[V_Y, i] += psd * dt * dt / 2.0
        p[i, V_Y] += psd * dt * dt / 2.0
        for j in (SLIDE, SLIDE_REAR):
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


def take_camera(
    x: Array, p: Array, seen: Array, variance: float, gyro_radps: float, nominal: Nominal, t: Tuning
) -> bool:
    """Velocity of the camera in its own axes.

    u = (v_x - y_c r, v_y + x_c r),   z = (1 + k) (u_x + c u_y, u_y - c u_x) + (0, pull)

    with the camera's yaw c and scale k; c as cosine and sine.
    """
    rate = gyro_radps - x[GYRO_BIAS]
    ahead, left, _ = nominal.camera_m
    u_x, u_y = x[V_X] - left * rate, x[V_Y] + ahead * rate
    cos, sin, k = math.cos(x[CAMERA_YAW]), math.sin(x[CAMERA_YAW]), 1.0 + x[CAMERA_SCALE]
    z_x, z_y = cos * u_x + sin * u_y, cos * u_y - sin * u_x
    rows = np.zeros((2, STATES))
    rows[0, [V_X, V_Y, CAMERA_YAW, CAMERA_SCALE]] = k * cos, k * sin, k * z_y, z_x
    rows[1, [V_X, V_Y, CAMERA_YAW, CAMERA_SCALE]] = -k * sin, k * cos, -k * z_x, z_y
    rows[1, CAMERA_PULL] = 1.0
    rows[0, GYRO_BIAS] = k * (cos * left - sin * ahead)
    rows[1, GYRO_BIAS] = k * (-sin * left - cos * ahead)
    wobble = (t.camera_ahead_sd * u_x) ** 2
    before = x.copy()
    taken = update(x, p, rows[1], seen[1] - k * z_y - x[CAMERA_PULL], variance)
    moved = float(rows[0] @ (x - before))
    return taken and update(x, p, rows[0], seen[0] - k * z_x - moved, variance + wobble)


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

    (v_e, v_n) = P_2x2 R(heading) (v_x + (w x l)_x, v_y + (w x l)_y) + P_2z (w x l)_z
    """
    (roll, pitch, yaw), (l_x, l_y, l_z) = spin, n.antenna_m
    swing = np.array([pitch * l_z - yaw * l_y, yaw * l_x - roll * l_z, roll * l_y - pitch * l_x])
    flat = east_north - rotation[:2, 2] * swing[2]
    ahead, left = np.linalg.solve(rotation[:2, :2], flat)
    cos, sin = math.cos(x[HEADING]), math.sin(x[HEADING])
    z_x, z_y = cos * ahead + sin * left, cos * left - sin * ahead
    variance = sd**2 / float(rotation[2, 2]) ** 2
    before, taken = x.copy(), True
    for row, seen, turned in ((V_Y, z_y - swing[1], z_x), (V_X, z_x - swing[0], -z_y)):
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


def take_level(x: Array, p: Array, t: Tuning) -> None:
    """Straight on, on level ground, nothing pulls the rear axle aside: v_y = 0."""
    h = np.zeros(STATES)
    h[V_Y] = 1.0
    update(x, p, h, -x[V_Y], t.level_sd_mps**2)
