"""An estimator that is told other noises, and the file that says which."""

import re

import numpy as np
import pytest

from estimators.four_state import FourState
from twin.errors import BadInput, TwinError
from twin.pipeline import tuned
from twin.pipeline.tuned import Noises
from twin.streams import Streams
from twin.testing import check_estimator
from twin.testing.checks import SETUP, sample_streams


def test_factors_multiply_what_the_sheet_and_the_streams_state():
    setup = tuned.scaled_setup(SETUP, {"gnss_velocity": 2.0, "imu_accel": 3.0})
    assert setup.gnss.velocity_sd_mps == 2.0 * SETUP.gnss.velocity_sd_mps
    assert setup.imu.accel_noise_mps2_rthz == 3.0 * SETUP.imu.accel_noise_mps2_rthz
    assert setup.gnss.heading_sd_rad == SETUP.gnss.heading_sd_rad
    stated = {"velocity_sd_mps": np.full(3, 0.04), "epoch_ns": np.arange(3)}
    wheels = {"speed_rl_mps": np.ones(3), "epoch_ns": np.arange(3)}
    streams = tuned.scaled_streams(
        Streams({"gnss": stated, "wheels": wheels}), {"gnss_velocity": 2.0, "wheel_speed": 4.0}
    )
    assert streams["gnss"]["velocity_sd_mps"] == pytest.approx(np.full(3, 0.08))
    assert streams["wheels"]["speed_sd_mps"] == pytest.approx(np.full(3, 0.2))


def test_ticks_have_no_sd_to_multiply():
    streams = tuned.scaled_streams(sample_streams(), {"wheel_speed": 4.0})
    assert "speed_sd_mps" not in streams["wheels"]


def test_a_tuned_estimator_is_one_like_any_other():
    noises = Noises(values={"jerk_psd_m2ps5": 0.5}, factors={"gnss_velocity": 1.5})
    estimator = tuned.tuned("four-state", FourState(), noises)
    assert estimator.estimator.jerk_psd_m2ps5 == 0.5
    check_estimator(estimator)


def test_no_factor_leaves_the_estimator_itself():
    assert tuned.tuned("x", FourState(), Noises()) == FourState()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("schema = 1\n[x.values]\njerk = -1", "x: jerk = -1 is no number above 0"),
        ("schema = 1\n[x.values]\njerk = true", "x: jerk = True is no number above 0"),
        ("schema = 1\n[x.values]\njerk = nan", "x: jerk = nan is no number above 0"),
        ("schema = 1\n[x.factors]\ngnss = 2", "no factor of .* 'gnss'"),
        ("schema = 1\n[x.value]\njerk = 2", "no table of .* 'value'.*values"),
        ("schema = 1\nx = 3", "x is no table"),
        ("schema = 1\n[x]\nvalues = 3", "values = 3 is no table of numbers"),
        ("[x.values]\njerk = 2", "has no 'schema = 1'; twin tune writes such a file"),
        ("schema = ", "is not TOML"),
    ],
)
def test_a_file_that_is_none_is_told(tmp_path, text, message):
    path = tmp_path / "tuning.toml"
    path.write_text(text)
    with pytest.raises(TwinError, match=message):
        tuned.read(path)


def test_a_file_that_is_not_there_is_told(tmp_path):
    with pytest.raises(BadInput, match="there is no such file"):
        tuned.read(tmp_path / "tuning.toml")


def test_a_field_that_is_not_there_is_told():
    with pytest.raises(BadInput, match=r"estimator 'four-state': .*'jerks'.*jerk_psd_m2ps5"):
        tuned.tuned("four-state", FourState(), Noises(values={"jerks": 1.0}))


class Plain:
    def init(self, setup):
        return None


def test_an_estimator_without_fields_is_told():
    with pytest.raises(BadInput, match="'x' is no dataclass, so its jerk cannot be set"):
        tuned.tuned("x", Plain(), Noises(values={"jerk": 1.0}))


def test_a_file_of_others_is_told(tmp_path):
    path = tmp_path / "t.toml"
    with pytest.raises(BadInput, match=re.escape(f"--tuning {path} is of b, and a are run")):
        tuned.applied({"a": FourState()}, {"b": Noises()}, path)


def test_a_note_says_what_was_tuned(tmp_path):
    noises = {"a": Noises(values={"jerk_psd_m2ps5": 0.5}, factors={"gnss_velocity": 2.0})}
    estimators, notes = tuned.applied({"a": FourState()}, noises, tmp_path)
    assert estimators["a"].estimator.jerk_psd_m2ps5 == 0.5
    assert notes == [
        f"a: tuned: jerk_psd_m2ps5 = 0.5, gnss_velocity sd x 2, from {tmp_path}",
    ]
