import numpy as np
import pytest

from tests.sensors.trajectories import AUX_M, MAIN_M, collect, drive
from twin.errors import BadInput, OutOfRange
from twin.sensors import Gnss, Outage, gnss, suite
from twin.sensors.gnss import wrap

IDEAL = suite.ideal().gnss
SECOND_NS = 1_000_000_000


@pytest.fixture(scope="module")
def long_stand():
    """Fifty hours at one sample a second: 3000 correlation times of the coloured error."""
    truth = drive(180_000, speed_mps=0, step_ns=SECOND_NS)
    return truth, collect(gnss, Gnss(rate_hz=1.0), [truth])


def errors(truth, table, axes=("east_m", "north_m", "up_m")):
    return np.stack([table[a] for a in axes], axis=1) - truth["antenna_main_w"]


def covariance(x, lag):
    x = x - x.mean()
    return float(np.mean(x[lag:] * x[: len(x) - lag]))


def test_position_error_has_the_data_sheets_white_and_coloured_parts(long_stand):
    config, error = Gnss(), errors(*long_stand)
    for axis, worse in enumerate((1.0, 1.0, config.vertical_factor)):
        coloured = covariance(error[:, axis], 1) * np.exp(1 / config.coloured_tau_s)
        white = covariance(error[:, axis], 0) - coloured
        assert np.sqrt(coloured) == pytest.approx(config.coloured_sd_m * worse, rel=0.1)
        assert np.sqrt(white) == pytest.approx(config.white_sd_m * worse, rel=0.1)


def test_position_error_forgets_with_the_correlation_time(long_stand):
    error = errors(*long_stand)
    ratio = [covariance(error[:, j], 61) / covariance(error[:, j], 1) for j in range(3)]
    assert -60 / np.log(np.mean(ratio)) == pytest.approx(60.0, rel=0.1)


def test_the_receivers_own_sd_is_the_errors(long_stand):
    error = errors(*long_stand)
    assert error[:, :2].std() == pytest.approx(long_stand[1]["position_sd_m"][0], rel=0.1)


def test_doppler_velocity_is_white_of_the_data_sheets_sd():
    truth = drive(500, speed_mps=1.5, step_ns=50_000_000)
    table = collect(gnss, Gnss(), [truth])
    error = table["v_east_mps"] - truth["antenna_main_velocity_w"][:, 0]
    assert error.std() == pytest.approx(0.03, rel=0.1)
    assert abs(covariance(error, 1) / covariance(error, 0)) < 4 / np.sqrt(len(error))


@pytest.mark.parametrize("baseline_m", [1.0, 2.0])
def test_heading_noise_is_that_of_the_baseline(baseline_m):
    truth = drive(500, speed_mps=0, step_ns=50_000_000)
    main = truth["antenna_main_w"]
    truth.columns["antenna_aux_w"] = main + (truth["antenna_aux_w"] - main) * baseline_m
    table = collect(gnss, Gnss(), [truth])
    expected = np.radians(0.2) / baseline_m
    assert table["heading_rad"].std() == pytest.approx(expected, rel=0.1)
    np.testing.assert_allclose(table["heading_sd_rad"], expected)


def test_heading_less_its_mounting_angle_is_yaw_and_wraps():
    truth = drive(40, yaw_rad=2.5, yaw_rate_radps=0.5)
    table = collect(gnss, IDEAL, [truth])
    mount = np.arctan2(AUX_M[1] - MAIN_M[1], AUX_M[0] - MAIN_M[0])
    yaw = 2.5 + 0.5 * table["epoch_ns"] * 1e-9
    np.testing.assert_allclose(wrap(table["heading_rad"] - mount - yaw), 0, atol=1e-12)
    assert np.all(np.abs(table["heading_rad"]) <= np.pi)
    assert np.sum(np.abs(np.diff(table["heading_rad"])) > 6) == 3


