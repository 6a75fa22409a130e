"""The parts of the slip filter: its Jacobians, its prediction, and what it learns on its way."""

import dataclasses

import numpy as np
import pytest

from estimators.layout import CAMERA as CAMERA_SENSOR
from estimators.layout import GNSS, IMU, NOMINAL, SIGNALS, WHEELS, blank, nominal
from estimators.slip_ekf import SLIP_EKF, motion, rows
from estimators.slip_ekf.brixius import slip_of, traction
from estimators.slip_ekf.filter import measure
from estimators.slip_ekf.held import FIRST_LOAD, HELD, PLOUGH, TORQUE, held, start
from estimators.slip_ekf.layout import (
    BIAS,
    BIAS_RATE,
    CAMERA,
    FROM_DRIVEN,
    FROM_GNSS,
    FROM_TOWED,
    RADIUS,
    REAR,
    SIZE,
    TOWED,
    TRACTION,
    UNLOADED_SLIP,
    A,
    V,
    W,
    first_memory,
)
from estimators.slip_ekf.load import centred, learn_line
from estimators.slip_ekf.report import _conflict
from estimators.slip_ekf.smooth import SLIP_EKF_SMOOTH
from estimators.slip_ekf.unloaded import (
    CARRIED,
    CARRIED_SD,
    MOVED,
    MOVED_SD,
    REAR_SHARE,
    take_plough,
)
from estimators.slip_ekf.wheels import yawing
from twin.streams import Streams
from twin.testing.drives import Drive, seconds, setup, stamps, streams, times

RIM = 2.0
STEP = 1e-6
TUNING = SLIP_EKF.init(setup()).tuning[0]

MEASURED = {
    "gnss": lambda x, h: rows.gnss(x, 0.1, h),
    "camera": lambda x, h: rows.camera(x, 0.1, h),
    "accel": rows.accel,
    "towed": lambda x, h: rows.towed(x, 0.05, 0.9, h),
    "driven": lambda x, h: rows.driven(x, RIM, 0.05, h),
    "wheel_accel": rows.wheel_accel,
    "expected": lambda x, h: rows.expected(x, 0.4, RIM, h),
    "no_slip": lambda x, h: rows.no_slip(x, RIM, h),
    "wheel_speed": lambda x, h: rows.wheel_speed(x, RIM, h),
    "travel": lambda x, h: rows.travel(x, REAR, 1.9, h),
}


def a_state(seed=1):
    x = 0.05 * np.random.default_rng(seed).standard_normal(SIZE)
    x[V], x[W] = 1.7, RIM - RIM * x[12]  # so that the averaged rim speed is the one of now
    return x


def gradient(of, x):
    """Central differences of a function of the state, (m, SIZE)."""
    found = []
    for j in range(SIZE):
        up, down = x.copy(), x.copy()
        up[j] += STEP
        down[j] -= STEP
        found.append((np.atleast_1d(of(up)) - np.atleast_1d(of(down))) / (2.0 * STEP))
    return np.array(found).T


@pytest.mark.parametrize("name", MEASURED)
def test_every_row_is_the_gradient_of_what_is_measured(name):
    x, h = a_state(), np.zeros(SIZE)
    MEASURED[name](x, h)
    unused = np.zeros(SIZE)
    found = gradient(lambda at: MEASURED[name](at, unused), x)[0]
    if name == "no_slip":  # the averaged speed is the gradient of both
        assert h[RADIUS] == h[UNLOADED_SLIP] == -RIM
        found[[RADIUS, UNLOADED_SLIP]] = -RIM
    if name == "wheel_speed":
        found[RADIUS] = h[RADIUS]
        assert h[RADIUS] == pytest.approx(-RIM, rel=0.1)
    if name == "expected":  # by traction that at the mean load, and the averaged speed
        found[TRACTION] = RIM * slip_of(x[TRACTION])[1]
    assert h == pytest.approx(found, abs=1e-7)


@pytest.mark.parametrize("front_turn_mps", [0.0, 1.2])
def test_the_transition_is_the_gradient_of_the_step(front_turn_mps):
    def after(x):
        moved, unused = x.copy(), np.zeros((SIZE, SIZE))
        motion.step(moved, RIM, front_turn_mps, 1.0, 0.02, TUNING, unused)
        return moved

    x, f = a_state(), np.zeros((SIZE, SIZE))
    motion.step(x.copy(), RIM, front_turn_mps, 1.0, 0.02, TUNING, f)
    found = gradient(after, x)
    assert f == pytest.approx(found, abs=1e-7)


