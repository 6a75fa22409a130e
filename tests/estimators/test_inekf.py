"""The invariant filter: its group, its Jacobians by finite differences, what it is right about."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimators.inekf import INEKF, group, motion, rows
from estimators.inekf.layout import MEMORY, SIZE, SLIP, TUNING, VELOCITY
from estimators.layout import NOMINAL, nominal
from twin.streams import Streams
from twin.testing import drives
from twin.testing.checks import SETUP

STEP = 1e-6
AXES = np.eye(SIZE)
MOUNTED = dataclasses.replace(
    SETUP,
    gnss=dataclasses.replace(SETUP.gnss, lever_arm_m=(0.7, 0.4, 2.1), heading_mount_rad=-1.5),
    imu=dataclasses.replace(SETUP.imu, lever_arm_m=(0.6, -0.1, 0.5)),
)


@pytest.fixture
def nominal_record():
    return np.array([nominal(MOUNTED)], NOMINAL)


@pytest.fixture
def tuning():
    return np.array([dataclasses.astuple(INEKF)], TUNING)


def state(seed=3):
    """Somewhere on a slope, in a curve, slipping."""
    rng = np.random.default_rng(seed)
    memory = np.zeros(1, MEMORY)
    memory["world_from_body"][0] = Rotation.from_euler("ZYX", [0.8, -0.1, 0.15]).as_matrix()
    memory["v"][0], memory["u"][0] = rng.normal(0.0, 1.5, 3), rng.normal(0.0, 0.3, 3)
    memory["gyro_bias"][0], memory["accel_bias"][0] = rng.normal(0, 0.01, 3), rng.normal(0, 0.1, 3)
    memory["gyro"][0], memory["accel"][0] = rng.normal(0.0, 0.3, 3), [0.4, -0.3, 9.7]
    memory["front_scale"][0] = -0.03
    memory["p"][0] = 0.01 * np.eye(SIZE)
    return memory


def moved(memory, xi):
    """Exp(xi) X, and the biases plus their errors."""
    out = memory.copy()
    turned = Rotation.from_rotvec(xi[:3]).as_matrix()
    jacobian = group.left_jacobian(xi[:3].copy())
    out["world_from_body"][0] = turned @ memory["world_from_body"][0]
    out["v"][0] = turned @ memory["v"][0] + jacobian @ xi[VELOCITY : VELOCITY + 3]
    out["u"][0] = turned @ memory["u"][0] + jacobian @ xi[SLIP : SLIP + 3]
    out["gyro_bias"][0] += xi[9:12]
    out["accel_bias"][0] += xi[12:15]
    out["front_scale"][0] += xi[15]
    return out


def apart(memory, other):
    """xi with other = Exp(xi) memory, for what is near."""
    turned = other["world_from_body"][0] @ memory["world_from_body"][0].T
    phi = Rotation.from_matrix(turned).as_rotvec()
    back = np.linalg.inv(group.left_jacobian(phi))
    return np.concatenate([
        phi,
        back @ (other["v"][0] - turned @ memory["v"][0]),
        back @ (other["u"][0] - turned @ memory["u"][0]),
        other["gyro_bias"][0] - memory["gyro_bias"][0],
        other["accel_bias"][0] - memory["accel_bias"][0],
        other["front_scale"] - memory["front_scale"],
    ])  # fmt: skip


@pytest.mark.parametrize("phi", [[0.3, -0.8, 0.5], [1e-9, 0.0, -2e-9], [0.0, 0.0, 3.0]])
def test_the_exponential_is_that_of_rotations(phi):
    phi = np.array(phi)
    assert group.rotation(phi) == pytest.approx(Rotation.from_rotvec(phi).as_matrix(), abs=1e-12)


def test_the_left_jacobian_is_the_integral_of_the_exponential():
    phi = np.array([0.3, -0.8, 0.5])
    shares = (np.arange(2000) + 0.5) / 2000
    mean = np.mean([group.rotation(share * phi) for share in shares], axis=0)
    assert group.left_jacobian(phi) == pytest.approx(mean, abs=1e-6)


def test_an_attitude_from_the_vertical():
    world_from_body = Rotation.from_euler("ZYX", [0.7, 0.1, -0.2]).as_matrix()
    assert group.attitude(0.7, world_from_body[2].copy()) == pytest.approx(world_from_body)


@pytest.mark.parametrize(
    ("row", "told"),
    [
        (rows.along, (0, True)), (rows.along, (0, False)), (rows.along, (1, True)),
        (rows.along, (2, False)), (rows.towed, ()),
        (rows.antenna, (0,)), (rows.antenna, (1,)), (rows.antenna, (2,)),
        (rows.heading, ()), (rows.lean, (0,)), (rows.lean, (1,)),
    ],
)  # fmt: skip
@pytest.mark.parametrize("missing", [[], [0, 1]])
def test_rows_are_the_derivatives_of_what_is_measured(row, told, missing, nominal_record):
    here = state()
    here["gyro"][0, missing] = np.nan
    given = (*told, nominal_record[0]) if row is not rows.lean else told

    def measured(xi):
        return row(*given, moved(here, xi)[0], np.zeros(SIZE))

    h = np.zeros(SIZE)
    row(*given, here[0], h)
    slope = [(measured(STEP * a) - measured(-STEP * a)) / (2 * STEP) for a in AXES]
    assert h == pytest.approx(slope, abs=1e-7)


@pytest.mark.parametrize("missing", [(), (2,), (0, 1, 2)])
def test_the_error_moves_by_its_law(nominal_record, tuning, missing):
    """The transition is the derivative of the step, but for what is of the third order in it."""
    dt = 2e-3
    here = state()
    here["accel"][0, list(missing)] = np.nan
    here["gyro"][0, list(missing)] = np.nan

    def stepped(xi):
        memory = moved(here, xi)
        motion.carry(dt, nominal_record[0], tuning[0], memory[0])
        return memory

    law, _ = motion.law(nominal_record[0], tuning[0], here[0])
    foretold = motion.transition(law, dt)
    there = stepped(np.zeros(SIZE))
    size = 1e-5
    columns = [(apart(there, stepped(size * a)) - apart(there, stepped(-size * a))) / (2 * size)
               for a in AXES]  # fmt: skip
    error = np.array(columns).T - foretold
    assert np.abs(error).max() < 2e-5
    if not missing:
        assert np.abs(error[:9, :9]).max() < 1e-8  # without the biases it is exact


def test_the_error_law_does_not_depend_on_the_attitude_or_the_velocity(nominal_record, tuning):
    """What makes it invariant, but for the columns of the biases."""
    first, _ = motion.law(nominal_record[0], tuning[0], state(1)[0])
    other = state(2)
    other["world_from_body"][0] = Rotation.from_euler("ZYX", [-2.0, 0.3, 0.1]).as_matrix()
    second, _ = motion.law(nominal_record[0], tuning[0], other[0])
    assert first[:, :9] == pytest.approx(second[:, :9], abs=1e-12)
    assert first[:, 9:] != pytest.approx(second[:, 9:])


def test_noise_enters_where_the_measured_rates_do(nominal_record, tuning):
    """The columns of B are those of A for the biases, times the root of the density."""
    law, noise = motion.law(nominal_record[0], tuning[0], state()[0])
    assert noise[:9, :3] == pytest.approx(law[:9, 9:12] * np.sqrt(INEKF.gyro_psd_rad2ps))
    assert noise[:9, 3:6] == pytest.approx(law[:9, 12:15] * np.sqrt(INEKF.accel_psd_m2ps3))


def estimated(streams, setup=SETUP):
    return INEKF.run(INEKF.init(setup), streams)[1]


def test_where_north_is_does_not_matter():
    """Turning the world turns nothing in the body."""
    drive = drives.Drive(duration_s=8.0)
    here = drives.streams(drive, SETUP, 4)
    angle = 2.0
    gnss = dict(here["gnss"])
    east, north = gnss["v_east_mps"], gnss["v_north_mps"]
    gnss["v_east_mps"] = np.cos(angle) * east - np.sin(angle) * north
    gnss["v_north_mps"] = np.sin(angle) * east + np.cos(angle) * north
    gnss["heading_rad"] = gnss["heading_rad"] + angle
    there = Streams({**here.tables, "gnss": gnss})
    for column in ("slip", "slip_sd", "sideslip_rad", "speed_mps"):
        first, second = estimated(here)[column], estimated(there)[column]
        assert second == pytest.approx(first, abs=1e-3, nan_ok=True)  # one axis at a time


def test_without_noise_speed_slip_and_sideslip_are_right():
    drive = drives.Drive(duration_s=20.0, noise=0.0)
    table = estimated(drives.streams(drive, SETUP))
    t = drives.seconds(table["epoch_ns"])
    late = t > 5.0
    assert np.abs(table["slip"] - drive.slip(t))[late].max() < 0.01
    assert np.abs(table["speed_mps"] - drive.speed(t))[late].max() < 0.01
    assert np.abs(table["sideslip_rad"])[late].max() < 1e-3


def test_a_slope_is_attitude_and_no_bias():
    """Up 8 degrees: the accelerometer feels g sin 8, and the body sees up elsewhere."""
    grade = np.radians(8.0)
    drive = drives.Drive(duration_s=30.0, pitch=lambda t: grade + 0.0 * t)
    flat = drives.streams(dataclasses.replace(drive, pitch=lambda t: 0.0 * t), SETUP, 2)
    gnss, imu = dict(flat["gnss"]), dict(flat["imu"])
    gnss["v_up_mps"] = gnss["v_up_mps"] + np.sin(grade) * drive.speed(drives.times(drive, 20.0))
    for name in ("v_east_mps", "v_north_mps"):
        gnss[name] = gnss[name] * np.cos(grade)
    imu["accel_x_mps2"] = imu["accel_x_mps2"] + 9.81 * np.sin(grade)
    imu["accel_z_mps2"] = imu["accel_z_mps2"] - 9.81 * (1.0 - np.cos(grade))
    table = estimated(Streams({**flat.tables, "gnss": gnss, "imu": imu}))
    t = drives.seconds(table["epoch_ns"])
    error = (table["slip"] - drive.slip(t))[t > 10.0]
    assert abs(error.mean()) < 0.005


def test_without_gnss_it_goes_on_with_wheels_and_inertial_unit():
    """The front wheels tell the speed, as the paper's wheels do."""
    drive = drives.Drive(duration_s=12.0)
    streams = drives.streams(drive, SETUP, 1)
    rest = {k: v[: 20 * 4] for k, v in streams["gnss"].items()}  # four seconds of it
    table = estimated(Streams({**streams.tables, "gnss": rest}))
    t = drives.seconds(table["epoch_ns"])
    assert np.sqrt(np.mean((table["slip"] - drive.slip(t))[t > 6.0] ** 2)) < 0.02


def test_the_stated_sd_of_slip_is_that_of_its_errors():
    steady = drives.Drive(
        duration_s=20.0, speed=lambda t: 1.6 + 0.0 * t, slip=lambda t: 0.12 + 0.0 * t
    )
    squares = []
    for seed in range(8):
        table = estimated(drives.streams(steady, SETUP, seed))
        late = drives.seconds(table["epoch_ns"]) > 5.0
        squares.append(np.mean(((table["slip"] - 0.12) / table["slip_sd"])[late] ** 2))
    assert 0.02 < np.mean(squares) < 1.3  # its noises allow for more motion than there is