def test_heading_bias_is_fixed_and_belongs_to_the_seed():
    truth = drive(100, speed_mps=0)
    biased = Gnss(heading_sd_rad_m=0, heading_bias_rad=0.01, heading_bias_sd_rad=0)
    a = collect(gnss, biased, [truth])["heading_rad"]
    b = collect(gnss, IDEAL, [truth])["heading_rad"]
    np.testing.assert_allclose(a - b, 0.01, atol=1e-12)
    drawn = [gnss.init(Gnss(), s, 0).heading_bias_rad for s in range(1000)]
    assert np.std(drawn) == pytest.approx(np.radians(0.1), rel=0.1)


def test_without_errors_it_gives_the_swinging_antenna():
    truth = drive(5, yaw_rate_radps=0.3, roll_rad=0.15)
    table = collect(gnss, IDEAL, [truth])
    np.testing.assert_allclose(errors(truth.cut(0, 2501), _every(table, 1, truth)), 0, atol=1e-12)
    left = np.array([-np.sin(0.3), np.cos(0.3)])
    offset = np.array([table["east_m"][0], table["north_m"][0]]) @ left
    assert offset == pytest.approx(0.5 * np.cos(0.15) - 2.8 * np.sin(0.15), abs=1e-9)


def _every(table, _, truth):
    rows = np.searchsorted(table["epoch_ns"], truth.epoch_ns)
    exact = np.isin(truth.epoch_ns, table["epoch_ns"])
    out = {}
    for j, axis in enumerate(("east_m", "north_m", "up_m")):
        out[axis] = truth["antenna_main_w"][:, j].copy()
        out[axis][exact] = table[axis][rows[exact]]
    return out


def test_a_lever_arm_error_turns_with_the_body():
    truth = drive(10, yaw_rate_radps=0.4, roll_rad=0.1)
    off = Gnss(**{**vars(IDEAL), "lever_arm_error_m": (0.1, -0.2, 0.05)})
    a, b = collect(gnss, off, [truth]), collect(gnss, IDEAL, [truth])
    shift = np.stack([a[c] - b[c] for c in ("east_m", "north_m", "up_m")], axis=1)
    np.testing.assert_allclose(np.linalg.norm(shift, axis=1), np.hypot(0.1, np.hypot(0.2, 0.05)))
    swing = np.stack([a[c] - b[c] for c in ("v_east_mps", "v_north_mps", "v_up_mps")], axis=1)
    # central difference of the shift over 0.1 s, whose error is w^3 h^2 / 6
    np.testing.assert_allclose((shift[2:] - shift[:-2])[:, :2] / 0.1, swing[1:-1, :2], atol=1e-5)


def test_latency_is_the_data_sheets_and_never_reorders():
    truth = drive(100, step_ns=50_000_000)
    table = collect(gnss, Gnss(), [truth])
    late_s = (table["arrival_ns"] - table["epoch_ns"]) * 1e-9
    assert late_s.min() >= 0.05
    assert late_s.mean() == pytest.approx(0.05 + 0.002 * np.sqrt(2 / np.pi), rel=0.1)
    jittery = collect(gnss, Gnss(latency_jitter_s=0.5), [truth])
    assert np.all(np.diff(jittery["arrival_ns"]) >= 0)
    assert same_epochs(table, jittery)


def same_epochs(a, b):
    return np.array_equal(a["epoch_ns"], b["epoch_ns"])


def test_an_outage_of_the_corrections_runs_its_course():
    truth = drive(200, step_ns=50_000_000)
    config = Gnss(outages=(Outage(start_s=50, duration_s=60),))
    table, clear = collect(gnss, config, [truth]), collect(gnss, Gnss(), [truth])
    t, quality = table["epoch_ns"] * 1e-9, table["quality"]
    assert set(quality[t < 60]) == {4}
    assert set(quality[(t >= 60) & (t < 80)]) == {5}
    assert set(quality[(t >= 80) & (t < 110)]) == {1}
    assert set(quality[(t >= 110) & (t < 115)]) == {5}
    refixed = t[(t > 110) & (quality == 4)][0]
    assert 115 <= refixed <= 140.05
    outside = (t < 50) | (t >= refixed)
    for column in ("east_m", "north_m", "up_m", "position_sd_m"):
        assert np.array_equal(table[column][outside], clear[column][outside])
    for column in ("v_east_mps", "heading_rad"):
        assert np.array_equal(table[column], clear[column])
    at_refix = int(np.searchsorted(t, refixed))
    assert np.abs(np.diff(errors(truth, table)[at_refix - 1 : at_refix + 1], axis=0)).max() > 0.05
    assert np.all(np.diff(table["position_sd_m"][(t >= 50) & (t < 60)]) > 0)


