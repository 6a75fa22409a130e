import numpy as np
import pytest

from tests.sensors.trajectories import collect, drive
from twin.errors import OutOfRange
from twin.sensors import Bus, machine, suite

IDEAL = suite.ideal().machine


def test_without_noise_each_quantity_is_rounded_to_its_resolution():
    table = collect(machine, IDEAL, [drive(2, engine_radps=np.linspace(100.0, 200.0, 1001))])
    for name, step, truth in (
        ("steer_rad", 1 / 1024, 0.1),
        ("hitch_m", 0.004 * 0.9, 0.9 * np.sin(-0.2)),
        ("draft_pin_n", 10.0, 20e3),
        ("engine_radps", 0.125 * np.pi / 30, np.linspace(100, 200, 21)),
        ("engine_load", 0.01, 300 / 600),
        ("fuel_lph", 0.05, 20.0),
    ):
        np.testing.assert_allclose(table[name], truth, atol=step / 2 * (1 + 1e-9))
        np.testing.assert_allclose(table[name] / step, np.rint(table[name] / step), atol=1e-9)


def test_it_speaks_ten_times_a_second():
    table = collect(machine, Bus(), [drive(2)])
    np.testing.assert_array_equal(np.diff(table["epoch_ns"]), 100_000_000)
    assert np.all(table["arrival_ns"] - table["epoch_ns"] >= 10_000_000)


def test_transducers_have_their_noise_and_scale():
    table = collect(machine, Bus(draft_pin_scale_error=0.02), [drive(300, step_ns=100_000_000)])
    assert table["draft_pin_n"].std() == pytest.approx(150, rel=0.1)
    assert table["draft_pin_n"].mean() == pytest.approx(20_400, abs=15)
    assert table["axle_torque_nm"].std() == pytest.approx(30, rel=0.1)


def test_engine_speed_is_noisy_while_the_engine_turns():
    turning = drive(300, step_ns=100_000_000)
    noisy, ideal = (collect(machine, bus, [turning])["engine_radps"] for bus in (Bus(), IDEAL))
    assert (noisy - ideal).std() == pytest.approx(0.8 * np.pi / 30, rel=0.1)
    standing = drive(2, engine_radps=np.zeros(1001))
    assert np.all(collect(machine, Bus(), [standing])["engine_radps"] == 0.0)


def test_bad_values_are_named():
    with pytest.raises(OutOfRange, match=r"machine\.rate_hz = 0 is outside"):
        Bus(rate_hz=0)
