"""The governed diesel against its data sheet and the governor's law."""

import numpy as np
import pytest

from tests.physics.blocks import engine
from twin.physics.engine import (
    axle_torque_nm,
    engine_torque_nm,
    full_load_torque_nm,
    parasitic_torque_nm,
)


def test_full_load_goes_through_rated_and_peak_torque():
    assert full_load_torque_nm(engine(), 2200.0) == pytest.approx(447.0)
    assert full_load_torque_nm(engine(), 1450.0) == pytest.approx(1.30 * 447.0)
    curve = [full_load_torque_nm(engine(), n) for n in np.arange(800.0, 2377.0)]
    assert 800 + np.argmax(curve) == 1450


def test_rated_power_is_103_kw():
    assert 447.0 * 2200.0 * np.pi / 30.0 == pytest.approx(103e3, rel=0.001)
    assert engine_torque_nm(engine(), 1.0, 2200.0) == pytest.approx(447.0, rel=0.001)


@pytest.mark.parametrize("set_rpm", [1100.0, 1628.0, 2376.0])
def test_the_governor_droops_as_one_over_its_setting(set_rpm):
    """0.394 rpm/(N m) at full throttle, growing as 2376/n0; no torque at the no-load speed."""
    throttle = (set_rpm - 800.0) / (2376.0 - 800.0)
    assert engine_torque_nm(engine(), throttle, set_rpm) == pytest.approx(0.0, abs=1e-9)
    droop = 0.394 * 2376.0 / set_rpm
    at_300_nm = engine_torque_nm(engine(), throttle, set_rpm - 300.0 * droop)
    assert at_300_nm == pytest.approx(300.0)


@pytest.mark.parametrize("throttle", [0.0, 0.5, 1.0])
def test_the_torque_has_no_steps(throttle):
    rpm = np.linspace(-600.0, 3000.0, 36001)
    torque = np.array([engine_torque_nm(engine(), throttle, n) for n in rpm])
    at_axle = [axle_torque_nm(engine(), t, n) for t, n in zip(torque, rpm, strict=True)]
    assert np.max(np.abs(np.diff(torque))) < 0.6  # 0.1 rpm apart
    assert np.max(np.abs(np.diff(at_axle))) < 66.0 * 0.7


def test_the_transmission_loses_whichever_way_power_flows():
    for torque, rpm in [(400.0, 1500.0), (-60.0, 2300.0), (0.0, -300.0), (80.0, -20.0)]:
        into = torque * rpm
        out = axle_torque_nm(engine(), torque, rpm) * rpm / 66.0
        assert out < into


def test_a_stalled_engine_does_not_drive_backwards():
    for rpm in np.linspace(-900.0, 0.0, 181):
        torque = engine_torque_nm(engine(), 1.0, rpm)
        assert axle_torque_nm(engine(), torque, rpm) >= 0.0


def test_the_transmission_passes_what_the_parasites_leave():
    """i (T - 25) eta forwards; the same over eta when the wheels turn the engine."""
    assert axle_torque_nm(engine(), 400.0, 1500.0) == pytest.approx(66.0 * 375.0 * 0.87)
    assert axle_torque_nm(engine(), -60.0, 2300.0) == pytest.approx(66.0 * -85.0 / 0.87)
    assert parasitic_torque_nm(engine(), 1500.0) == 25.0
    assert parasitic_torque_nm(engine(), -1500.0) == -25.0
    assert parasitic_torque_nm(engine(), 10.0) == pytest.approx(5.0)


def test_a_dying_engine_loses_its_torque_between_500_and_300_rpm():
    peak, rated = 1.30 * 447.0, 447.0
    for rpm, share in ((500.0, 1.0), (400.0, 0.5), (350.0, 0.25), (300.0, 0.0), (0.0, 0.0)):
        parabola = peak - (peak - rated) * ((rpm - 1450.0) / 750.0) ** 2
        assert full_load_torque_nm(engine(), rpm) == pytest.approx(share * parabola)
    for rpm in np.linspace(-100.0, 300.0, 41):
        for throttle in (0.0, 0.5, 1.0):
            assert engine_torque_nm(engine(), throttle, rpm) == 0.0


@pytest.mark.parametrize(("rpm", "lives"), [(290.0, False), (450.0, True)])
def test_an_unloaded_engine_below_its_stall_dies_and_above_it_recovers(rpm, lives):
    """2 kg m2 on its own torque and parasites, at full throttle, for 5 s."""
    for _ in range(2500):
        net = engine_torque_nm(engine(), 1.0, rpm) - parasitic_torque_nm(engine(), rpm)
        rpm += 0.002 * net / 2.0 * 30.0 / np.pi
    assert (rpm > 2000.0) if lives else (abs(rpm) < 1.0)