def test_the_sparse_prediction_is_the_dense_one():
    rng = np.random.default_rng(2)
    f, q = np.zeros((SIZE, SIZE)), np.zeros((SIZE, SIZE))
    motion.step(a_state(), RIM, 0.4, 1.0, 0.02, TUNING, f)
    motion.noise(f, 0.2, 0.1, 0.05, 1e-4, 1e-5, 0.3, 1e-5, 1.0, 0.02, TUNING, q)
    root = rng.standard_normal((SIZE, SIZE))
    p = root @ root.T
    due = f @ p @ f.T + q
    motion.propagate_covariance(p, f, q, np.zeros((SIZE, SIZE)))
    assert p == pytest.approx(due, rel=1e-12)
    assert np.array_equal(p, p.T)
    assert np.all(np.linalg.eigvalsh(q) > -1e-15)


def estimated(made, of=None):
    of = of or setup()
    state, table = SLIP_EKF.run(SLIP_EKF.init(of), made)
    return state.memory[0], table


def rms(table, drive, after_s):
    t = seconds(table["epoch_ns"])
    return float(np.sqrt(np.mean((table["slip"] - drive.slip(t))[t > after_s] ** 2)))


DRIVE = Drive(duration_s=40.0)


def read_late(made, sd_s):
    """Counters that are read at instants off their stamps by so much."""
    table = dict(made["wheels"])
    t = seconds(table["epoch_ns"])
    late = sd_s * np.random.default_rng(3).standard_normal(len(t))
    for wheel in ("fl", "fr", "rl", "rr"):
        ticks = table[f"ticks_{wheel}"]
        table[f"ticks_{wheel}"] = np.floor(np.interp(t + late, t, ticks)).astype(np.int64)
    return Streams({**made.tables, "wheels": table})


@pytest.mark.parametrize(("sd_ms", "share"), [(0.5, 1.15), (1.0, 1.3), (5.0, 5.0)])
def test_instants_of_reading_that_nobody_tells_of_are_learnt(sd_ms, share):
    made = streams(DRIVE, setup())
    _, plain = estimated(made)
    memory, table = estimated(read_late(made, 1e-3 * sd_ms))
    assert rms(table, DRIVE, 10.0) < share * rms(plain, DRIVE, 10.0) + 2e-4
    assert np.sqrt(memory["jitter_var"]) == pytest.approx(1e-3 * sd_ms, rel=0.5)


@pytest.mark.parametrize("every", [4, 20])
def test_a_speed_carried_onto_faster_rows_is_not_new(every):
    made = streams(DRIVE, setup())
    kept = np.arange(0, len(made["gnss"]["epoch_ns"]), every)
    blank = {name: column[kept] for name, column in made["gnss"].items()}
    epoch_ns = made["wheels"]["epoch_ns"][every * 3 :]
    last = np.searchsorted(blank["epoch_ns"], epoch_ns, side="right") - 1
    carried = {name: column[last] for name, column in blank.items()} | {
        "epoch_ns": epoch_ns,
        "arrival_ns": epoch_ns,
    }
    _, due = estimated(Streams({**made.tables, "gnss": blank}))
    _, table = estimated(Streams({**made.tables, "gnss": carried}))
    assert rms(table, DRIVE, 5.0) < 1.1 * rms(due, DRIVE, 5.0) + 5e-4


@pytest.mark.parametrize("off_mps", [0.1, 0.3])
def test_a_receiver_that_is_off_for_two_seconds_moves_nothing(off_mps):
    made = streams(DRIVE, setup())
    t = seconds(made["gnss"]["epoch_ns"])
    off = off_mps * ((t > 15.0) & (t % 10.0 < 2.0))
    gnss = dict(made["gnss"])
    gnss["v_east_mps"] = gnss["v_east_mps"] + off * np.cos(DRIVE.heading_rad)
    gnss["v_north_mps"] = gnss["v_north_mps"] + off * np.sin(DRIVE.heading_rad)
    _, plain = estimated(made)
    _, table = estimated(Streams({**made.tables, "gnss": gnss}))
    assert rms(table, DRIVE, 5.0) < 2.0 * rms(plain, DRIVE, 5.0)


