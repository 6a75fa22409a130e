"""The governed diesel against its data sheet and the governor's law."""

import numpy as np
import pytest

from tests.physics.blocks import engine, motor
from twin.physics.engine import (
    axle_torque_nm,
    braking_torque_nm,
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


RPM = np.arange(1.0, 3001.0)
RADPS = RPM * np.pi / 30.0


@pytest.mark.parametrize("rise", [1.0, 1.30, 1.38, 1.5])
@pytest.mark.parametrize("bulge", [1.0, 1.09])
def test_no_speed_gives_more_than_the_maximum_power(rise, bulge):
    """Of a machine that bulges above its rated power (8245R: 9 %) no more than that."""
    own = engine(torque_rise=rise, max_power_w=bulge * 103e3)
    power_w = np.array([full_load_torque_nm(own, n) for n in RPM]) * RADPS
    assert power_w.max() <= bulge * 103e3 * (1.0 + 1e-12)
    assert power_w.max() >= 0.999 * 103e3
    governed = np.array([engine_torque_nm(own, 1.0, n) for n in RPM]) * RADPS
    assert governed.max() <= bulge * 103e3 * (1.0 + 1e-12)
    assert full_load_torque_nm(own, 1450.0) == pytest.approx(rise * 447.0)


def test_between_peak_and_rated_speed_the_power_is_the_maximum_and_the_torque_has_no_step():
    torque = np.array([full_load_torque_nm(engine(), n) for n in RPM])
    flat = (RPM > 1850.0) & (RPM < 2190.0)
    assert torque[flat] * RADPS[flat] == pytest.approx(103e3)
    assert np.max(np.abs(np.diff(torque[(RPM > 600.0) & (RPM < 2400.0)]))) < 1.0  # a rpm apart


def motored_nm(rpm, litres, stroke_m, exhaust_kpa=0.0):
    """Millington and Hartles by hand, in their units: kPa, rpm, m/s."""
    piston_mps = 2.0 * stroke_m * rpm / 60.0
    kpa = 75.0 + 48.0 * rpm / 1000.0 + 0.4 * piston_mps**2 + exhaust_kpa
    return kpa * litres / (4.0 * np.pi)


@pytest.mark.parametrize("rpm", [800.0, 1665.0, 2200.0, 2760.0])
def test_a_motored_diesel_drags_more_the_faster_it_turns_and_the_larger_it_is(rpm):
    assert engine_torque_nm(engine(), 0.0, rpm + 600.0) == -braking_torque_nm(engine(), rpm + 600.0)
    assert braking_torque_nm(engine(), rpm) == pytest.approx(motored_nm(rpm, 6.5, 0.125))
    closed = engine(exhaust_brake_pa=250e3)
    assert braking_torque_nm(closed, rpm) == pytest.approx(motored_nm(rpm, 6.5, 0.125, 250.0))
    small = engine(displacement_m3=3e-3, stroke_m=0.1)
    assert braking_torque_nm(small, rpm) == pytest.approx(motored_nm(rpm, 3.0, 0.1))
    assert braking_torque_nm(engine(), rpm + 1.0) > braking_torque_nm(engine(), rpm)


def test_the_drag_is_a_quarter_of_the_torque_at_rated_speed():
    """Trucks' engines drag with 5 to 7 kW a litre at their higher rated speeds; here 4."""
    drag_w = braking_torque_nm(engine(), 2200.0) * 2200.0 * np.pi / 30.0
    assert 3e3 < drag_w / 6.5 < 6e3


@pytest.mark.parametrize("rpm", [-3500.0, -1000.0, -200.0, 200.0, 1000.0, 3500.0])
def test_a_motor_drives_and_regenerates_within_its_limits(rpm):
    rate = abs(rpm) * np.pi / 30.0
    assert braking_torque_nm(motor(), rpm) == pytest.approx(min(8.0, 500.0 / rate))
    most_w = 1000.0 if rpm > 0.0 else 500.0  # pushed backwards it regenerates
    assert full_load_torque_nm(motor(), rpm) == pytest.approx(min(8.0, most_w / rate))
    for throttle in (0.1, 0.8, 1.0):
        torque = engine_torque_nm(motor(), throttle, rpm)
        assert -500.001 <= torque * rpm * np.pi / 30.0 <= 1000.001
        assert abs(torque) <= 8.0


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
