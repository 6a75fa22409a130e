"""What each source measures: h(x), and its row H = dh/dx filled in place.

One function per kind of measurement, and none knows how the state moves.
"""

from __future__ import annotations

import math

from estimators.kalman import Array, Record
from estimators.sideslip_ekf.layout import (
    ASIDE,
    BIAS_P,
    BIAS_Q,
    BIAS_R,
    CAMERA_PITCH,
    CAMERA_PULL,
    CAMERA_SCALE,
    CAMERA_YAW,
    COMPLIANCE,
    EAST,
    GYRO_SCALE,
    HEADING,
    MISALIGNED,
    NORTH,
    P_RATE,
    PITCH,
    PUSH,
    Q_RATE,
    R_RATE,
    RECEIVER_E,
    RECEIVER_N,
    ROLL,
    V_X,
    V_Y,
)  # fmt: skip
from estimators.sideslip_ekf.motion import body_left, body_left_by, stance, turning
from twin.compute.compiled import array_law

EARTH_MPS2 = 9.81


@array_law
def azimuth(x: Array, mount_rad: float, h: Array) -> float:
    """Horizontal direction of the antennas' baseline, which leans with the body [rad].

    heading + askew + atan2(b_y cos(roll), b_x cos(pitch) + b_y sin(pitch) sin(roll)),
    b = (cos, sin)(mount)
    """
    b_x, b_y = math.cos(mount_rad), math.sin(mount_rad)
    up = b_x * math.cos(x[PITCH]) + b_y * math.sin(x[PITCH]) * math.sin(x[ROLL])
    left = b_y * math.cos(x[ROLL])
    size = up * up + left * left
    h[:] = 0.0
    h[HEADING] = h[MISALIGNED] = 1.0
    up_roll = b_y * math.sin(x[PITCH]) * math.cos(x[ROLL])
    up_pitch = -b_x * math.sin(x[PITCH]) + b_y * math.cos(x[PITCH]) * math.sin(x[ROLL])
    h[ROLL] = (-up * b_y * math.sin(x[ROLL]) - left * up_roll) / size
    h[PITCH] = -left * up_pitch / size
    return float(x[HEADING] + x[MISALIGNED] + math.atan2(left, up))


@array_law
def velocity(
    x: Array, imu: Array, lean: float, left: bool, nominal: Record, memory: Record, h: Array
) -> float:
    """Horizontal velocity of the antenna, ahead of the body or to its left [m/s].

        ahead = v_x cos(grade) + (w x l)_x
        left  = v_y cos(a) - v_x sin(a) (pitch + grade)
              + (w x l)_y cos(roll) - (w x l)_z sin(roll)

    The row is that of the velocity in the horizontal axes that the heading has now.
    """
    l_x, l_y, l_z = nominal.antenna_m
    p, q, r = imu[P_RATE] - x[BIAS_P], imu[Q_RATE] - x[BIAS_Q], turning(x, imu)
    cos, sin = math.cos(x[ROLL]), math.sin(x[ROLL])
    swing_y, swing_z = r * l_x - p * l_z, p * l_y - q * l_x
    ahead = x[V_X] * math.cos(memory.grade) + q * l_z - r * l_y
    by_x = -math.sin(lean) * (x[PITCH] + memory.grade)
    beside = x[V_Y] * math.cos(lean) + x[V_X] * by_x + swing_y * cos - swing_z * sin
    h[:] = 0.0
    if not left:
        h[V_X], h[HEADING] = math.cos(memory.grade), -beside
        h[BIAS_Q], h[BIAS_R], h[GYRO_SCALE] = -l_z, l_y, l_y * imu[R_RATE]
        return float(ahead)
    h[V_Y], h[V_X], h[HEADING] = math.cos(lean), by_x, ahead
    h[PITCH] = -math.sin(lean) * x[V_X]
    h[ROLL] = -swing_y * sin - swing_z * cos
    h[BIAS_P] = l_z * cos + l_y * sin
    h[BIAS_Q], h[BIAS_R] = -l_x * sin, -l_x * cos
    h[GYRO_SCALE] = -l_x * cos * imu[R_RATE]
    return float(beside)


@array_law
def place(x: Array, north: bool, nominal: Record, h: Array) -> float:
    """East or north of the antenna [m]: place + R(heading) (arm ahead, arm to the left) + error."""
    l_x, l_y, l_z = nominal.antenna_m
    sin_roll, cos_roll = math.sin(x[ROLL]), math.cos(x[ROLL])
    sin_pitch, cos_pitch = math.sin(x[PITCH]), math.cos(x[PITCH])
    up = l_y * sin_roll + l_z * cos_roll
    ahead, left = l_x * cos_pitch + up * sin_pitch, l_y * cos_roll - l_z * sin_roll
    ahead_pitch, ahead_roll = -l_x * sin_pitch + up * cos_pitch, left * sin_pitch
    left_roll = -up
    cos, sin = math.cos(x[HEADING]), math.sin(x[HEADING])
    h[:] = 0.0
    if north:
        h[NORTH] = h[RECEIVER_N] = 1.0
        h[HEADING] = cos * ahead - sin * left
        h[PITCH], h[ROLL] = sin * ahead_pitch, sin * ahead_roll + cos * left_roll
        return float(x[NORTH] + x[RECEIVER_N] + sin * ahead + cos * left)
    h[EAST] = h[RECEIVER_E] = 1.0
    h[HEADING] = -(sin * ahead + cos * left)
    h[PITCH], h[ROLL] = cos * ahead_pitch, cos * ahead_roll - sin * left_roll
    return float(x[EAST] + x[RECEIVER_E] + cos * ahead - sin * left)