@pytest.mark.parametrize("imu", [True, False])
@pytest.mark.parametrize("accel_mps2", [0.5, 2.0])
def test_a_start_in_a_curve_teaches_nothing_wrong(imu, accel_mps2):
    """Front wheels roll further in a curve, and the driven ones slip as they start."""
    of = setup()
    drive = Drive(
        duration_s=40.0,
        speed=lambda t: np.clip((t - 8.0) * accel_mps2, 0.0, 2.0),
        slip=lambda t: 0.1 * ((t > 8.0) & (t < 8.0 + 2.0 / accel_mps2)),
    )
    made = streams(drive, of)
    t = seconds(made["wheels"]["epoch_ns"])
    yaw_rate = drive.speed(t) / 6.0 * (t < 25.0)
    wheels = dict(made["wheels"])
    for wheel, side in (("fl", -1), ("fr", 1), ("rl", -1), ("rr", 1)):
        v = drive.speed(t) + side * 0.5 * of.track_rear_m * yaw_rate
        v = np.hypot(v, of.wheelbase_m * yaw_rate) if wheel[0] == "f" else v / (1 - drive.slip(t))
        radius = of.wheels.radius_m[wheel]
        way = np.cumsum(v) * 0.02
        wheels[f"ticks_{wheel}"] = np.floor(way / radius / (2 * np.pi) * 4000).astype(np.int64)
    tables = {**made.tables, "wheels": wheels}
    if imu:
        at = seconds(made["imu"]["epoch_ns"])
        tables["imu"] = made["imu"] | {"gyro_z_radps": np.interp(at, t, yaw_rate)}
    else:
        del tables["imu"]
    _, table = estimated(Streams(tables), of)
    at = seconds(table["epoch_ns"])
    steady = at > 8.0 + 2.0 / accel_mps2 + 0.5
    assert np.abs(table["slip"])[steady].max() < 0.05


@pytest.mark.parametrize("scale", [0.7, 1.0, 1.4])
def test_a_camera_of_unknown_height_harms_nothing(scale):
    made = streams(DRIVE, setup())
    t = times(DRIVE, 30.0)
    rng = np.random.default_rng(5)
    walks = scale + 0.1 * np.sin(0.3 * t)
    camera = stamps(t, 0.05) | {
        "v_x_mps": walks * DRIVE.speed(t) + 0.004 * rng.standard_normal(len(t)),
        "v_y_mps": 0.0 * t, "var_x_m2ps2": np.full_like(t, 0.004**2),
        "interval_s": np.full_like(t, 1.0 / 30.0), "used": np.ones_like(t),
    }  # fmt: skip
    _, without = estimated(made)
    memory, table = estimated(Streams({**made.tables, "camera": camera}))
    assert rms(table, DRIVE, 5.0) < 1.15 * rms(without, DRIVE, 5.0)
    assert memory["x"][CAMERA] == pytest.approx(walks[-1] - 1.0, abs=0.06)


def test_slip_follows_the_load_when_gnss_is_gone():
    """The draft makes the slip; the machine's bus tells the draft, and nobody else does then."""

    def slip(t):
        return -np.log(0.35 - 0.12 * np.sin(0.37 * t)) / 7.5  # traction in proportion to the draft

    pull = Drive(duration_s=100.0, speed=lambda t: 1.9 * (1.0 - slip(t)), slip=slip)
    made = streams(pull, setup())
    seen = seconds(made["gnss"]["epoch_ns"]) < 50.0
    t = times(pull, 10.0)
    machine = stamps(t) | {"draft_pin_n": 2e4 + 1e4 * np.sin(0.37 * t)}
    wheels = {n: c for n, c in made["wheels"].items() if n not in ("ticks_fl", "ticks_fr")}
    blind = {
        "gnss": {name: column[seen] for name, column in made["gnss"].items()},
        "wheels": wheels,
    }
    _, alone = estimated(Streams(blind))
    memory, table = estimated(Streams({**blind, "machine": machine}))
    assert rms(table, pull, 52.0) < 0.012
    assert rms(table, pull, 52.0) < 0.5 * rms(alone, pull, 52.0)
    assert memory["line"][FIRST_LOAD] == pytest.approx(0.12, abs=0.02)


