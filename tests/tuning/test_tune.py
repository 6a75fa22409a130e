"""What a log with known noises says of them, and what is done with a log that says nothing."""

import dataclasses
from typing import ClassVar

import numpy as np
import pytest

from tests.tuning import drive
from twin.errors import BadInput, UnknownName
from twin.pipeline import tuned
from twin.pipeline.named import load
from twin.streams import Streams
from twin.testing import drives
from twin.tuning.held_out import density_gain, rms_gain
from twin.tuning.result import to_text
from twin.tuning.tune import tune_one


@pytest.mark.slow
@pytest.mark.parametrize("told", [1 / 3, 2.5])
def test_a_sheet_that_is_wrong_is_put_right(told):
    log = drive.log(told)
    found = tune_one("four-state", load("estimator", "four-state"), log, drive.reference())
    values = {value.name: value for value in found.values}
    factor = values["gnss_velocity"]
    assert factor.value == pytest.approx(1.0 / told, rel=0.1)  # the filter's model is not exact
    assert factor.high / factor.low < 1.5
    assert found.verdict == "better"
    best = drive.slip_rmse(load("estimator", "four-state"), drive.log())
    estimator = tuned.tuned("four-state", load("estimator", "four-state"), found.noises)
    assert drive.slip_rmse(estimator, log) < 1.1 * best


@pytest.mark.slow
def test_where_the_sheet_is_right_nothing_is_lost():
    log = drive.log()
    found = tune_one("kf-tuned", load("estimator", "kf-tuned"), log, {})
    before = drive.slip_rmse(load("estimator", "kf-tuned"), log)
    estimator = tuned.tuned("kf-tuned", load("estimator", "kf-tuned"), found.noises)
    assert drive.slip_rmse(estimator, log) < 1.02 * before
    factors = {value.name: value.value for value in found.values if value.is_factor}
    assert factors["gnss_velocity"] == 1.0


def test_what_the_log_does_not_have_is_not_tuned():
    log = drive.without(drive.log(), "imu")
    found = tune_one("four-state", load("estimator", "four-state"), log, {})
    of = {value.name: value for value in found.values}
    assert not {"imu_accel", "imu_gyro", "wheel_speed"} & set(of)
    for name in ("accel_model_sd_mps2", "bias_psd_m2ps5", "gnss_heading"):
        assert of[name].why == "flat"
        assert of[name].value == of[name].before


@pytest.mark.slow
def test_the_same_seed_gives_the_same_values():
    log = drive.without(drive.log(0.5), "imu")
    first, second = (
        tune_one("four-state", load("estimator", "four-state"), log, {}) for _ in range(2)
    )
    assert repr(first.values) == repr(second.values)


@dataclasses.dataclass(frozen=True)
class Mean:
    """An estimator of one's own: the speed is a constant seen in white noise."""

    noise_sd_mps: float = 0.5
    tunable: ClassVar = {"noise_sd_mps": "assumed"}

    def init(self, setup):
        return None

    def run(self, state, chunk):
        epoch_ns = chunk["wheels"]["epoch_ns"]
        return state, {"epoch_ns": epoch_ns, "speed_mps": np.full(len(epoch_ns), 1.6)}

    def innovations(self, setup, streams):
        gnss = streams["gnss"]
        speed = np.hypot(gnss["v_east_mps"], gnss["v_north_mps"])
        variance = np.full(len(speed), self.noise_sd_mps**2)
        sensor = np.full(len(speed), "gnss")
        return {
            "epoch_ns": gnss["epoch_ns"], "sensor": sensor,
            "innovation": speed - 1.6, "variance": variance,
        }  # fmt: skip


def steady():
    return drive.log(drive=dataclasses.replace(drive.DRIVE, speed=lambda t: 1.6 + 0.0 * t))


def test_an_estimator_of_ones_own_joins():
    found = tune_one("mine", Mean(), steady(), {})
    value = next(value for value in found.values if value.name == "noise_sd_mps")
    assert value.value == pytest.approx(0.03, rel=0.1)  # the closed form: the rms of what it saw
    assert value.low < 0.03 < value.high
    assert found.noises.values == {"noise_sd_mps": value.value}
    assert all(v.why == "flat" for v in found.values if v.is_factor)


