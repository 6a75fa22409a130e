"""Where a filter's model is what happened, its standard deviation is that of its error."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from estimators.four_state import FourState, white_jerk
from estimators.four_state_printed import FourStatePrinted
from estimators.parallel_kf import KF_TUNED, KF_Z2
from estimators.ratio import RATIO, RATIO_FRONT
from estimators.slip_ekf import SLIP_EKF
from twin.streams import ImuSetup, Streams
from twin.testing import drives as synthetic

IMU = ImuSetup(
    rate_hz=50.0,
    lever_arm_m=(0.0, 0.0, 0.0),
    gyro_noise_radps_rthz=0.0,
    accel_noise_mps2_rthz=0.1 / 50**0.5,
    gyro_bias_sd_radps=0.0,
    accel_bias_sd_mps2=0.1,
)
SETUP = synthetic.setup(imu=IMU)
GRAVITY_MPS2 = 9.81


def streams(rng, ground, accel, wheels, wheel_sd, accel_w=None, front=None, hz=50.0, gnss_every=1):
    """Noisy streams of given speeds, (n,) and wheels (n, 2), first sample at 1/hz."""
    t = np.arange(1, len(ground) + 1) / hz

    def noisy(values, sd):
        return values + sd * rng.standard_normal(np.shape(values))

    table = synthetic.stamps(t) | {"speed_sd_mps": np.full(t.shape, wheel_sd)}
    for i, wheel in enumerate(("rl", "rr")):
        table[f"speed_{wheel}_mps"] = noisy(wheels[:, i], wheel_sd)
        table[f"speed_f{wheel[1]}_mps"] = noisy(ground if front is None else front, wheel_sd)
        if accel_w is not None:
            table[f"accel_{wheel}_mps2"] = accel_w
    kept = slice(None, None, gnss_every)
    gnss = synthetic.stamps(t[kept]) | {
        "v_east_mps": noisy(ground[kept], 0.03),
        "v_north_mps": 0 * t[kept],
    }
    tables = {"gnss": gnss, "wheels": table}
    if accel is not None:
        tables["imu"] = synthetic.stamps(t) | {"accel_x_mps2": noisy(accel, 0.1)}
    return Streams(tables)


def last_nees(estimator, stream, wheel, ground):
    _, table = estimator.run(estimator.init(SETUP), stream)
    slip = (wheel - ground) / max(wheel, ground)
    return ((table["slip"][-1] - slip) / table["slip_sd"][-1]) ** 2


def assert_consistent(nees):
    """Sum of squared normalised errors in the two-sided 99.9 % band of chi-square."""
    low, high = chi2.ppf([0.0005, 0.9995], len(nees))
    assert low < np.sum(nees) < high


def walk(rng, start, f, q, n):
    """A linear Gaussian random walk of states, (n, size)."""
    states = [np.asarray(start, float)]
    for _ in range(n - 1):
        states.append(f @ states[-1] + rng.multivariate_normal(np.zeros(len(f)), q))
    return np.array(states)


@pytest.mark.parametrize("estimator", [RATIO, RATIO_FRONT])
def test_ratio(estimator):
    rng = np.random.default_rng(1)
    n = 800
    ground = np.full(n, 1.6)
    stream = streams(rng, ground, None, np.full((n, 2), 2.0), 0.02)
    _, table = estimator.run(estimator.init(SETUP), stream)
    assert_consistent(((table["slip"] - 0.2) / table["slip_sd"]) ** 2)


def test_the_ratio_of_an_old_velocity_is_less_sure():
    rng = np.random.default_rng(1)
    stream = streams(rng, np.full(500, 1.6), None, np.full((500, 2), 2.0), 0.02, gnss_every=50)
    _, table = RATIO.run(RATIO.init(SETUP), stream)
    fresh, old = table["slip_sd"][400], table["slip_sd"][449]
    assert old == pytest.approx(np.hypot(fresh, 0.3 * 0.98 / 2.0), rel=0.02)


def test_four_state():
    psd, n = 0.5, 120
    estimator = FourState(
        jerk_psd_m2ps5=psd, wheel_jerk_psd_m2ps5=psd, accel_model_sd_mps2=0.0, bias_psd_m2ps5=1e-2
    )
    f, q = white_jerk(0.02, psd, 2)
    nees = []
    for seed in range(150):
        rng = np.random.default_rng((2, seed))
        ground = walk(rng, [20.0, rng.standard_normal()], f, q, n)
        wheels = [walk(rng, [25.0, rng.standard_normal()], f, q, n)[:, 0] for _ in range(2)]
        bias = np.hypot(0.1, GRAVITY_MPS2 * 0.05) * rng.standard_normal()
        bias = bias + np.cumsum(np.sqrt(1e-2 * 0.02) * rng.standard_normal(n))
        wheels = np.array(wheels).T
        stream = streams(rng, ground[:, 0], ground[:, 1] + bias, wheels, 0.02, gnss_every=3)
        nees.append(last_nees(estimator, stream, wheels[-1].mean(), ground[-1, 0]))
    assert_consistent(nees)


def test_four_state_printed():
    estimator = FourStatePrinted()
    f, n = np.array([[1.0, 0.1], [0.0, 1.0]]), 40
    q = np.diag(estimator.process_var[:2])
    nees = []
    for seed in range(150):
        rng = np.random.default_rng((3, seed))
        ground = walk(rng, [20.0, rng.standard_normal()], f, q, n)[:, 0]
        wheel = walk(rng, [25.0, rng.standard_normal()], f, q, n)[:, 0]
        stream = streams(rng, ground, None, np.array([wheel, wheel]).T, 0.02, hz=10.0)
        nees.append(last_nees(estimator, stream, wheel[-1], ground[-1]))
    assert_consistent(nees)


def nees_of_parallel(estimator, speed, n, trials, bias_sd=0.0):
    dt = 0.02
    f = np.array([[1.0, dt, dt * dt / 2], [0.0, 1.0, dt], [0.0, 0.0, 1.0]])
    q = np.diag(estimator.process_var)
    nees = []
    for seed in range(trials):
        rng = np.random.default_rng((4, seed))
        ground = walk(rng, [speed, *rng.standard_normal(2)], f, q, n)
        wheel = walk(rng, [1.25 * speed, *rng.standard_normal(2)], f, q, n)
        bias, bias_w = bias_sd * rng.standard_normal(2)
        front = ground[:, 0] + estimator.front_offset_sd_mps * rng.standard_normal()
        accel_w = wheel[:, 1] + bias_w + 0.1 * rng.standard_normal(n)
        wheels = np.array([wheel[:, 0], wheel[:, 0]]).T
        stream = streams(rng, ground[:, 0], ground[:, 1] + bias, wheels, 0.02, accel_w, front)
        nees.append(last_nees(estimator, stream, wheel[-1, 0], ground[-1, 0]))
    return nees


MATCHED = {
    "front_sd_mps": None,
    "gnss_sd_mps": None,
    "rear_sd_mps": None,
    "accel_sd_mps2": 0.1,
    "wheel_accel_sd_mps2": 0.1,
}


def test_kf_z2():
    assert_consistent(nees_of_parallel(replace(KF_Z2, **MATCHED), 1000.0, 25, 150))


def test_kf_tuned():
    estimator = replace(
        KF_TUNED,
        **MATCHED,
        bias_sd_mps2=0.3,
        wheel_bias_sd_mps2=0.3,
        bias_psd_m2ps5=0.0,
        front_offset_psd_m2ps3=0.0,
    )
    assert_consistent(nees_of_parallel(estimator, 20.0, 100, 150, bias_sd=0.3))


AS_DRAWN = {
    "jerk_psd": 0.005,
    "wheel_jerk_gain": 0.5,
    "wheel_jerk_share": 0.25,
    "towed_fast_sd": 1e-6,
    "pitch_slip_sd": 1e-6,
    "gnss_bias_share": 1e-6,
    "gate": 6.0,
}
"""Only what `slip_motion` draws, and no gate, which cuts the innovations it does not refuse."""


def slip_motion(rng, e, n, dt=0.02):
    """Speeds of ground and wheels as the slip filter models them, (n, 4): v, a, w, r."""
    gain = e.wheel_jerk_gain
    psd = e.jerk_psd * np.array([[1.0, gain], [gain, gain**2 + e.wheel_jerk_share]])
    fade = np.exp(-dt / e.fading_s)
    states = [np.array([1.7, 0.1 * rng.standard_normal(), 2.0, 0.1 * rng.standard_normal()])]
    for excess in rng.multivariate_normal([0.0, 0.0], psd * dt, n - 1):
        v, a, w, rate = states[-1]
        v, w = v + dt * a, w + dt * rate
        states.append(
            np.array([v + 0.5 * dt * excess[0], fade * a + excess[0],
                      w + 0.5 * dt * excess[1], fade * rate + excess[1]])
        )  # fmt: skip
    return np.array(states)


@pytest.mark.slow
def test_slip_ekf():
    """NEES of slip after 12 s, and NIS of every stream, in bands about one.

    The noises that the filter learns on its way are drawn as it takes them at first; what it learns
    of them by chance, and the radius that it only considers, widen the bands.
    """
    estimator = replace(SLIP_EKF, **AS_DRAWN)
    nees, sums, counts = [], np.zeros(5), np.zeros(5)
    for seed in range(100):
        rng = np.random.default_rng((5, seed))
        n = 600
        v, a, w, _ = slip_motion(rng, estimator, n).T
        leak = np.hypot(estimator.gravity_sd, 0.1) * rng.standard_normal()
        leak = leak + np.cumsum(np.sqrt(estimator.gravity_psd * 0.02) * rng.standard_normal(n))
        counted = w * (1.0 + SETUP.wheels.radius_sd * rng.standard_normal())
        front = v * (1.0 + estimator.scale_sd * rng.standard_normal())
        stream = streams(rng, v, a + leak, np.array([counted, counted]).T, 0.02, front=front)
        state, table = estimator.run(estimator.init(SETUP), stream)
        nees.append(((table["slip"][-1] - (1.0 - v[-1] / w[-1])) / table["slip_sd"][-1]) ** 2)
        sums, counts = sums + state.memory[0]["nis_sum"], counts + state.memory[0]["nis_count"]
    print(np.mean(nees), sums[:4] / counts[:4])
    assert_consistent(nees)
    gnss, imu, front, rear = sums[:4] / counts[:4]
    assert 0.9 < gnss < 1.1
    assert 0.9 < front < 1.1
    assert 0.9 < rear < 1.1
    assert 0.8 < imu < 1.05  # its variance is heard, and never taken for less than the data sheet's


def test_with_nothing_but_driven_counters_the_slip_filter_knows_that_it_knows_little():
    """A minute after the last ground speed: errors as large as it says, over ten seeds.

    Counts tell v and slip on one line; gradients that trembled along it once told a place on it.
    """
    ratios = []
    for seed in range(10):
        drive = synthetic.Drive(
            duration_s=90.0, speed=lambda t: 1.5 + 0 * t, slip=lambda t: 0.15 + 0 * t
        )
        measured = synthetic.streams(drive, SETUP, seed=seed)
        seen = measured["gnss"]["epoch_ns"] < 31_000_000_000
        gnss = {name: column[seen] for name, column in measured["gnss"].items()}
        wheels = {n: c for n, c in measured["wheels"].items() if n not in ("ticks_fl", "ticks_fr")}
        blind = Streams({**measured.tables, "gnss": gnss, "wheels": wheels})
        table = SLIP_EKF.run(SLIP_EKF.init(SETUP), blind)[1]
        assert 0.01 < table["slip_sd"][-1] < 0.2  # it has learnt that this slip hardly changes
        ratios.append((table["slip"][-1] - 0.15) / table["slip_sd"][-1])
    assert np.sqrt(np.mean(np.square(ratios))) < 1.9  # 99.9 % of chi-square with ten
