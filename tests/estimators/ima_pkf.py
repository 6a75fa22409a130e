"""The sensors of the IMA-PKF paper's simulation: 50 Hz, noise as printed, all at one epoch."""

import numpy as np

from twin.streams import GnssSetup, ImuSetup, Streams, WheelsSetup
from twin.testing import drives as synthetic

SD = {"gnss": 0.13, "front": 0.10, "rear": 0.11, "accel": 0.06}
RATE_HZ = 50.0

SETUP = synthetic.setup(
    wheels=WheelsSetup(rate_hz=RATE_HZ, radius_m=synthetic.RADIUS_M),
    gnss=GnssSetup(
        rate_hz=RATE_HZ,
        lever_arm_m=(0.0, 0.0, 0.0),
        position_sd_m=0.01,
        velocity_sd_mps=SD["gnss"],
        heading_sd_rad=0.0,
    ),
    imu=ImuSetup(
        rate_hz=RATE_HZ,
        lever_arm_m=(0.0, 0.0, 0.0),
        gyro_noise_radps_rthz=0.0,
        accel_noise_mps2_rthz=SD["accel"] / RATE_HZ**0.5,
        gyro_bias_sd_radps=0.0,
        accel_bias_sd_mps2=0.0,
    ),
)


def tracks(seed: int):
    """Wheel speed 1.3-2.9 m/s and slip .06-.29, sines up to 1.2 Hz, as functions of time."""
    rng = np.random.default_rng(seed)
    phase = rng.uniform(0, 2 * np.pi, 6)

    def wheel(t):
        slow = 0.45 * np.sin(0.5 * t + phase[0]) + 0.2 * np.sin(1.4 * t + phase[1])
        return 2.1 + slow + 0.04 * np.sin(2 * np.pi * 1.2 * t + phase[2])

    def slip(t):
        slow = 0.07 * np.sin(0.6 * t + phase[3]) + 0.03 * np.sin(1.3 * t + phase[4])
        return 0.175 + slow + 0.01 * np.sin(2 * np.pi * 1.2 * t + phase[5])

    return wheel, slip


def streams(seed: int, bias_mps2: float = 0.0, wheel_accel: bool = True, duration_s: float = 30.0):
    """Streams of one trial, its times [s] and true slip."""
    rng = np.random.default_rng((7, seed))
    wheel, slip = tracks(seed)
    t = np.arange(1, int(duration_s * RATE_HZ) + 1) / RATE_HZ
    stamps = synthetic.stamps(t)

    def ground(at):
        return wheel(at) * (1 - slip(at))

    def noisy(values, source):
        return values + SD[source] * rng.standard_normal(len(values))

    biases = bias_mps2 * rng.standard_normal(2)
    accel = noisy(synthetic.derivative(ground, t), "accel") + biases[0]
    rear, front = noisy(wheel(t), "rear"), noisy(ground(t), "front")
    table = stamps | {
        "speed_fl_mps": front,
        "speed_fr_mps": front,
        "speed_rl_mps": rear,
        "speed_rr_mps": rear,
        "speed_sd_mps": np.full(t.shape, SD["rear"]),
    }
    if wheel_accel:
        accel_w = noisy(synthetic.derivative(wheel, t), "accel") + biases[1]
        table |= {"accel_rl_mps2": accel_w, "accel_rr_mps2": accel_w}
    gnss = stamps | {"v_east_mps": noisy(ground(t), "gnss"), "v_north_mps": 0 * t}
    gnss["heading_rad"] = 0 * t
    imu = stamps | {"accel_x_mps2": accel}
    return Streams({"gnss": gnss, "imu": imu, "wheels": table}), t, slip(t)