def test_what_slower_sensors_said_is_held_in_any_chunks():
    made = streams(Drive(duration_s=3.0), setup())
    t = np.array([0.5, 1.0, 1.5, 2.0])
    machine = stamps(t) | {"draft_pin_n": np.array([1e4, np.nan, 3e4, 2e4])}
    depth = stamps(t) | {"laser_m": np.array([1.2, 1.0, 0.98, 0.7])}
    of = dataclasses.replace(setup(), depth=None)
    both = Streams({**made.tables, "machine": machine, "depth": depth})
    _, whole = held(dataclasses.replace(start(of), zero_m=1.0), both)
    state, parts = dataclasses.replace(start(of), zero_m=1.0), []
    for chunk in both.chunks(7):
        state, part = held(state, chunk)
        parts.append(part)
    assert np.array_equal(np.concatenate(parts), whole, equal_nan=True)
    assert whole.shape == (len(made), HELD)
    assert {1.0, 3.0, 2.0} == set(whole[np.isfinite(whole[:, FIRST_LOAD]), FIRST_LOAD])
    assert {1.0, 0.0} == set(whole[np.isfinite(whole[:, PLOUGH]), PLOUGH])
    assert np.isnan(whole[0]).all()


@pytest.mark.parametrize("chunk", [None, 50])
def test_what_a_slower_sensor_said_long_ago_is_not_known(chunk):
    """Silent since the plough was raised, it must not tell that no wheel slips."""
    made = streams(Drive(duration_s=12.0), setup())
    t = np.array([0.5, 1.0])
    machine = stamps(t) | {"draft_pin_n": np.array([1e4, 3e4])}
    depth = stamps(t) | {"laser_m": np.array([1.2, 1.2])}
    both = Streams({**made.tables, "machine": machine, "depth": depth})
    state, parts = dataclasses.replace(start(setup()), zero_m=1.0), []
    for part in both.chunks(chunk) if chunk else [both]:
        state, known = held(state, part)
        parts.append(known)
    known = np.concatenate(parts)
    t = seconds(np.sort(np.concatenate([table["epoch_ns"] for table in made.tables.values()])))
    fresh = (t > 1.0) & (t < 5.99)
    assert np.all(known[fresh, PLOUGH] == 1.0)
    assert np.all(known[fresh, FIRST_LOAD] == 3.0)
    assert np.isnan(known[t > 6.01]).all()


def at_speed(time_s=20.0, speed_mps=2.0):
    """A memory that knows the speed well, as the towed wheels and an accelerometer tell it."""
    memory = first_memory(0.03)[0]
    memory["known"], memory["time_ns"] = 1, round(time_s * 1e9)
    memory["x"][[V, W]], memory["rim_mps"] = speed_mps, speed_mps
    memory["p"] = 1e-3 * np.eye(SIZE)
    memory["accel_count"], memory["accel_ns"] = 1, memory["time_ns"]
    for source in (FROM_TOWED, FROM_DRIVEN):
        memory["seen_ns"][source], memory["seen_mps"][source] = memory["time_ns"], speed_mps
    return memory


def one_signal(sensor, epoch_ns, **values):
    signal = blank(SIGNALS, 1)[0]
    signal["sensor"], signal["epoch_ns"], signal["flags"] = sensor, epoch_ns, 0
    signal["yaw_rate_radps"] = signal["pitch_rate_radps"] = 0.0
    for name, value in values.items():
        signal[name] = value
    return signal


def measured(signal, memory, of=None):
    """Have the filter take a sample, and nothing of the plough or the load."""
    nominal_values = np.array([nominal(of or setup())], NOMINAL)[0]
    measure(signal, np.full(HELD, np.nan), np.zeros(SIZE), nominal_values, TUNING, memory)


