"""The whole tractor on the rigs against statics and the wheel rig, and on slopes at rest."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from twin.errors import BadInput, OutOfRange
from twin.rig.drawbar import drawbar, expected_pull_n
from twin.rig.park import park
from twin.rig.slope import NoBalance, expected, slope
from twin.rig.tractor import statics
from twin.scenario import Soil

SLIPS = np.array([0.05, 0.10, 0.15, 0.20, 0.25, 0.30])


def pulls_what_its_wheels_pull(soil, hitch_m):
    curve = drawbar(soil, hitch_m=hitch_m, most_slip=0.33)
    pull = np.interp(SLIPS, curve.slip, curve.pull_n)
    assert pull == pytest.approx(expected_pull_n(soil, SLIPS, hitch_m=hitch_m), rel=0.01)


def test_the_tractor_pulls_what_its_wheels_pull_after_weight_transfer():
    """On other soils and hitches: tests/long."""
    pulls_what_its_wheels_pull(Soil(), 0.45)


def test_pulling_moves_load_to_the_rear_by_the_height_of_the_hitch():
    """d N_r = h P / L, less what the first point already had, in the middle of the ramp."""
    body = statics(Soil())
    curve = drawbar(Soil(), ramp_nps=400.0, most_slip=0.15)
    moved = curve.rear_load_n[-1] - curve.rear_load_n[0]
    pulled = curve.pull_n[-1] - curve.pull_n[0]
    assert moved == pytest.approx(0.45 * pulled / body.wheelbase_m, rel=0.05)
    assert curve.front_load_n + curve.rear_load_n == pytest.approx(body.weight_n, rel=1e-3)
    assert np.all(np.diff(curve.slip) > 0.0)


def test_the_drawbar_rig_repeats_itself_to_the_bit():
    first, second = (drawbar(Soil(), ramp_nps=1000.0, most_slip=0.05) for _ in range(2))
    for name, values in first.columns().items():
        assert np.array_equal(values, second.columns()[name])


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
    with pytest.raises(OutOfRange, match="cross_slope_deg"):
        slope(Soil(), [60.0])
    with pytest.raises(BadInput, match="lengths"):
        park(Soil(), cross_slope_deg=[1.0, 2.0], grade_deg=[1.0, 2.0, 3.0])
