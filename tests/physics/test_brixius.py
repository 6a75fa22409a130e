"""The tyre-soil law against Brixius' equations as tabulated from the source."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.physics.blocks import soil, soil_of_mobility, wheel
from twin.physics.brixius import brixius, mobility

W = 21.7e3
SLIPS = (0.05, 0.10, 0.15, 0.20, 0.25, 0.30, 0.40, 0.50)
NET_TRACTION = {  # net traction ratio at SLIPS, then best tractive efficiency and its slip
    ("bias", 20): (0.182, 0.340, 0.447, 0.519, 0.566, 0.597, 0.628, 0.637, 0.695, 0.113),
    ("bias", 30): (0.224, 0.399, 0.518, 0.598, 0.652, 0.687, 0.725, 0.738, 0.746, 0.097),
    ("bias", 40): (0.241, 0.423, 0.547, 0.630, 0.687, 0.724, 0.764, 0.779, 0.769, 0.090),
    ("bias", 55): (0.253, 0.437, 0.564, 0.649, 0.707, 0.746, 0.788, 0.804, 0.786, 0.085),
    ("bias", 80): (0.260, 0.446, 0.573, 0.660, 0.718, 0.758, 0.801, 0.819, 0.800, 0.080),
    ("radial", 20): (0.237, 0.410, 0.516, 0.580, 0.617, 0.638, 0.654, 0.653, 0.741, 0.093),
    ("radial", 30): (0.282, 0.474, 0.591, 0.663, 0.706, 0.730, 0.751, 0.753, 0.786, 0.081),
    ("radial", 40): (0.300, 0.499, 0.622, 0.696, 0.741, 0.768, 0.790, 0.794, 0.806, 0.075),
    ("radial", 55): (0.312, 0.514, 0.639, 0.715, 0.762, 0.789, 0.813, 0.819, 0.821, 0.070),
    ("radial", 80): (0.319, 0.523, 0.648, 0.726, 0.773, 0.801, 0.826, 0.833, 0.834, 0.066),
}
RESISTANCE_AT_REST = {
    "bias": (0.090, 0.073, 0.065, 0.058, 0.053),
    "radial": (0.078, 0.062, 0.055, 0.049, 0.044),
}


def ratios(ground, slip):
    """Net and gross traction ratio at a slip, straight ahead."""
    shear, _, resistance, rolling, _ = brixius(ground, wheel(), W, slip, 0.0)
    return (shear - resistance) / W, (shear + rolling) / W


@pytest.mark.parametrize(("tyre", "number"), NET_TRACTION)
def test_net_traction_and_efficiency_are_the_tabulated(tyre, number):
    ground = soil_of_mobility(number, W, radial=tyre == "radial")
    *published, best, at = NET_TRACTION[tyre, number]
    assert [ratios(ground, s)[0] for s in SLIPS] == pytest.approx(published, abs=0.001)
    slips = np.linspace(0.02, 0.4, 1901)
    efficiency = [(1 - s) * np.divide(*ratios(ground, s)) for s in slips]
    assert max(efficiency) == pytest.approx(best, abs=0.001)
    assert slips[np.argmax(efficiency)] == pytest.approx(at, abs=0.002)


@pytest.mark.parametrize("tyre", ["bias", "radial"])
def test_motion_resistance_of_an_unslipping_wheel_is_the_tabulated(tyre):
    found = []
    for number in (20, 30, 40, 55, 80):
        net, gross = ratios(soil_of_mobility(number, W, radial=tyre == "radial"), 0.0)
        found.append(gross - net)
    assert found == pytest.approx(RESISTANCE_AT_REST[tyre], abs=0.00051)


def test_the_mobility_number_of_the_18_4_38_tyre_on_1000_kpa_is_42():
    assert mobility(soil(), wheel(), W) == pytest.approx(42.0, abs=0.1)


def test_a_towed_wheel_skids_and_drags_as_the_source_law_says():
    ground, bn = soil(), mobility(soil(), wheel(), W)
    # gross traction 0.88 (1 - exp(-0.1 Bn)) (1 - exp(-7.5 s)) + 0.04 = 0 without axle torque
    skid = math.log(1.0 - 0.04 / (0.88 * (1.0 - math.exp(-0.1 * bn)))) / 7.5
    shear, _, resistance, rolling, _ = brixius(ground, wheel(), W, skid, 0.0)
    assert skid == pytest.approx(-0.006, abs=0.0005)
    assert shear + rolling == pytest.approx(0.0, abs=1e-9 * W)
    assert (shear - resistance) / W == pytest.approx(-0.064, abs=0.0005)


def test_nothing_slips_nothing_shears():
    x, y, *_ = brixius(soil(), wheel(), W, 0.0, 0.0)
    assert (x, y) == (0.0, 0.0)


@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_the_shear_is_odd_and_mirrors_left_and_right(slip, side):
    x, y, *_ = brixius(soil(), wheel(), W, slip, side)
    assert brixius(soil(), wheel(), W, -slip, -side)[:2] == (-x, -y)
    assert brixius(soil(), wheel(), W, slip, -side)[:2] == (x, -y)


@given(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5), st.floats(500.0, 60e3))
def test_the_shear_stays_within_its_ceiling_and_dissipates(slip, side, load):
    x, y, resistance, rolling, _ = brixius(soil(), wheel(), load, slip, side)
    ceiling = load * 0.88 * (1.0 - math.exp(-0.1 * mobility(soil(), wheel(), load)))
    assert math.hypot(x, y) <= ceiling * (1.0 + 1e-12)
    # the contact patch slides over the ground at -(slip, side) V, and the shear acts against that
    assert -(x * slip + y * side) <= 0.0
    assert resistance >= 0.0
    assert rolling >= 0.0


def test_more_slip_pulls_more_straight_ahead_and_less_sideways():
    slips = np.linspace(0.0, 1.0, 101)
    straight = [brixius(soil(), wheel(), W, s, 0.0)[0] for s in slips]
    assert np.all(np.diff(straight) > 0.0)
    sideways = [brixius(soil(), wheel(), W, s, 0.1)[1] for s in slips[10:]]
    assert np.all(np.diff(sideways) < 0.0)


@given(st.floats(-0.5, 0.5), st.floats(1e3, 30e3), st.floats(0.2, 4.0))
def test_at_one_mobility_number_forces_scale_with_load(slip, load, factor):
    once = brixius(soil_of_mobility(42.0, load), wheel(), load, slip, 0.1)
    scaled = brixius(soil_of_mobility(42.0, factor * load), wheel(), factor * load, slip, 0.1)
    assert scaled == pytest.approx([factor * f for f in once], rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, 1.0), (0.6, -0.8)])
def test_the_shear_passes_through_zero_without_a_step_or_a_kink(direction):
    """Its slope at zero is the slip stiffness, on both sides of where the series takes over."""
    bn = mobility(soil(), wheel(), W)
    stiffness = W * 0.88 * (1.0 - math.exp(-0.1 * bn)) * 7.5
    for size in (1e-4, 1e-6, 2e-9, 0.9e-9, 1e-12):
        x, y, *_ = brixius(soil(), wheel(), W, size * direction[0], size * direction[1])
        assert x / size == pytest.approx(stiffness * direction[0], rel=1e-3)
        assert y / size == pytest.approx(stiffness * 0.85**2 * direction[1] / 0.85, rel=1e-3)
