import numpy as np
import pytest

from tests.sensors.trajectories import collect, drive
from twin.errors import OutOfRange
from twin.sensors import Depth, depth


def test_standing_still_only_the_lasers_own_noise_is_left():
    table = collect(depth, Depth(), [drive(200, speed_mps=0)])
    assert table["laser_m"].std() == pytest.approx(0.003, rel=0.1)
    assert table["inclination_rad"].std() == pytest.approx(np.radians(0.2), rel=0.1)
    assert table["inclination_rad"].mean() == pytest.approx(0.05, abs=2e-4)


def test_clods_have_their_sd_and_length_along_the_path():
    for speed in (0.5, 2.0):
        config = Depth(laser_sd_m=0)
        table = collect(depth, config, [drive(4000, speed_mps=speed, step_ns=20_000_000)])
        error = table["laser_m"] - 0.9
        assert error.std() == pytest.approx(0.004, rel=0.1)
        lag = round(0.04 * 50 / speed)  # samples in 4 cm of path
        ratio = np.mean(error[lag:] * error[:-lag]) / np.mean(error**2)
        assert -0.04 / np.log(ratio) == pytest.approx(0.1, rel=0.1)


def test_biases_are_added():
    config = Depth(
        laser_sd_m=0, clod_sd_m=0, inclinometer_sd_rad=0, laser_bias_m=0.01,
        inclination_bias_rad=-0.02,
    )  # fmt: skip
    table = collect(depth, config, [drive(1)])
    np.testing.assert_allclose(table["laser_m"], 0.91)
    np.testing.assert_allclose(table["inclination_rad"], 0.03)


def test_bad_values_are_named():
    with pytest.raises(OutOfRange, match=r"depth\.clod_length_m = 0 is outside"):
        Depth(clod_length_m=0)