@pytest.mark.parametrize(
    ("estimator", "message"),
    [
        (load("estimator", "ratio"), r"estimator 'x' has no innovations\(setup, streams\)"),
        (dataclasses.replace(Mean(), noise_sd_mps=0.0), r"noise_sd_mps = 0.0 is no number above 0"),
    ],
)
def test_what_cannot_be_tuned_is_told(estimator, message):
    with pytest.raises(BadInput, match=message):
        tune_one("x", estimator, steady(), {})


def test_a_grade_that_is_none_is_told():
    class Odd(Mean):
        tunable: ClassVar = {"noise_sd_mps": "guessed"}

    with pytest.raises(UnknownName, match=r"no grade of .* 'guessed'.*assumed"):
        tune_one("x", Odd(), steady(), {})


def test_a_short_log_says_how_much_is_missing():
    short = dataclasses.replace(drive.DRIVE, duration_s=40.0)
    with pytest.raises(
        BadInput, match=r"to learn from has 20 s of driving and \d+ .* 30 s and 300"
    ):
        tune_one("four-state", load("estimator", "four-state"), drive.log(drive=short), {})


def test_a_log_without_driving_says_so():
    still = dataclasses.replace(drive.DRIVE, speed=lambda t: 0.0 * t)
    with pytest.raises(BadInput, match=r"no innovations while driving above 0.5 m/s"):
        tune_one("four-state", load("estimator", "four-state"), drive.log(drive=still), {})


def test_the_file_is_what_tuning_reads(tmp_path):
    found = tune_one("mine:Mean", Mean(), steady(), {})
    path = tmp_path / "tuning.toml"
    path.write_text(to_text({"mine:Mean": found}, "twin tune drive"))
    noises = tuned.read(path)["mine:Mean"]
    assert noises.values == pytest.approx(found.noises.values, rel=1e-5)
    assert noises.factors == found.noises.factors


@pytest.mark.parametrize("name", ["four-state", "kf-tuned", "pkf", "slip-ekf"])
def test_innovations_are_of_the_stated_size(name):
    still = dataclasses.replace(drive.DRIVE, duration_s=30.0, speed=lambda t: 1.6 + 0.0 * t)
    log = drive.log(drive=still)
    table = load("estimator", name).innovations(log.setup, log.streams)
    own = (table["sensor"] == "gnss") & (drives.seconds(table["epoch_ns"]) > 5.0)
    nis = np.mean((table["innovation"] ** 2 / table["variance"])[own])
    low, high = (0.7, 1.3) if name != "pkf" else (0.0, 0.3)  # the paper states 0.13 m/s for 0.03
    assert low < nis < high


@pytest.mark.parametrize("name", ["four-state", "kf-tuned", "slip-ekf"])
def test_noting_innovations_changes_no_estimate(name):
    log = drive.log(drive=dataclasses.replace(drive.DRIVE, duration_s=5.0))
    estimator = load("estimator", name)
    before = estimator.run(estimator.init(log.setup), log.streams)[1]["slip"].tobytes()
    estimator.innovations(log.setup, log.streams)
    assert estimator.run(estimator.init(log.setup), log.streams)[1]["slip"].tobytes() == before
    assert not len(estimator.innovations(log.setup, Streams())["epoch_ns"])


def test_a_gain_within_its_interval_is_no_difference():
    rng = np.random.default_rng(1)
    before = rng.uniform(1.0, 2.0, 20)
    noise = 0.1 * rng.standard_normal(20)
    noise -= noise.mean()
    n = np.full(20, 10)
    assert density_gain("x", before, before + noise, n).verdict == "no difference"
    assert density_gain("x", before, before + noise + 0.2, n).verdict == "better"
    assert density_gain("x", before, before + noise - 0.2, n).verdict == "worse"


def test_the_change_of_an_rms():
    rng = np.random.default_rng(2)
    before = rng.uniform(1.0, 2.0, 20)
    gain = rms_gain("x", "m", before, 0.81 * before)
    assert gain.change == pytest.approx(-0.1)
    assert gain.low < -0.1 < gain.high < 0.0
    assert gain.verdict == "better"
    assert rms_gain("x", "m", before[:7], before[:7]) is None