def test_what_gnss_was_off_by_before_an_outage_is_forgotten():
    """Its first sample then is refused as any other is, and not believed at once."""
    memory = at_speed()
    memory["seen_ns"][FROM_GNSS], memory["refused_ns"][FROM_GNSS] = 5_000_000_000, 4_000_000_000
    memory["seen_mps"][FROM_GNSS], memory["mean_error_mps"][FROM_GNSS] = 2.8, 0.8
    assert _conflict(memory) == 0.0
    told = {"v_x_mps": 1.0, "horizontal_mps": 1.0, "v_sd_mps": 0.03}
    measured(one_signal(GNSS, memory["time_ns"], **told), memory)
    assert memory["x"][V] == 2.0
    assert memory["refused_ns"][FROM_GNSS] == memory["time_ns"]
    assert memory["mean_error_mps"][FROM_GNSS] == -1.0


def test_a_restart_forgets_what_was_refused():
    state = SLIP_EKF.init(setup())
    made = streams(DRIVE, setup())
    memory = state.memory[0]
    memory["refused_ns"], memory["mean_innovation_ns"] = 5, 5
    memory["time_ns"], memory["known"] = 10, 1
    late = {
        sensor: table | {name: table[name] + 10**10 for name in ("epoch_ns", "arrival_ns")}
        for sensor, table in made.tables.items()
    }
    after, _ = SLIP_EKF.run(state, Streams(late).samples(0, 1))
    assert np.all(after.memory[0]["refused_ns"] == -1)
    assert after.memory[0]["mean_innovation_ns"] == -1


def turned_bias(steps_s, rate_radps=0.2, gravity=True):
    """Bias and its variance [m/s2] after a body turns nose down, as a gyro tells at such steps."""
    of = setup()
    of = dataclasses.replace(of, imu=dataclasses.replace(of.imu, gravity=gravity))
    memory, t = at_speed(), 20.0
    for step_s in (0.0, *steps_s):
        t += step_s
        memory["time_ns"] = round(t * 1e9)
        measured(one_signal(IMU, memory["time_ns"], gyro_y_radps=rate_radps), memory, of)
    return memory["x"][BIAS], memory["p"][BIAS, BIAS], memory["p"][BIAS_RATE, BIAS_RATE]


def test_gravity_that_does_not_leak_is_not_turned():
    assert turned_bias([0.02] * 10)[0] == pytest.approx(-9.81 * 0.04)
    assert turned_bias([0.02] * 10, gravity=False) == (0.0, 1e-3, 0.0)


@pytest.mark.parametrize("step_s", [0.02, 0.2, 0.4])
def test_a_slow_gyro_turns_the_body_as_far(step_s):
    bias, variance, _ = turned_bias([step_s] * 3)
    assert bias == pytest.approx(-9.81 * 0.2 * 3 * step_s)
    assert variance == 1e-3


def test_after_a_gap_of_the_gyro_the_body_s_pitch_is_as_unknown_as_at_first():
    bias, variance, _ = turned_bias([2.0])
    assert bias == 0.0
    assert variance == pytest.approx(1e-3 + SLIP_EKF.gravity_sd**2)
    assert turned_bias([2.0], gravity=False)[1] == 1e-3


def counted_wheels(epoch_ns, speed_mps=2.0, **values):
    """A sample of all four wheels, counted over 20 ms."""
    told = {"wheel_mps": speed_mps, "wheel_sd_mps": 0.02, "wheel_age_s": 0.01}
    return one_signal(WHEELS, epoch_ns, **(told | values))


@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize(("late_ns", "due"), [(0, 1), (7_000_000, 0)])
def test_a_late_count_is_no_origin_of_a_travel(known, late_ns, due):
    memory = at_speed()
    memory["known"] = known
    measured(counted_wheels(memory["time_ns"] - late_ns), memory)
    assert memory["known"] == 1
    assert list(memory["unbroken"]) == [due, due]


