"""Synthetic trajectories with closed forms: standing, straight, turning, rolling."""

import numpy as np

from twin.trajectory.trajectory import Trajectory

STEP_NS = 2_000_000
MAIN_M = np.array([0.5, 0.5, 2.8])
AUX_M = np.array([0.5, -0.5, 2.8])
IMU_M = np.array([0.3, 0.0, 1.2])
GRAVITY = 9.81
RADIUS_M = np.array([0.62, 0.62, 0.83, 0.83])


def drive(
    duration_s=10.0,
    speed_mps=1.5,
    yaw_rate_radps=0.0,
    yaw_rad=0.3,
    roll_rad=0.0,
    engine_radps=180.0,
    step_ns=STEP_NS,
    start_ns=0,
    **columns,
):
    """A constant speed, yaw rate and roll on level ground; `columns` replaces any column."""
    n = round(duration_s * 1e9 / step_ns) + 1
    epoch_ns = start_ns + step_ns * np.arange(n, dtype=np.int64)
    t = (epoch_ns - start_ns) * 1e-9
    yaw = yaw_rad + yaw_rate_radps * t
    world_from_body = _rotations(yaw, roll_rad)
    spin_w = np.zeros((n, 3))
    spin_w[:, 2] = yaw_rate_radps
    position_w = np.stack([*_path(t, yaw_rad, yaw, speed_mps, yaw_rate_radps), 0 * t], axis=1)
    velocity_w = speed_mps * np.stack([np.cos(yaw), np.sin(yaw), 0 * t], axis=1)
    inward_w = speed_mps * yaw_rate_radps * np.stack([-np.sin(yaw), np.cos(yaw), 0 * t], axis=1)

    def arm(point):
        return np.einsum("nij,j->ni", world_from_body, point)

    def body(vector_w):
        return np.einsum("nji,nj->ni", world_from_body, vector_w)

    imu_accel_w = inward_w + np.cross(spin_w, np.cross(spin_w, arm(IMU_M))) + [0, 0, GRAVITY]
    rate = np.tile(speed_mps / RADIUS_M, (n, 1))
    made = {
        "position_w": position_w,
        "world_from_body": _quaternions(yaw, roll_rad),
        "velocity_w": velocity_w,
        "gyro_b": body(spin_w),
        "imu_accel_b": body(imu_accel_w),
        "antenna_main_w": position_w + arm(MAIN_M),
        "antenna_main_velocity_w": velocity_w + np.cross(spin_w, arm(MAIN_M)),
        "antenna_aux_w": position_w + arm(AUX_M),
        "wheel_angle_rad": rate * t[:, None],
        "wheel_rate_radps": rate,
        "laser_m": np.full(n, 0.9),
        "inclination_rad": np.full(n, 0.05),
        "steer_rad": np.full(n, 0.1),
        "hitch_rad": np.full(n, -0.2),
        "draft_n": np.full(n, 20e3),
        "axle_torque_nm": np.full(n, 15e3),
        "engine_radps": np.full(n, engine_radps),
        "engine_torque_nm": np.full(n, 300.0),
        "fuel_lph": np.full(n, 20.0),
    }
    return Trajectory(epoch_ns, made | columns)


def pieces(trajectory, size):
    """The trajectory in chunks of `size` rows."""
    return [trajectory.cut(i, i + size) for i in range(0, len(trajectory), size)]


def collect(module, config, chunks, seed=1, start_ns=0):
    """One table from a sensor module run over the chunks."""
    state = module.init(config, seed, start_ns)
    tables = []
    for chunk in chunks:
        state, table = module.sample(config, state, chunk)
        tables.append(table)
    return {name: np.concatenate([t[name] for t in tables]) for name in tables[0]}


def same(a, b):
    """Whether two tables agree to the bit."""
    return a.keys() == b.keys() and all(
        a[k].dtype == b[k].dtype and a[k].tobytes() == b[k].tobytes() for k in a
    )


def _path(t, yaw_rad, yaw, speed, rate):
    if rate == 0:
        return speed * t * np.cos(yaw_rad), speed * t * np.sin(yaw_rad)
    radius = speed / rate
    return radius * (np.sin(yaw) - np.sin(yaw_rad)), radius * (np.cos(yaw_rad) - np.cos(yaw))


def _rotations(yaw, roll):
    c, s, cr, sr = np.cos(yaw), np.sin(yaw), np.cos(roll), np.sin(roll)
    rows = [[c, -s * cr, s * sr], [s, c * cr, -c * sr], [0 * c, sr + 0 * c, cr + 0 * c]]
    return np.moveaxis(np.array(rows), 2, 0)


def _quaternions(yaw, roll):
    c, s, cr, sr = np.cos(yaw / 2), np.sin(yaw / 2), np.cos(roll / 2), np.sin(roll / 2)
    return np.stack([c * cr, c * sr, s * sr, s * cr], axis=1)
