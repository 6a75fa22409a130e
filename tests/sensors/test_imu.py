from dataclasses import replace

import numpy as np
import pytest

from tests.sensors.trajectories import GRAVITY, collect, drive
from twin.errors import BadInput, OutOfRange
from twin.sensors import Imu, imu, suite
from twin.sensors.filters import group_delay_s, low_pass
from twin.sensors.vibration import shake, start

IDEAL = suite.ideal().imu
GYRO = ("gyro_x_radps", "gyro_y_radps", "gyro_z_radps")
ACCEL = ("accel_x_mps2", "accel_y_mps2", "accel_z_mps2")


def allan_deviation(x, tau_s, rate_hz):
    """Overlapping Allan deviation of a rate x, IEEE Std 952 annex C."""
    m = round(tau_s * rate_hz)
    angle = np.concatenate([[0.0], np.cumsum(x)]) / rate_hz
    second = angle[2 * m :] - 2 * angle[m:-m] + angle[: -2 * m]
    return float(np.sqrt(np.mean(second**2) / (2 * tau_s**2)))


def pooled(table, names, tau_s):
    """Allan deviation of three axes together."""
    return np.sqrt(np.mean([allan_deviation(table[n], tau_s, 50) ** 2 for n in names]))


def stand(duration_s):
    return drive(duration_s, speed_mps=0, engine_radps=0.0, step_ns=5_000_000)


@pytest.mark.parametrize("tau_s", [0.5, 1.0, 4.0])
def test_white_noise_is_the_data_sheets_density(tau_s, quiet_stand):
    config = Imu()
    for names, n in ((GYRO, config.gyro_noise_radps_rthz), (ACCEL, config.accel_noise_mps2_rthz)):
        assert pooled(quiet_stand, names, tau_s) == pytest.approx(n / np.sqrt(tau_s), rel=0.1)


def test_white_noise_falls_with_the_root_of_time(quiet_stand):
    for names in (GYRO, ACCEL):
        fall = pooled(quiet_stand, names, 4.0) / pooled(quiet_stand, names, 0.5)
        assert np.log(fall) / np.log(8) == pytest.approx(-0.5, abs=0.05)


@pytest.fixture(scope="module")
def quiet_stand():
    return collect(imu, Imu(), [stand(1000)])


def test_the_flat_of_the_allan_deviation_is_the_bias_instability():
    # a short correlation time puts the flat at 1.89 x 2 s; small ranges resolve it without noise
    config = replace(
        Imu(), gyro_noise_radps_rthz=0, accel_noise_mps2_rthz=0, wander_tau_s=2.0,
        gyro_range_radps=0.1, accel_range_mps2=10.0,
        accel_bias_sd_mps2=0.0, scale_sd=0.0,
    )  # fmt: skip
    table = collect(imu, config, [stand(3000)])
    for names, b in ((GYRO, config.gyro_instability_radps), (ACCEL, config.accel_instability_mps2)):
        flat = [pooled(table, names, tau) for tau in (2.5, 3.78, 5.5)]
        assert max(flat) == pytest.approx(b, rel=0.1)
        assert pooled(table, names, 0.3) < 0.7 * b > pooled(table, names, 60.0)


def test_turn_on_bias_scale_and_mounting_have_their_sd():
    config = Imu()
    states = [imu.init(config, seed, 0) for seed in range(400)]
    bias = np.std([s.turn_on for s in states], axis=0)
    np.testing.assert_allclose(bias[:3].mean(), config.gyro_bias_sd_radps, rtol=0.1)
    np.testing.assert_allclose(bias[3:].mean(), config.accel_bias_sd_mps2, rtol=0.1)
    felt = np.array([s.felt_from_body for s in states])
    np.testing.assert_allclose(felt[:, 0, 0, 0].std(), config.scale_sd, rtol=0.1)
    np.testing.assert_allclose(felt[:, 1, 0, 1].std(), config.mounting_sd_rad, rtol=0.1)


def test_without_errors_it_reads_the_truth_to_its_resolution():
    truth = drive(5, speed_mps=2, yaw_rate_radps=0.3, roll_rad=0.2)
    table = collect(imu, IDEAL, [truth])
    for names, column, full in (
        (GYRO, "gyro_b", IDEAL.gyro_range_radps),
        (ACCEL, "imu_accel_b", IDEAL.accel_range_mps2),
    ):
        step = full / 32768
        for j, name in enumerate(names):
            np.testing.assert_allclose(table[name], truth[column][0, j], atol=0.51 * step)
            counts = table[name] / step
            np.testing.assert_allclose(counts, np.rint(counts), atol=1e-6)


def test_known_bias_and_scale_are_added():
    truth = drive(2, yaw_rate_radps=0.5)
    off = replace(
        IDEAL, scale_error=0.01, gyro_bias_radps=(0, 0, 0.02), accel_bias_mps2=(0.3, 0, 0)
    )
    table = collect(imu, off, [truth])
    step = IDEAL.gyro_range_radps / 32768
    np.testing.assert_allclose(table["gyro_z_radps"], 0.5 * 1.01 + 0.02, atol=step)
    expected = truth["imu_accel_b"][0, 0] * 1.01 + 0.3
    np.testing.assert_allclose(table["accel_x_mps2"], expected, atol=2e-3)


