"""Streams of a drive there and back over level ground, and of a slide across a slope."""

import numpy as np

from twin.streams import CameraSetup, GnssSetup, ImuSetup, Setup, Streams, WheelsSetup

SETUP = Setup(
    machine="slide",
    wheelbase_m=0.8,
    track_front_m=0.5,
    track_rear_m=0.5,
    cg_x_m=0.35,
    wheels=WheelsSetup(
        rate_hz=50.0, radius_m=dict.fromkeys(("fl", "fr", "rl", "rr"), 0.2), counts_per_turn=4000
    ),
    gnss=GnssSetup(
        rate_hz=20.0,
        lever_arm_m=(0.4, 0.28, 0.66),
        position_sd_m=0.01,
        velocity_sd_mps=0.03,
        heading_sd_rad=0.006,
        heading_mount_rad=-np.pi / 2,
    ),
    imu=ImuSetup(
        rate_hz=50.0,
        lever_arm_m=(0.35, 0.0, 0.05),
        gyro_noise_radps_rthz=1e-4,
        accel_noise_mps2_rthz=4e-3,
        gyro_bias_sd_radps=1e-3,
        accel_bias_sd_mps2=0.1,
    ),
    camera=CameraSetup(
        rate_hz=30.0,
        width_px=320,
        height_px=200,
        focal_px=320.0,
        lever_arm_m=(0.98, 0.0, 0.3),
        height_m=0.5,
    ),
)
LEG_S, PAUSE_S, SLIDE_S = 12.0, 6.0, 8.0
"""Straight on over level ground, there and back with a pause after each, then the slide."""
SPEED_MPS = 1.0


def across(slope_rad):
    """World from a plane that rises to the north."""
    cos, sin = np.cos(slope_rad), np.sin(slope_rad)
    return np.array([[1, 0, 0], [0, cos, -sin], [0, sin, cos]])


def slides(seed=0, slope_deg=9.0, slide_mps=-0.03, turn_radps=-0.02, masked=False, blind=False):
    """The streams, and the slides of centre of gravity and rear axle since the last pause.

    Heading bias, camera yaw and gyro bias are the seed's; `blind` has no camera frame used.
    """
    rng = np.random.default_rng(seed)
    heading_bias, camera_yaw = np.radians([0.2, 1.0]) * rng.standard_normal(2)
    gyro_bias, scale = 1e-3 * rng.standard_normal(), 1.0 + 0.002 * rng.standard_normal()
    accel_bias = 0.1 * rng.standard_normal(2)
    back = LEG_S + PAUSE_S
    begin = back + LEG_S + PAUSE_S
    end = begin + SLIDE_S

    def times(hz):
        t = np.arange(1, int(end * hz) + 1) / hz
        return t[(t <= LEG_S) | ((t >= back) & (t <= back + LEG_S)) | (t >= begin)]

    def state(t):
        on = t >= begin
        heading = np.where(on, (t - begin) * turn_radps, np.where(t >= back, np.pi, 0.0))
        return on, np.where(on, slide_mps, 0.0), np.where(on, turn_radps, 0.0), heading

    def stamps(t, late_s):
        epoch = np.round(t * 1e9).astype(np.int64)
        return {"epoch_ns": epoch, "arrival_ns": epoch + round(late_s * 1e9)}

    turned = {False: np.eye(3), True: across(np.radians(slope_deg))}

    t = times(50)
    on, v_y, rate, heading = state(t)
    tilt = np.where(on, 9.81 * turned[True][2, 1], 0.0)
    noise = 4e-3 * np.sqrt(50) * rng.standard_normal((2, len(t)))
    white = 1e-4 * np.sqrt(50) * rng.standard_normal((3, len(t)))
    arm = SETUP.imu.lever_arm_m[0]
    imu = stamps(t, 0.02) | {
        "gyro_x_radps": white[0],
        "gyro_y_radps": white[1],
        "gyro_z_radps": rate + gyro_bias + white[2],
        "accel_x_mps2": np.sin(heading) * tilt
        - rate * v_y
        - rate**2 * arm
        + accel_bias[0]
        + noise[0],
        "accel_y_mps2": np.cos(heading) * tilt + rate * SPEED_MPS + accel_bias[1] + noise[1],
    }
    ticks = np.floor(SPEED_MPS * t / (2 * np.pi * 0.2) * 4000).astype(np.int64)
    wheels = stamps(t, 0.005) | {f"ticks_{w}": ticks for w in ("fl", "fr", "rl", "rr")}

    t = times(20)
    on, v_y, rate, heading = state(t)
    arm = SETUP.gnss.lever_arm_m
    body = np.stack([SPEED_MPS - rate * arm[1], v_y + rate * arm[0], 0 * t])
    cos, sin = np.cos(heading), np.sin(heading)
    flat = np.stack([cos * body[0] - sin * body[1], sin * body[0] + cos * body[1], 0 * t], axis=1)
    world = np.array([turned[bool(o)] @ v for o, v in zip(on, flat, strict=True)])
    baseline = np.array(
        [turned[bool(o)] @ (np.sin(h), -np.cos(h), 0.0) for o, h in zip(on, heading, strict=True)]
    )
    azimuth = np.arctan2(baseline[:, 1], baseline[:, 0])
    world += 0.03 * rng.standard_normal(world.shape)
    hidden = on & masked
    gnss = stamps(t, 0.05) | {
        "v_east_mps": np.where(hidden, np.nan, world[:, 0]),
        "v_north_mps": np.where(hidden, np.nan, world[:, 1]),
        "v_up_mps": world[:, 2],
        "heading_rad": np.where(
            hidden, np.nan, azimuth + heading_bias + 0.006 * rng.standard_normal(len(t))
        ),
        "quality": np.where(hidden, 0, 4),
    }

    t = times(30)
    on, v_y, rate, _ = state(t)
    u_x, u_y = SPEED_MPS + 0 * t, v_y + 0.98 * rate
    cos, sin = np.cos(camera_yaw), np.sin(camera_yaw)
    seen = scale * np.stack([cos * u_x + sin * u_y, cos * u_y - sin * u_x])
    seen += 0.5e-3 * rng.standard_normal(seen.shape)
    used = np.ones(len(t), bool) & (not blind)
    camera = stamps(t, 0.06) | {
        "frame": np.arange(len(t)),
        "v_x_mps": np.where(used, seen[0], np.nan),
        "v_y_mps": np.where(used, seen[1], np.nan),
        "var_x_m2ps2": np.full(len(t), 0.25e-6 + 1e-4),
        "var_y_m2ps2": np.full(len(t), 0.25e-6),
        "cov_xy_m2ps2": np.zeros(len(t)),
        "used": used,
    }
    streams = Streams({"gnss": gnss, "imu": imu, "wheels": wheels, "camera": camera})
    rear_m = slide_mps * SLIDE_S
    return streams, rear_m + 0.35 * turn_radps * SLIDE_S, rear_m, begin
