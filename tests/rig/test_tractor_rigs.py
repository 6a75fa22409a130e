"""The whole tractor on the rigs against statics and the wheel rig, and on slopes at rest."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from twin.errors import BadInput, OutOfRange
from twin.machine.fuel import fuel_lph
from twin.rig.drawbar import drawbar, expected_pull_n, pulled
from twin.rig.gears import gears
from twin.rig.park import park
from twin.rig.slope import NoBalance, expected, slope
from twin.rig.tractor import statics
from twin.scenario import Drive, Scenario, Soil
from twin.simulation.build import build

SLIPS = np.array([0.05, 0.10, 0.15, 0.20, 0.25, 0.30])


def pulls_what_its_wheels_pull(soil, hitch_m):
    curve = drawbar(soil, hitch_m=hitch_m, most_slip=0.33)
    pull = np.interp(SLIPS, curve.slip, curve.pull_n)
    assert pull == pytest.approx(expected_pull_n(soil, SLIPS, hitch_m=hitch_m), rel=0.01)


def test_the_tractor_pulls_what_its_wheels_pull_after_weight_transfer():
    """On other soils and hitches: tests/long."""
    pulls_what_its_wheels_pull(Soil(), 0.45)


def test_pulling_moves_load_to_the_rear_by_the_height_of_the_hitch():
    """d N_r = h P / L, less what the first point already had."""
    body = statics(Soil())
    curve = drawbar(Soil(), step_n=2000.0, most_slip=0.15)
    moved = curve.rear_load_n[-1] - curve.rear_load_n[0]
    pulled = curve.pull_n[-1] - curve.pull_n[0]
    assert moved == pytest.approx(0.45 * pulled / body.wheelbase_m, rel=0.05)
    assert curve.front_load_n + curve.rear_load_n == pytest.approx(body.weight_n, rel=1e-3)
    assert np.all(np.diff(curve.slip) > 0.0)


def test_the_drawbar_rig_repeats_itself_to_the_bit():
    first, second = (drawbar(Soil(), step_n=2000.0, most_slip=0.05) for _ in range(2))
    for name, values in first.columns().items():
        assert np.array_equal(values, second.columns()[name])


def test_nothing_that_is_stored_counts_as_work():
    """At every hold the axle gets what parasites and gears leave of the crank's power, no more.

    A ramp that slowed the engine read a drawbar power of 0.87 to 0.89 of it in some gears.
    """
    gear = Drive(gear_ratio=47.0, engine_set_rpm=2400.0)
    curve = drawbar(Soil(preset="asphalt"), first_n=8e3, step_n=2000.0, most_slip=0.1, gear=gear)
    axle_w = (curve.crank_power_w - 25.0 * curve.engine_rpm * np.pi / 30.0) * 0.87
    axle_radps = curve.engine_rpm * np.pi / 30.0 / 47.0
    assert curve.axle_torque_nm * axle_radps == pytest.approx(axle_w, rel=3e-3)
    assert np.all(curve.drawbar_power_w < 0.95 * axle_w)
    assert np.all(curve.drawbar_power_w < 0.79 * curve.crank_power_w)


def test_a_load_that_the_tractor_does_not_hold_ends_the_test():
    """A high gear stalls before it slips: the last point still holds the engine's full torque."""
    gear = Drive(gear_ratio=30.0, engine_set_rpm=2400.0)
    curve = drawbar(Soil(preset="asphalt"), first_n=8e3, step_n=1000.0, gear=gear)
    assert curve.slip[-1] < 0.15
    assert 1300.0 < curve.engine_rpm[-1] < 2200.0
    assert curve.pull_n[-1] < 20e3


@pytest.fixture(scope="module")
def hard_road():
    return gears(Soil(preset="asphalt"), speeds_kmh=(5.0, 8.5, 12.0, 15.0))


@pytest.mark.slow
def test_low_gears_are_held_by_slip_and_high_ones_by_power(hard_road):
    assert hard_road.slip[0] > 0.12
    assert np.all(hard_road.slip <= 0.15)
    assert np.all(np.diff(hard_road.drawbar_power_w) > 0.0)
    assert hard_road.crank_power_w[-2:] == pytest.approx(103e3, rel=1e-3)
    assert np.all(hard_road.crank_power_w <= 1.01 * 103e3)
    assert 0.70 < hard_road.drawbar_power_w.max() / 103e3 < 0.78


@pytest.mark.slow
def test_a_gear_runs_its_speed_at_rated_engine_speed(hard_road):
    speed_mps = 2200.0 * np.pi / 30.0 / hard_road.gear_ratio * 0.8489
    assert 3.6 * speed_mps == pytest.approx(hard_road.gear_kmh)


@pytest.mark.slow
def test_a_gear_s_fuel_is_that_of_its_power_and_speed(hard_road):
    numbers = build(Scenario(name="fuel"), settle=False).numbers
    radps = hard_road.engine_rpm * np.pi / 30.0
    assert hard_road.fuel_lph == pytest.approx(fuel_lph(numbers, hard_road.crank_power_w, radps))
    per_kwh = hard_road.fuel_lph / (0.9e-3 * hard_road.crank_power_w)
    assert np.all((per_kwh[-2:] > 0.27) & (per_kwh[-2:] < 0.33))  # the engine is fully loaded


