import subprocess
import sys
from dataclasses import fields, replace

import pytest

from tests.sensors.trajectories import AUX_M, IMU_M, MAIN_M, drive
from twin.sensors import Geometry, Gnss, Imu, Outage, Sensors, Wheels, setup, suite
from twin.streams import COLUMNS, Setup, check

GEOMETRY = Geometry(
    machine="tractor",
    wheelbase_m=2.7,
    track_front_m=1.7,
    track_rear_m=1.8,
    cg_x_m=1.1,
    wheel_radius_m={"fl": 0.62, "fr": 0.62, "rl": 0.83, "rr": 0.83},
    antenna_main_m=tuple(MAIN_M),
    antenna_aux_m=tuple(AUX_M),
    imu_m=tuple(IMU_M),
    depth_zero_m=1.0,
)

TRUE_ERRORS = {
    "wheels": {"radius_error": (0.05, 0.05, -0.05, 0.02)},
    "gnss": {
        "heading_bias_rad": 0.1,
        "lever_arm_error_m": (0.1, 0.2, 0.3),
        "latency_s": 0.3,
        "outages": (Outage(start_s=1, duration_s=5),),
    },
    "imu": {
        "gyro_bias_radps": (0.1, 0.1, 0.1),
        "accel_bias_mps2": (1.0, 1.0, 1.0),
        "scale_error": 0.02,
        "mounting_error_rad": (0.1, 0.1, 0.1),
    },
    "depth": {"laser_bias_m": 0.1, "inclination_bias_rad": 0.05},
    "machine": {"steer_bias_rad": 0.05, "draft_pin_scale_error": 0.1},
}


@pytest.mark.parametrize(
    ("sensor", "name"), [(s, n) for s, block in TRUE_ERRORS.items() for n in block]
)
def test_no_true_error_changes_a_bit_of_the_setup(sensor, name):
    nominal = Sensors()
    config = replace(getattr(nominal, sensor), **{name: TRUE_ERRORS[sensor][name]})
    wrong = replace(nominal, **{sensor: config})
    assert wrong != nominal
    assert setup(wrong, GEOMETRY).to_json() == setup(nominal, GEOMETRY).to_json()


def test_every_true_error_is_among_those_tested():
    for sensor, config in Sensors().fitted().items():
        named = {f.name for f in fields(config) if "bias" in f.name or "error" in f.name}
        assert {n for n in named if "_sd" not in n} <= set(TRUE_ERRORS[sensor])


def test_the_setup_is_the_data_sheets_and_the_tape_measures():
    told = setup(Sensors(), GEOMETRY)
    assert told.gnss.position_sd_m == pytest.approx((0.004**2 + 0.0065**2) ** 0.5)
    assert told.gnss.lever_arm_m == tuple(MAIN_M)
    assert told.gnss.heading_mount_rad == pytest.approx(-3.141592653589793 / 2)
    assert told.gnss.heading_sd_rad == pytest.approx(Gnss().heading_sd_rad_m / 1.0)
    assert told.imu.lever_arm_m == tuple(IMU_M)
    assert told.imu.gyro_noise_radps_rthz == Imu().gyro_noise_radps_rthz
    assert told.wheels.counts_per_turn == Wheels().lines * 4
    assert told.wheels.radius_m == GEOMETRY.wheel_radius_m
    assert told.depth.zero_m == 1.0
    assert Setup.from_json(told.to_json()) == told


def test_a_sensor_switched_off_is_not_told_of():
    told = setup(Sensors(gnss=None, wheels=None), GEOMETRY)
    assert told.gnss is None
    assert told.wheels is None
    assert told.imu is not None


OF_LOGS = {"engine_torque"}
"""Columns that only a log has: here engine_load is the torque over its reference."""


def test_the_streams_obey_the_contract():
    sensors = Sensors()
    _, streams = suite.sample(sensors, suite.init(sensors, 0), drive(2))
    check(streams)
    for name in ("gnss", "imu", "depth", "machine"):
        named = {"epoch_ns", "arrival_ns", *COLUMNS[name]} - OF_LOGS
        assert set(streams[name]) == named


def test_importing_the_sensors_imports_nothing_heavy():
    code = (
        "import sys, twin.sensors; "
        "print(*[m for m in ('scipy', 'mujoco', 'numba') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""