@pytest.mark.parametrize("gyro", [True, False])
@pytest.mark.parametrize("speed_mps", [2.0, -2.0])
@pytest.mark.parametrize("steer_deg", [-40.0, 0.0, 40.0])
def test_a_start_in_a_curve_has_the_speed_of_the_rear_axle(gyro, speed_mps, steer_deg):
    of, memory = setup(), at_speed()
    memory["known"] = 0
    yaw_rate = speed_mps * np.tan(np.radians(steer_deg)) / of.wheelbase_m
    difference = 0.5 * yaw_rate * np.array([-of.track_front_m, of.track_front_m])
    front = np.sign(speed_mps) * np.hypot(speed_mps + difference, of.wheelbase_m * yaw_rate)
    wheels = np.append(front, speed_mps + difference)
    told = {"yaw_rate_radps": yaw_rate if gyro else 0.0, "wheel_sd_mps": 0.005}
    measured(counted_wheels(memory["time_ns"], wheel_mps=wheels, **told), memory, of)
    error, sd = memory["x"][V] - speed_mps, np.sqrt(memory["p"][V, V])
    assert abs(error) < 2.0 * sd
    assert abs(error) < (0.04 if gyro else 0.08) * abs(speed_mps)
    assert sd < (0.08 if gyro else 0.25) * abs(speed_mps)  # 7 % are the instants of reading


@pytest.mark.parametrize("steer_deg", [-40.0, 40.0])
def test_the_turning_at_the_start_is_not_forgotten_at_the_next_sample(steer_deg):
    of, t = setup(), np.arange(1, 51) / 50.0
    yaw_rate = 2.0 * np.tan(np.radians(steer_deg)) / of.wheelbase_m
    wheels = stamps(t)
    for wheel, side in (("fl", -1), ("fr", 1), ("rl", -1), ("rr", 1)):
        v = 2.0 + side * 0.5 * of.track_rear_m * yaw_rate
        v = np.hypot(v, of.wheelbase_m * yaw_rate) if wheel[0] == "f" else v
        turns = v * t / of.wheels.radius_m[wheel] / (2.0 * np.pi)
        wheels[f"ticks_{wheel}"] = np.floor(4000 * turns).astype(np.int64)
    names = ("gyro_x_radps", "gyro_y_radps", "accel_x_mps2", "accel_y_mps2", "accel_z_mps2")
    imu = stamps(t) | dict.fromkeys(names, 0.0 * t) | {"gyro_z_radps": 0.0 * t + yaw_rate}
    imu["accel_x_mps2"] = 0.0 * t - yaw_rate**2 * of.imu.lever_arm_m[0]
    _, table = estimated(Streams({"wheels": wheels, "imu": imu}), of)
    speed = table["speed_mps"][np.isfinite(table["speed_mps"])]
    assert np.abs(speed - 2.0).max() < 0.1


def test_late_wheels_start_a_speed_that_may_have_changed():
    memory = at_speed()
    memory["known"] = 0
    measured(counted_wheels(memory["time_ns"] - 300_000_000), memory)
    assert memory["p"][V, V] > 0.3**2
    assert memory["p"][W, W] > 0.3**2


@pytest.mark.parametrize("camera", [True, False])
@pytest.mark.parametrize(("waited_s", "starts"), [(0.5, True), (6.0, False)])
def test_a_first_speed_is_as_old_as_it_is(camera, waited_s, starts):
    """GNSS, or a camera, tells a speed, and the wheels begin to count some time later."""
    memory = at_speed()
    memory["known"] = 0
    told = {"v_x_mps": 1.0, "horizontal_mps": 1.0, "v_sd_mps": 0.03}
    measured(one_signal(CAMERA_SENSOR if camera else GNSS, memory["time_ns"], **told), memory)
    memory["time_ns"] += round(waited_s * 1e9)
    rear = np.array([np.nan, np.nan, 2.0, 2.0])
    measured(counted_wheels(memory["time_ns"], wheel_mps=rear), memory)
    assert memory["known"] == starts
    if starts:
        assert memory["x"][V] == 1.0
        assert memory["p"][V, V] > waited_s**2


def test_a_camera_replaces_a_first_speed_of_gnss_that_is_too_old():
    memory = at_speed()
    memory["known"] = 0
    told = {"horizontal_mps": 1.0, "v_sd_mps": 0.03}
    measured(one_signal(GNSS, memory["time_ns"], v_x_mps=1.0, **told), memory)
    for waited_s, due in ((1.0, 1.0), (6.0, 3.0)):
        memory["time_ns"] += round(waited_s * 1e9)
        measured(one_signal(CAMERA_SENSOR, memory["time_ns"], v_x_mps=3.0, **told), memory)
        assert memory["first_mps"] == due