def test_a_rolled_and_a_yawed_unit_feel_what_they_should():
    still = drive(2, speed_mps=0)
    rolled = collect(imu, replace(IDEAL, mounting_error_rad=(0.1, 0, 0)), [still])
    np.testing.assert_allclose(rolled["accel_y_mps2"], GRAVITY * np.sin(0.1), atol=1e-3)
    np.testing.assert_allclose(rolled["accel_z_mps2"], GRAVITY * np.cos(0.1), atol=1e-3)
    forward = drive(2, imu_accel_b=np.tile([1.0, 0.0, GRAVITY], (1001, 1)))
    yawed = collect(imu, replace(IDEAL, mounting_error_rad=(0, 0, 0.1)), [forward])
    np.testing.assert_allclose(yawed["accel_x_mps2"], np.cos(0.1), atol=1e-3)
    np.testing.assert_allclose(yawed["accel_y_mps2"], -np.sin(0.1), atol=1e-3)


def test_it_saturates_at_full_scale():
    hit = drive(2, imu_accel_b=np.tile([500.0, -500.0, GRAVITY], (1001, 1)))
    table = collect(imu, IDEAL, [hit])
    np.testing.assert_allclose(table["accel_x_mps2"], IDEAL.accel_range_mps2)
    np.testing.assert_allclose(table["accel_y_mps2"], -IDEAL.accel_range_mps2)


def sine(hz, duration_s=8.0):
    t = np.arange(round(duration_s / 0.002) + 1) * 0.002
    accel = np.stack([np.sin(2 * np.pi * hz * t), 0 * t, GRAVITY + 0 * t], axis=1)
    return drive(duration_s, imu_accel_b=accel)


def response(hz, config=IDEAL):
    """Complex gain from the truth at the samples' own epochs, by least squares."""
    table = collect(imu, config, [sine(hz)])
    late = table["epoch_ns"] > 2_000_000_000
    t = table["epoch_ns"][late] * 1e-9
    basis = np.stack([np.sin(2 * np.pi * hz * t), np.cos(2 * np.pi * hz * t)], axis=1)
    (a, b), *_ = np.linalg.lstsq(basis, table["accel_x_mps2"][late], rcond=None)
    return complex(a, b)


@pytest.mark.parametrize(("hz", "within_s"), [(0.5, 5e-5), (2.0, 3e-4), (5.0, 2e-3)])
def test_the_epoch_is_the_instant_the_sample_describes(hz, within_s):
    gain = response(hz)
    assert abs(np.angle(gain) / (2 * np.pi * hz)) < within_s
    assert abs(gain) == pytest.approx(1.0, abs=2e-3)


@pytest.mark.parametrize(
    ("hz", "gain"),
    [
        # Butterworth of order 4: (cut / f)^4, before warping, which only helps
        *((hz, (15.0 / hz) ** 4) for hz in (45.0, 55.0, 60.0, 100.0)),
        # beyond half the conversion rate: mean over 5 ms, |sin(x) / x| with x = pi f 5 ms
        *((hz, abs(np.sinc(hz * 0.005))) for hz in (190.0, 195.0)),
    ],
)
def test_what_would_alias_is_filtered(hz, gain):
    table = collect(imu, IDEAL, [sine(hz)])
    rounding = IDEAL.accel_range_mps2 / 32768
    assert np.std(table["accel_x_mps2"][50:]) < gain / np.sqrt(2) + rounding


def test_the_group_delay_is_the_prototypes_closed_form():
    for order in (4, 6):
        poles = np.exp(1j * np.pi * (2 * np.arange(order) + order + 1) / (2 * order))
        warped = 2 * 200 * np.tan(np.pi * 15 / 200)
        expected = float(np.sum(-1 / poles).real) / warped
        assert group_delay_s(low_pass(order, 15.0, 200.0), 200.0) == pytest.approx(expected)


def test_samples_arrive_after_the_filters_delay():
    table = collect(imu, Imu(), [drive(5)])
    late_s = (table["arrival_ns"] - table["epoch_ns"]) * 1e-9
    nominal = 2.6131 / (400 * np.tan(np.pi * 15 / 200)) + 0.0025 + 0.002
    assert nominal <= late_s.min() < late_s.max() < nominal + 0.0015
    assert table["epoch_ns"][0] >= 0
    np.testing.assert_array_equal(np.diff(table["epoch_ns"]), 20_000_000)


def test_vibration_has_its_rms_and_its_orders():
    n = 20_001
    epoch_ns = 2_000_000 * np.arange(n)
    crank_hz = 20.0
    engine = np.full(n, 2 * np.pi * crank_hz)
    _, added = shake(start(np.random.default_rng(0)), epoch_ns, engine, 0.5, 3.0)
    np.testing.assert_allclose(added.std(axis=0), 0.5, rtol=0.01)
    spectrum = np.abs(np.fft.rfft(added[:-1, 2]))
    hz = np.fft.rfftfreq(n - 1, 0.002)
    peaks = sorted(hz[np.argsort(spectrum)[-2:]])
    np.testing.assert_allclose(peaks, [crank_hz, 3 * crank_hz], atol=0.05)


def test_a_stopped_engine_is_still():
    zero = np.zeros(100)
    _, added = shake(start(np.random.default_rng(0)), 2_000_000 * np.arange(100), zero, 0.5, 3.0)
    assert not added.any()


def test_bad_values_are_named():
    with pytest.raises(OutOfRange, match=r"imu\.filter_cut_hz = 30 is outside \[0\.1, 20\]"):
        Imu(filter_cut_hz=30)
    with pytest.raises(BadInput, match="whole multiple"):
        Imu(rate_hz=60)
