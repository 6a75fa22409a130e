"""A real vehicle that corners and slides, as driven: the angle against that of its navigation.

Its receiver is a fused solution, so velocity and heading agree to a few mrad.
"""

from pathlib import Path

import numpy as np
import pytest

from estimators.sideslip_ekf import SideslipEkf
from twin import logs

LOG = Path(__file__).parents[4] / "shared" / "data" / "four_wheel_drive.csv"
MAP = """
[log]
time = {column = "time_s", unit = "s"}
fastest_kmh = 130
[gnss]
east = {column = "east_m", unit = "m"}
north = {column = "north_m", unit = "m"}
speed = {column = "speed_mps", unit = "m/s"}
course = {column = "course_deg", unit = "deg", convention = "east"}
heading = {column = "heading_deg", unit = "deg", convention = "east"}
[imu]
gyro_z = {column = "yaw_rate_radps", unit = "rad/s"}
[wheels]
speed_fl = {column = "wheel_fl_kmh", unit = "km/h"}
speed_fr = {column = "wheel_fr_kmh", unit = "km/h"}
speed_rl = {column = "wheel_rl_kmh", unit = "km/h"}
speed_rr = {column = "wheel_rr_kmh", unit = "km/h"}
[reference]
sideslip_angle = {column = "reference_sideslip_deg", unit = "deg"}
[setup]
machine = "four-wheel vehicle"
wheelbase_m = 2.97
track_front_m = 1.64
track_rear_m = 1.52
cg_x_m = 1.25
[setup.gnss]
rate_hz = 25.0
lever_arm_m = [1.25, 0.0, 0.0]
position_sd_m = 0.02
velocity_sd_mps = 0.03
heading_sd_rad = 0.002
[setup.imu]
rate_hz = 25.0
"""
FASTER_THAN_MPS = 5.0

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not LOG.exists(), reason=f"{LOG.name} is not at hand"),
]


def test_the_angle_is_within_half_a_degree_and_its_sd_is_honest(tmp_path):
    (tmp_path / "map.toml").write_text(MAP)
    log = logs.read(LOG, tmp_path / "map.toml")
    own = SideslipEkf()
    _, told = own.run(own.init(log.setup), log.streams)
    start = log.reference["epoch_ns"][0]
    at, known = (t["epoch_ns"] - start for t in (told, log.reference))
    true = np.interp(at, known, log.reference["sideslip_rad"])
    error = told["sideslip_rad"] - true
    scored = np.isfinite(error) & (told["speed_mps"] > FASTER_THAN_MPS)
    error, sd = np.degrees(error[scored]), np.degrees(told["sideslip_sd_rad"][scored])
    inside = np.mean(np.abs(error) <= 2.0 * sd)
    print(f"{np.sqrt(np.mean(error**2)):.3f} degrees rms, {100 * inside:.1f} % within 2 sd")
    assert scored.sum() > 10_000
    assert np.sqrt(np.mean(error**2)) < 0.5
    assert 0.85 < inside < 0.995