@pytest.mark.parametrize(("mode", "column"), [("float", 5), ("single", 1)])
def test_float_and_single_errors_have_their_sd_and_correlation_time(mode, column):
    truth = drive(180_000, speed_mps=0, step_ns=SECOND_NS)
    # float lasts 20 s of one fault only, so short faults follow one another without a re-fix
    outages = (
        tuple(Outage(start_s=20.0 * k, duration_s=20, kind="mask") for k in range(9000))
        if mode == "float"
        else (Outage(start_s=0, duration_s=1e6),)
    )
    table = collect(gnss, Gnss(rate_hz=1.0, outages=outages), [truth])
    rows = slice(40, 180_000)
    assert set(table["quality"][rows]) == {column}
    error = errors(truth, table)[rows, 0]
    expected = {"float": 0.35, "single": 1.5}[mode]
    assert error.std() == pytest.approx(expected, rel=0.1)
    time_s = {"float": Gnss().float_tau_s, "single": Gnss().single_tau_s}[mode]
    for lag_s in (30, 120):
        due = (1 + lag_s / time_s) * np.exp(-lag_s / time_s)
        left = (covariance(error, lag_s) - white_m2(lag_s)) / (covariance(error, 0) - white_m2(0))
        assert left == pytest.approx(due, rel=0.1)


def white_m2(lag):
    return Gnss().white_sd_m ** 2 * (lag == 0)


def stop_and_go(stop_s=600.0, start_s=1200.0, end_s=1500.0):
    """Drives, stands and drives again."""
    truth = drive(end_s, speed_mps=0.0, step_ns=50_000_000)
    t = truth.epoch_ns * 1e-9
    moves = (t < stop_s) | (t >= start_s)
    velocity = np.stack([1.5 * moves, 0.0 * t, 0.0 * t], axis=1)
    truth.columns["antenna_main_velocity_w"] = velocity
    truth.columns["antenna_main_w"] = np.cumsum(velocity, axis=0) * 0.05
    return truth


def test_a_receiver_at_rest_is_as_quiet_as_a_real_one():
    truth = stop_and_go()
    table = collect(gnss, Gnss(), [truth])
    t = table["epoch_ns"] * 1e-9
    error = table["v_east_mps"] - truth["antenna_main_velocity_w"][:, 0]
    speed = np.hypot(table["v_east_mps"], table["v_north_mps"])[(t > 604) & (t < 1200)]
    assert np.median(speed) == pytest.approx(3.7e-3, rel=0.1)
    assert np.percentile(speed, 99) == pytest.approx(9e-3, rel=0.2)
    for driven in (t < 600, t >= 1200):
        assert error[driven].std() == pytest.approx(0.03, rel=0.05)
    at_rest = error[(t > 604) & (t < 1200)]
    assert covariance(at_rest, 20) / covariance(at_rest, 0) == pytest.approx(0.47, abs=0.15)


def test_the_noise_of_motion_fades_after_a_stop_and_is_whole_at_once_when_it_drives():
    truth = stop_and_go(stop_s=5.0, start_s=15.0, end_s=20.0)
    t = truth.epoch_ns * 1e-9
    made = [collect(gnss, Gnss(), [truth], seed=s)["v_north_mps"] for s in range(150)]
    sd = np.std(made, axis=0)
    assert sd[(t >= 6.0) & (t < 6.5)].mean() == pytest.approx(0.03 * np.exp(-2.25), rel=0.3)
    assert sd[t > 9][:100].mean() == pytest.approx(3.1e-3, rel=0.1)
    assert sd[t >= 15][0] == pytest.approx(0.03, rel=0.2)