def brixius_crab_rad(theta, axle_load_n, lateral_n, cone_index_kpa):
    """Rear slip angle whose Brixius side force, both wheels under one load, is lateral_n."""
    b, d, kappa = 0.467, 1.755, 0.85
    load = 0.5 * axle_load_n * math.cos(theta)
    bn = cone_index_kpa * 1e3 * b * d / load * 2.0 / (1.0 + 3.0 * b / d)
    top = 2.0 * load * 0.88 * (1.0 - math.exp(-0.1 * bn))

    def left_over(angle):
        return top * (1.0 - math.exp(-7.5 * kappa * math.tan(angle))) - lateral_n

    return brentq(left_over, 0.0, 1.0)


def test_a_crab_angle_is_the_slip_angle_that_holds_the_rear_axles_share_of_the_weight():
    """By the law alone: N_r 0.88 (1 - exp(-Bn/10)) (1 - exp(-k kappa tan(beta))) = G (1 - x / L).

    Without longitudinal slip, load transfer and the yaw moment of unequal wheels, which together
    are some per cent.
    """
    body, angle = statics(Soil()), 6.0
    theta = math.radians(angle)
    share = 1.0 - body.cg_ahead_m / body.wheelbase_m
    lateral_n = share * body.weight_n * math.sin(theta)
    alone = brixius_crab_rad(theta, share * body.weight_n, lateral_n, 1200.0)
    seen = slope(Soil(), [angle])
    assert seen.crab_angle_rad[0] == pytest.approx(alone, rel=0.08)


def crabs_as_the_equilibrium_does(preset, slopes):
    seen, wanted = slope(Soil(preset=preset), slopes), expected(Soil(preset=preset), slopes)
    assert seen.crab_angle_rad == pytest.approx(wanted.crab_angle_rad, rel=0.01)
    assert seen.slip == pytest.approx(wanted.slip, rel=0.03)
    assert seen.steer_rad == pytest.approx(wanted.steer_rad, rel=0.05)
    assert seen.lower_load_n == pytest.approx(wanted.lower_load_n, rel=0.015)


def test_the_crab_angle_is_that_of_the_equilibrium():
    """On other slopes and soils: tests/long."""
    crabs_as_the_equilibrium_does("firm", [12.0])


def test_the_other_slope_is_the_mirror_image_and_the_level_has_no_crab_angle():
    seen = slope(Soil(), [-8.0, 0.0, 8.0])
    assert seen.crab_angle_rad[0] == pytest.approx(-seen.crab_angle_rad[2], rel=1e-6)
    assert seen.upper_load_n[0] == pytest.approx(seen.lower_load_n[2], rel=1e-6)
    assert abs(seen.crab_angle_rad[1]) < 1e-9


def test_a_slope_that_tyres_do_not_hold_has_no_equilibrium():
    with pytest.raises(NoBalance, match="cross_slope_deg = 18"):
        expected(Soil(friction=0.25), [18.0])


@pytest.mark.parametrize("law", ["brixius", "bekker"])
def test_the_parked_tractor_creeps_less_than_a_tenth_of_a_millimetre(law):
    creep = park(Soil(law=law), cross_slope_deg=[18.0, 0.0, 0.0], grade_deg=[0.0, 15.0, -15.0])
    assert np.all(creep.creep_m < 1e-4)
    assert np.all(creep.creep_rate_mps < 1e-9)


def test_on_ground_too_slippery_it_slides():
    creep = park(Soil(friction=0.25), cross_slope_deg=18.0, parked_s=6.0)
    assert creep.creep_m[0] > 0.5
    assert creep.creep_rate_mps[0] > 0.1


def test_what_cannot_be_tested_is_refused():
    with pytest.raises(OutOfRange, match="hitch_m"):
        drawbar(Soil(), hitch_m=5.0)
    with pytest.raises(OutOfRange, match="hitch_m"):
        pulled(Soil(), [1e3], hitch_m=5.0)
    with pytest.raises(BadInput, match="pulls_n"):
        pulled(Soil(), [])
    with pytest.raises(OutOfRange, match="step_n"):
        drawbar(Soil(), step_n=1.0)
    with pytest.raises(OutOfRange, match="speeds_kmh"):
        gears(Soil(), speeds_kmh=(90.0,))
    with pytest.raises(OutOfRange, match="cross_slope_deg"):
        slope(Soil(), [60.0])
    with pytest.raises(BadInput, match="lengths"):
        park(Soil(), cross_slope_deg=[1.0, 2.0], grade_deg=[1.0, 2.0, 3.0])
    for nothing in (lambda: gears(Soil(), speeds_kmh=()), lambda: slope(Soil(), [])):
        with pytest.raises(BadInput, match="is empty"):
            nothing()
    with pytest.raises(BadInput, match="no slopes"):
        park(Soil(), cross_slope_deg=[])