def test_the_mean_of_a_load_that_is_told_later_starts_at_its_first_value():
    """A steady load says nothing of slip, whenever it is first told."""
    memory, z = at_speed(), np.zeros(HELD)
    loads = np.full(HELD, np.nan)
    for k in range(1000):
        memory["slip_s"] = 0.02 * k
        if k == 500:
            loads[FIRST_LOAD + 1] = 8.0
            centred(loads, memory, z)
            assert z[FIRST_LOAD + 1] == 0.0
        learn_line(loads, 0.1 + 1e-3 * k, 0.02, z, memory)
    assert memory["mean_load"][FIRST_LOAD + 1] == 8.0
    assert memory["line"][FIRST_LOAD + 1] == 0.0
    assert memory["x"][TRACTION] == 0.0
    assert np.isfinite(memory["line"]).all()


@pytest.mark.parametrize("hz", [10, 25, 100])
def test_the_zero_condition_counts_by_time_and_not_by_sample(hz):
    def known(hz):
        memory, h = at_speed(), np.zeros(SIZE)
        slow = np.full(HELD, np.nan)
        slow[PLOUGH] = 1.0
        for _ in range(hz):
            take_plough(slow, 1.0 / hz, h, 1.0, memory)
        return memory["p"][V, V] + memory["p"][W, W] - 2.0 * memory["p"][V, W]

    assert known(hz) == pytest.approx(known(50), rel=0.01)


def ploughed(torque_raised, torque_at_work, slip):
    """A memory after 5 s with the plough raised and 12 s at work, at such torques [10 kNm]."""
    memory, h = at_speed(), np.zeros(SIZE)
    memory["p"][UNLOADED_SLIP, UNLOADED_SLIP] = 0.006**2
    memory["seen_ns"][FROM_GNSS] = memory["time_ns"]
    slow = np.full(HELD, np.nan)
    for raised, torque, for_s, s in (1.0, torque_raised, 5, 0.0), (0.0, torque_at_work, 12, slip):
        slow[PLOUGH], slow[TORQUE] = raised, torque
        memory["x"][V] = 2.0 * (1.0 - s)
        for _ in range(50 * for_s):
            take_plough(slow, 0.02, h, 1.0, memory)
    return memory


def test_torque_tells_afterwards_how_much_the_axle_slipped_without_load():
    """On soft soil it takes more torque to roll and slips more for it than on firm soil."""
    firm, soft = ploughed(0.33, 1.7, 0.085), ploughed(0.58, 1.2, 0.066)
    assert firm["x"][UNLOADED_SLIP] == pytest.approx(0.0055, abs=0.002)
    assert soft["x"][UNLOADED_SLIP] > firm["x"][UNLOADED_SLIP] + 0.003
    assert soft["x"][RADIUS] < firm["x"][RADIUS] - 0.001
    assert firm["p"][UNLOADED_SLIP, UNLOADED_SLIP] < 0.003**2


def test_a_torque_that_hardly_rises_at_work_tells_nothing():
    assert ploughed(0.33, 0.5, 0.02)["p"][UNLOADED_SLIP, UNLOADED_SLIP] > 0.004**2


@pytest.mark.parametrize("towed", [True, False])
def test_towed_wheels_that_change_less_tell_that_the_driven_ones_do(towed):
    memory, h, slow = at_speed(), np.zeros(SIZE), np.full(HELD, np.nan)
    memory["seen_ns"][FROM_GNSS] = memory["time_ns"]
    memory["seen_ns"][FROM_TOWED] = memory["time_ns"] if towed else -1
    for raised in (1.0, *[0.0] * 400):
        slow[PLOUGH] = raised
        memory["x"][A] = 1.0 if raised else 0.0
        take_plough(slow, 0.02, h, 1.0, memory)
        memory["x"][TOWED] = 0.0
    assert memory["x"][RADIUS] == pytest.approx(
        CARRIED - MOVED + (REAR_SHARE * MOVED if towed else 0.0)
    )