@array_law
def slide(x: Array, imu: Array, nominal: Record, h: Array) -> float:
    """The law of sliding [m/s]: v_y + v_x (compliance f - push), zero where it holds.

        f = g sin(roll) cos(pitch) + v_x r

    Tyres slide by an angle that grows with the force across them (cornering stiffness), which over
    the mass is f, on a slope as in a curve. The accelerometer itself feels every bump beside it.
    """
    g, r = EARTH_MPS2, turning(x, imu)
    sin_roll, cos_roll = math.sin(x[ROLL]), math.cos(x[ROLL])
    sin_pitch, cos_pitch = math.sin(x[PITCH]), math.cos(x[PITCH])
    force = g * sin_roll * cos_pitch + x[V_X] * r
    angle, by = x[COMPLIANCE] * force - x[PUSH], x[V_X] * x[COMPLIANCE]
    h[:] = 0.0
    h[V_Y], h[V_X], h[COMPLIANCE] = 1.0, angle + by * r, x[V_X] * force
    h[ROLL], h[PITCH] = by * g * cos_roll * cos_pitch, -by * g * sin_roll * sin_pitch
    h[BIAS_R], h[PUSH] = -by * x[V_X], -x[V_X]
    h[GYRO_SCALE] = -by * x[V_X] * imu[R_RATE]
    return float(x[V_Y] + x[V_X] * angle)


@array_law
def camera_left(x: Array, imu: Array, lean: float, nominal: Record, memory: Record) -> float:
    """Velocity of the camera along the body's left [m/s]: body_left + x_c r - z_c p."""
    beside = body_left(x[V_X], x[V_Y], x, lean, memory)
    p, r = imu[P_RATE] - x[BIAS_P], turning(x, imu)
    return float(beside + nominal.camera_m[0] * r - nominal.camera_m[2] * p)


@array_law
def camera_ahead(
    x: Array, imu: Array, lean: float, nominal: Record, memory: Record, h: Array
) -> float:
    """Forward speed in the camera's own axes [m/s].

    u = (v_x - y_c r + z_c q, camera_left)
    (1 + k) (u_x cos(c) + u_y sin(c))   with the camera's yaw c and scale k
    """
    _, y_c, z_c = nominal.camera_m
    q, r = imu[Q_RATE] - x[BIAS_Q], turning(x, imu)
    u_x = x[V_X] - y_c * r + z_c * q
    u_y = camera_left(x, imu, lean, nominal, memory)
    cos, sin, k = math.cos(x[CAMERA_YAW]), math.sin(x[CAMERA_YAW]), 1.0 + x[CAMERA_SCALE]
    along = u_x * cos + u_y * sin
    h[:] = 0.0
    _by_left(x, lean, k * sin, nominal, memory, h)
    h[V_X] += k * cos
    h[CAMERA_SCALE] = along
    h[CAMERA_YAW] += k * (u_y * cos - u_x * sin)
    h[BIAS_R] += k * y_c * cos
    h[GYRO_SCALE] += k * y_c * cos * imu[R_RATE]
    h[BIAS_Q] = -k * z_c * cos
    return float(k * along)


@array_law
def _by_left(x: Array, lean: float, by: float, nominal: Record, memory: Record, h: Array) -> None:
    """Add `by` times the derivatives of `camera_left`, but for the gyro's scale.

    Where nothing turns, its noise would be taken for a scale.
    """
    by_x, by_y, by_nose, by_lean = body_left_by(x, lean, memory)
    h[V_X] += by * by_x
    h[V_Y] += by * by_y
    h[CAMERA_PITCH if memory.tilted else PITCH] += by * by_nose
    h[CAMERA_YAW if memory.tilted else ROLL] += by * by_lean
    h[BIAS_R] -= by * nominal.camera_m[0]
    h[BIAS_P] += by * nominal.camera_m[2]


@array_law
def camera_aside(
    x: Array, frame: Array, follows: bool, beside: float, lean: float, nominal: Record,
    memory: Record, h: Array,
) -> float:  # fmt: skip
    """What a frame's lateral motion is off [m/s], from both components that were seen.

        (1 + k) aside / T + pull - (left cos(c) + ahead sin(c))

    So no error of the forward speed comes in by a camera that is turned, and nothing that happens
    between two frames is lost, however rough.

    Args:
        x: mean, (SIZE,).
        frame: ahead and left [m/s], and the interval T [s].
        follows: whether the path since the frame before is known; else `beside` stands for it.
        beside: `camera_left`.
        lean, nominal, memory: as in `motion.step`.
        h: the row, filled.
    """
    ahead, left, span_s = frame
    cos, sin, k = math.cos(x[CAMERA_YAW]), math.sin(x[CAMERA_YAW]), 1.0 + x[CAMERA_SCALE]
    u_y = x[ASIDE] / span_s if follows else beside
    h[:] = 0.0
    if follows:
        h[ASIDE] = k / span_s
    else:
        _by_left(x, lean, k, nominal, memory, h)
    h[CAMERA_SCALE], h[CAMERA_PULL] = u_y, 1.0
    h[CAMERA_YAW] += left * sin - ahead * cos
    return float(k * u_y + x[CAMERA_PULL] - left * cos - ahead * sin)


@array_law
def camera_stance(x: Array, memory: Record, h: Array) -> float:
    """Nose down on level ground, as the camera sees it, less what the body's pitch is [rad]."""
    sunk, nose = stance(x, 0.0, memory)
    h[:] = 0.0
    h[CAMERA_PITCH], h[CAMERA_YAW], h[PITCH] = 1.0, sunk, -1.0  # level ground: both are small
    return float(nose - x[PITCH])


@array_law
def one(state: int, h: Array) -> None:
    """The row of a state itself."""
    h[:] = 0.0
    h[state] = 1.0