def test_while_it_drives_no_bit_depends_on_the_noise_of_rest():
    truth = stop_and_go(stop_s=5.0, start_s=8.0, end_s=12.0)
    t = truth.epoch_ns * 1e-9
    a, b = (collect(gnss, Gnss(rest_velocity_sd_mps=sd), [truth]) for sd in (0.0, 0.02))
    driven = (t < 5) | (t >= 8)
    for column in ("v_east_mps", "v_north_mps", "v_up_mps"):
        assert np.array_equal(a[column][driven], b[column][driven])
    assert np.abs((a["v_east_mps"] - b["v_east_mps"])[(t > 6) & (t < 8)]).min() > 0.0


def test_the_noise_of_rest_is_never_above_that_of_motion():
    truth = drive(60, speed_mps=0, step_ns=50_000_000)
    table = collect(gnss, Gnss(velocity_sd_mps=1e-4), [truth])
    assert table["v_east_mps"].std() < 2e-4


def test_without_corrections_the_position_wanders_by_decimetres_and_smoothly():
    truth = drive(6000, speed_mps=0, step_ns=SECOND_NS)
    config = Gnss(rate_hz=1.0, outages=(Outage(start_s=0, duration_s=1e6),))
    error = np.concatenate(
        [errors(truth, collect(gnss, config, [truth], seed=s))[60:, :2].T for s in range(4)]
    )
    change = {n: np.sqrt(np.mean((error[:, n:] - error[:, :-n]) ** 2)) for n in (1, 10, 60)}
    assert change[60] == pytest.approx(0.6, rel=0.3)
    assert change[10] == pytest.approx(0.155, rel=0.4)
    assert change[1] < 0.03


def test_masking_the_auxiliary_antenna_takes_only_the_heading():
    truth = drive(30, step_ns=50_000_000)
    config = Gnss(outages=(Outage(start_s=10, duration_s=5, kind="mask-aux"),))
    table, clear = collect(gnss, config, [truth]), collect(gnss, Gnss(), [truth])
    t = table["epoch_ns"] * 1e-9
    gone = (t >= 10) & (t < 15)
    np.testing.assert_array_equal(np.isnan(table["heading_rad"]), gone)
    assert table["satellites_aux"][gone].max() < 12 < table["satellites_aux"][~gone].min()
    assert table["satellites_main"].min() > 15
    for column in ("east_m", "v_east_mps", "quality"):
        assert np.array_equal(table[column], clear[column])


def test_masking_both_antennas_and_blocking_the_sky():
    truth = drive(60, step_ns=50_000_000)
    faults = (
        Outage(start_s=5, duration_s=22, kind="mask"),
        Outage(start_s=40, duration_s=5, kind="block"),
    )
    table = collect(gnss, Gnss(outages=faults), [truth])
    t = table["epoch_ns"] * 1e-9
    masked, blocked = (t >= 5) & (t < 27), (t >= 40) & (t < 45)
    assert list(dict.fromkeys(table["quality"][masked])) == [5, 1]
    assert table["satellites_main"][masked].max() < 12
    assert np.all(np.isnan(table["heading_rad"][masked]))
    assert set(table["quality"][blocked]) == {0}
    assert set(table["satellites_main"][blocked]) == {0}
    for column in ("east_m", "v_east_mps", "heading_rad", "position_sd_m", "velocity_sd_mps"):
        assert np.all(np.isnan(table[column][blocked]))
    assert set(table["quality"][(t >= 45) & (t < 46)]) == {1}


def test_bad_values_are_named():
    with pytest.raises(OutOfRange, match=r"gnss\.latency_s = -1 is outside \[0, 5\]"):
        Gnss(latency_s=-1)
    with pytest.raises(BadInput, match="one after the other"):
        Gnss(outages=(Outage(start_s=0, duration_s=5), Outage(start_s=3, duration_s=5)))
    with pytest.raises(BadInput, match="none of corrections, mask"):
        Outage(start_s=0, duration_s=5, kind="rain")