def test_the_plough_s_load_changes_both_radii_and_changes_them_back():
    memory, h, slow = at_speed(), np.zeros(SIZE), np.full(HELD, np.nan)
    memory["x"][A] = 1.0  # not steady: nothing else is learnt
    found = []
    for raised in (1.0, 0.0, 1.0):
        slow[PLOUGH] = raised
        take_plough(slow, 0.02, h, 1.0, memory)
        found.append(memory["x"][[RADIUS, TOWED]].copy())
    assert found[0] == pytest.approx([CARRIED, 0.0])
    assert found[1] == pytest.approx([CARRIED - MOVED, MOVED])
    assert found[2] == pytest.approx(found[0])
    assert memory["p"][RADIUS, RADIUS] == pytest.approx(1e-3 + CARRIED_SD**2 + 2.0 * MOVED_SD**2)


def test_the_mean_radius_of_four_driven_wheels_stays_as_the_load_moves():
    memory, h, slow = at_speed(), np.zeros(SIZE), np.full(HELD, np.nan)
    memory["x"][A] = 1.0  # not steady: nothing else is learnt
    for raised in (1.0, 0.0, 1.0):
        slow[PLOUGH] = raised
        take_plough(slow, 0.02, h, 0.0, memory)
        assert memory["x"][RADIUS] == 0.0
    assert memory["p"][RADIUS, RADIUS] > CARRIED_SD**2


@pytest.mark.parametrize("slip", [-0.6, -0.1, 0.0, 0.15, 0.39, 0.41, 0.8])
def test_traction_and_slip_are_each_other_s_inverse(slip):
    y, gradient = traction(slip)
    back, steep = slip_of(y)
    assert back == pytest.approx(slip)
    assert gradient * steep == pytest.approx(1.0)
    rise = (traction(slip + 1e-6)[0] - traction(slip - 1e-6)[0]) / 2e-6
    assert gradient == pytest.approx(rise, rel=1e-4)
    if 0.0 <= slip < 0.4:
        assert y == pytest.approx(1.0 - np.exp(-7.5 * slip))


@pytest.mark.parametrize("steer_deg", [5.0, 40.0])
def test_front_wheels_steered_into_a_curve_tell_the_whole_yaw_rate(steer_deg):
    of, memory = setup(), at_speed()
    yaw_rate = 2.0 * np.tan(np.radians(steer_deg)) / of.wheelbase_m
    difference = yaw_rate * of.track_front_m * np.cos(np.radians(steer_deg))
    front = 2.0 / np.cos(np.radians(steer_deg)) + 0.5 * difference * np.array([-1.0, 1.0])
    signal = counted_wheels(memory["time_ns"], wheel_mps=np.append(front, [2.0, 2.0]))
    memory["seen_mps"][FROM_TOWED] = front.mean()
    nominal_values = np.array([nominal(of)], NOMINAL)[0]
    for _ in range(200):
        yawing(signal, 0.02, 2.0, nominal_values, memory)
    assert memory["yaw_rate"] == pytest.approx(yaw_rate, rel=1e-3)


def test_the_smoother_errs_less_and_as_it_says():
    """It errs less than the filter, as much as it says, also where counts begin anew."""
    made = streams(DRIVE, setup())
    _, by_filter = estimated(made)
    _, table = SLIP_EKF_SMOOTH.run(SLIP_EKF_SMOOTH.init(setup()), made)
    t = seconds(table["epoch_ns"])
    assert rms(table, DRIVE, 2.0) < 0.9 * rms(by_filter, DRIVE, 2.0)
    normalised = (table["slip"] - DRIVE.slip(t)) / table["slip_sd"]
    assert np.mean(normalised[t > 2.0] ** 2) < 1.5


def test_a_covariance_stays_one():
    memory, _ = estimated(read_late(streams(DRIVE, setup()), 2e-3))
    p = memory["p"]
    assert np.array_equal(p, p.T)
    scale = np.sqrt(np.diag(p))
    assert np.linalg.eigvalsh(p / np.outer(scale, scale)).min() > -1e-6
    assert abs(memory["x"][TOWED]) < 0.01


def test_a_drive_backwards_is_one():
    back = Drive(duration_s=20.0, speed=lambda t: -1.2 + 0.0 * t, slip=lambda t: -0.05 + 0.0 * t)
    _, table = estimated(streams(back, setup()))
    late = seconds(table["epoch_ns"]) > 5.0
    assert table["speed_mps"][late].mean() == pytest.approx(-1.2, abs=0.01)
    assert table["slip"][late].mean() == pytest.approx(-0.05, abs=0.01)  # it drives backwards
