"""The single-wheel rig against the published equations, evaluated here on their own."""

import numpy as np
import pytest
from scipy.optimize import brentq

from twin.errors import BadInput, OutOfRange, UnknownName
from twin.rig.tyre import Tyre
from twin.rig.wheel import outside_range, self_propelled, towed, wheel
from twin.scenario import Soil

WIDTH_M, DIAMETER_M, LOAD_N = 0.467, 1.755, 21700.0
TYRE = Tyre()
KINDS = {"bias": (7.5, 0.04, 1.0), "radial": (9.5, 0.0325, 0.9)}
MOBILITIES = (20.0, 30.0, 40.0, 55.0, 80.0)
SLIPS = np.array([0.05, 0.10, 0.15, 0.20, 0.25, 0.30, 0.40, 0.50])
NET = {
    ("bias", 20): (0.182, 0.340, 0.447, 0.519, 0.566, 0.597, 0.628, 0.637),
    ("bias", 30): (0.224, 0.399, 0.518, 0.598, 0.652, 0.687, 0.725, 0.738),
    ("bias", 40): (0.241, 0.423, 0.547, 0.630, 0.687, 0.724, 0.764, 0.779),
    ("bias", 55): (0.253, 0.437, 0.564, 0.649, 0.707, 0.746, 0.788, 0.804),
    ("bias", 80): (0.260, 0.446, 0.573, 0.660, 0.718, 0.758, 0.801, 0.819),
    ("radial", 20): (0.237, 0.410, 0.516, 0.580, 0.617, 0.638, 0.654, 0.653),
    ("radial", 30): (0.282, 0.474, 0.591, 0.663, 0.706, 0.730, 0.751, 0.753),
    ("radial", 40): (0.300, 0.499, 0.622, 0.696, 0.741, 0.768, 0.790, 0.794),
    ("radial", 55): (0.312, 0.514, 0.639, 0.715, 0.762, 0.789, 0.813, 0.819),
    ("radial", 80): (0.319, 0.523, 0.648, 0.726, 0.773, 0.801, 0.826, 0.833),
}
"""Net traction ratio at SLIPS by Brixius' equations, to three digits."""
TOP_EFFICIENCY = {
    ("bias", 20): (0.695, 0.113), ("bias", 30): (0.746, 0.097), ("bias", 40): (0.769, 0.090),
    ("bias", 55): (0.786, 0.085), ("bias", 80): (0.800, 0.080), ("radial", 20): (0.741, 0.093),
    ("radial", 30): (0.786, 0.081), ("radial", 40): (0.806, 0.075), ("radial", 55): (0.821, 0.070),
    ("radial", 80): (0.834, 0.066),
}  # fmt: skip
LAWS = [Soil(law="brixius"), Soil(law="bekker")]


def soil_of(bn):
    """The soil on which this tyre under this load has a mobility number (delta / h = 0.20)."""
    bracket = (1.0 + 5.0 * 0.20) / (1.0 + 3.0 * WIDTH_M / DIAMETER_M)
    return Soil(cone_index_kpa=1e-3 * bn * LOAD_N / (WIDTH_M * DIAMETER_M * bracket))


def gross(kind, bn, s):
    k, c0, _ = KINDS[kind]
    return np.sign(s) * 0.88 * (1 - np.exp(-0.1 * bn)) * (1 - np.exp(-k * np.abs(s))) + c0


def resistance(kind, bn, s):
    _, c0, m = KINDS[kind]
    return m / bn + c0 + 0.5 * np.abs(s) / np.sqrt(bn)


@pytest.mark.parametrize("bn", MOBILITIES)
@pytest.mark.parametrize("kind", KINDS)
def test_traction_of_one_wheel_as_brixius_published(kind, bn):
    seen = wheel(TYRE, soil_of(bn), slip=SLIPS, load_n=LOAD_N, radial=kind == "radial")
    thrust, drag = gross(kind, bn, SLIPS), resistance(kind, bn, SLIPS)
    assert seen.slip == pytest.approx(SLIPS, abs=1e-9)
    assert seen.net_traction_ratio == pytest.approx(np.array(NET[kind, bn]), abs=0.001)
    assert seen.gross_traction_ratio == pytest.approx(thrust, abs=1e-4)
    assert seen.motion_resistance_ratio == pytest.approx(drag, abs=1e-4)
    efficiency = (1 - SLIPS) * (thrust - drag) / thrust
    assert seen.tractive_efficiency == pytest.approx(efficiency, abs=1e-4)
    top, at = TOP_EFFICIENCY[kind, bn]
    best = wheel(TYRE, soil_of(bn), slip=at, load_n=LOAD_N, radial=kind == "radial")
    assert best.tractive_efficiency[0] == pytest.approx(top, abs=0.001)


@pytest.mark.parametrize("bn", [20.0, 42.0, 80.0])
@pytest.mark.parametrize("kind", KINDS)
def test_a_wheel_without_torque_skids_and_a_wheel_without_pull_slips(kind, bn):
    radial = kind == "radial"
    skid = brentq(lambda s: gross(kind, bn, s), -0.2, 0.0)
    pulled = towed(TYRE, soil_of(bn), load_n=LOAD_N, radial=radial)
    assert pulled.slip[0] == pytest.approx(skid, rel=0.005)
    assert pulled.towed_ratio[0] == pytest.approx(resistance(kind, bn, skid), rel=0.005)
    slip = brentq(lambda s: gross(kind, bn, s) - resistance(kind, bn, s), 1e-9, 0.1)
    driven = self_propelled(TYRE, soil_of(bn), load_n=LOAD_N, radial=radial)
    assert driven.slip[0] == pytest.approx(slip, rel=0.005)
    torque_nm = gross(kind, bn, slip) * LOAD_N * driven.rolling_radius_m[0]
    assert driven.axle_torque_nm[0] == pytest.approx(torque_nm, rel=0.005)


@pytest.mark.parametrize("soil", LAWS, ids=lambda s: s.law)
def test_side_force_is_odd_and_traction_even_in_slip_angle(soil):
    slip, angle = np.meshgrid([-0.1, 0.0, 0.1, 0.3], np.radians([2.0, 8.0, 20.0]))
    right = wheel(TYRE, soil, slip=slip, load_n=LOAD_N, slip_angle_rad=angle)
    left = wheel(TYRE, soil, slip=slip, load_n=LOAD_N, slip_angle_rad=-angle)
    assert right.slip_angle_rad == pytest.approx(angle.ravel(), abs=1e-7)
    assert right.lateral_n == pytest.approx(-left.lateral_n, rel=1e-6)
    assert right.net_pull_n == pytest.approx(left.net_pull_n, rel=1e-6, abs=0.1)
    assert right.axle_torque_nm == pytest.approx(left.axle_torque_nm, rel=1e-6, abs=0.1)
    assert np.all(right.lateral_n > 0.0)  # it slides to the right, the ground pushes left


@pytest.mark.parametrize("soil", LAWS, ids=lambda s: s.law)
def test_traction_grows_with_slip_and_passes_zero_without_a_step(soil):
    slip = np.concatenate([[-0.3, -0.2, -0.1], np.linspace(-0.02, 0.02, 21), [0.1, 0.2, 0.4]])
    seen = wheel(TYRE, soil, slip=slip, load_n=LOAD_N)
    assert np.all(np.diff(seen.net_traction_ratio) > 0.0)
    assert np.all(np.diff(seen.gross_traction_ratio) > 0.0)
    steps = np.diff(seen.net_traction_ratio)[3:23]
    assert steps.max() < 2.0 * steps.min()


@pytest.mark.parametrize("soil", LAWS, ids=lambda s: s.law)
def test_side_force_takes_from_traction(soil):
    angle = np.radians([0.0, 3.0, 6.0, 12.0, 25.0])
    seen = wheel(TYRE, soil, slip=0.1, load_n=LOAD_N, slip_angle_rad=angle)
    assert np.all(np.diff(seen.lateral_n) > 0.0)
    assert np.all(np.diff(seen.net_pull_n) < 0.0)


@pytest.mark.parametrize("soil", LAWS, ids=lambda s: s.law)
def test_what_the_axle_gives_is_pulled_slipped_and_rolled_away(soil):
    """T w = P v + losses, and no loss is negative, at any slip and slip angle."""
    slip, angle = np.meshgrid([-0.3, -0.05, 0.0, 0.05, 0.3], np.radians([0.0, 5.0, 20.0]))
    seen = wheel(TYRE, soil, slip=slip, load_n=LOAD_N, slip_angle_rad=angle)
    roll = np.cos(seen.slip_angle_rad)
    spin = np.where(seen.slip >= 0.0, roll / (1 - seen.slip), roll * (1 + seen.slip))
    given = seen.axle_torque_nm / seen.rolling_radius_m * spin
    taken = seen.net_pull_n * roll - seen.lateral_n * np.sin(seen.slip_angle_rad)
    assert np.all(given - taken > 0.0)


@pytest.mark.parametrize("soil", LAWS, ids=lambda s: s.law)
def test_the_steady_state_knows_no_speed(soil):
    slow = wheel(TYRE, soil, slip=0.15, load_n=LOAD_N, slip_angle_rad=0.1, speed_mps=0.8)
    fast = wheel(TYRE, soil, slip=0.15, load_n=LOAD_N, slip_angle_rad=0.1, speed_mps=3.0)
    assert fast.net_pull_n == pytest.approx(slow.net_pull_n, rel=1e-3)
    assert fast.lateral_n == pytest.approx(slow.lateral_n, rel=1e-3)


def test_twice_the_same_test_gives_the_same_bits_and_neighbours_do_not_matter():
    alone = wheel(TYRE, Soil(), slip=0.2, load_n=LOAD_N)
    again = wheel(TYRE, Soil(), slip=[0.1, 0.2], load_n=LOAD_N)
    for name, values in alone.columns().items():
        assert values[0] == again.columns()[name][1]


def test_the_load_of_a_rigid_wheel_is_carried_at_its_radius():
    rigid = Tyre(rigid=True, diameter_m=0.9, width_m=0.3)
    seen = wheel(rigid, Soil(law="bekker", preset="lete-sand"), slip=[0.0, 0.3], load_n=[2e3, 1e4])
    assert seen.rolling_radius_m == pytest.approx(0.45, abs=1e-5)
    assert np.all(seen.sinkage_m > 0.005)
    assert np.all(seen.motion_resistance_n > 0.0)


def test_a_wheel_that_digs_in_has_no_self_propelled_point():
    """Its net traction is negative at every slip; under less load it is not."""
    rigid, clay = (
        Tyre(rigid=True, diameter_m=0.9, width_m=0.3),
        Soil(law="bekker", preset="clayey-38"),
    )
    loads = np.array([2e3, 1e4])
    most = [wheel(rigid, clay, slip=[0.1, 0.3, 0.5, 0.9], load_n=n).net_pull_n.max() for n in loads]
    driven = self_propelled(rigid, clay, load_n=loads)
    assert np.array_equal(np.isnan(driven.slip), np.array(most) < 0.0)
    assert np.isnan(driven.axle_torque_nm).tolist() == [False, True]


def test_tyres_by_axle_and_by_size():
    front = wheel(Tyre(axle="front"), Soil(), slip=0.1, load_n=1e4)
    free = Tyre(
        width_m=0.378, diameter_m=1.31, free_rolling_radius_m=0.6275, stiffness_npm=354e3,
        relaxation_long_m=0.2, relaxation_lat_m=0.6, lateral_ratio=0.65,
    )  # fmt: skip
    assert wheel(free, Soil(), slip=0.1, load_n=1e4).net_pull_n == pytest.approx(front.net_pull_n)


def test_a_law_is_told_where_it_does_not_hold():
    assert outside_range(TYRE, Soil(), load_n=LOAD_N) == ()
    (sentence,) = outside_range(TYRE, Soil(), load_n=5e3)
    assert "W/(b d) = 6.1 kPa" in sentence


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({"slip": 1.5}, OutOfRange, "slip = 1.5 is outside"),
        ({"slip": np.nan}, OutOfRange, "slip = nan"),
        ({"slip_angle_rad": 2.0}, OutOfRange, "slip_angle_deg"),
        ({"load_n": -5.0}, OutOfRange, "load_n = -5"),
        ({"load_n": 9e4}, BadInput, "onto its rim"),
        ({"speed_mps": 0.0}, OutOfRange, "speed_mps"),
        ({"slip": []}, BadInput, "no points"),
        ({"slip": [0.1, 0.2], "load_n": [1e3, 2e3, 3e3]}, BadInput, "shapes"),
    ],
)
def test_what_cannot_be_imposed_is_refused(arguments, error, words):
    with pytest.raises(error, match=words):
        wheel(TYRE, Soil(), **({"slip": 0.1, "load_n": 2e4} | arguments))


def test_tyres_that_cannot_be_are_refused():
    with pytest.raises(UnknownName, match="axle"):
        Tyre(axle="middle")
    with pytest.raises(OutOfRange, match=r"tyre.width_m = -1"):
        Tyre(width_m=-1.0)
    with pytest.raises(BadInput, match="contradict"):
        Tyre(rigid=True, stiffness_npm=1e5)


@pytest.mark.parametrize("preset", ["firm", "tilled", "soft"])
def test_a_field_gives_no_more_traction_under_bekkers_law_than_under_brixius(preset):
    """Gross traction near full slip: what the soil bears."""
    brixius, bekker = (
        wheel(TYRE, Soil(preset=preset, law=law), slip=0.95, load_n=[16e3, 21e3, 26e3])
        for law in ("brixius", "bekker")
    )
    most = brixius.gross_traction_ratio.max()
    assert bekker.gross_traction_ratio.max() <= most + 0.01


@pytest.mark.parametrize("preset", ["firm", "tilled", "soft", "lete-sand", "sandy-loam-15"])
def test_the_side_force_is_no_more_than_the_soil_bears(preset):
    """c A + W tan(phi) under the tyre, 6 % more for its leaning stress, and Rankine beside it."""
    soil, load_n = Soil(preset=preset, law="bekker"), np.array([8e3, 15e3, 22e3])
    seen = wheel(TYRE, soil, slip=0.0, load_n=load_n, slip_angle_rad=np.radians(30.0))
    numbers, z, f = soil.resolved.deformable, seen.sinkage_m, load_n / 383e3
    length = np.sqrt(DIAMETER_M * (z + f)) + np.sqrt(DIAMETER_M * f)
    phi, cohesion = np.radians(numbers.friction_angle_deg), 1e3 * numbers.cohesion_kpa
    q = np.tan(np.pi / 4.0 + 0.5 * phi)
    wedge = 4.0 / 3.0 * cohesion * z * q + 4.0 / 15.0 * 15e3 * z**2 * q**2
    under = cohesion * WIDTH_M * length + 1.06 * load_n * np.tan(phi)
    assert np.all(seen.lateral_n <= under + length * wedge)


@pytest.mark.parametrize("load_n", [5.0, 25.0])
def test_the_rig_takes_the_load_of_a_rovers_wheel(load_n):
    small = Tyre(rigid=True, diameter_m=0.116, width_m=0.05)
    seen = wheel(small, Soil(preset="dry-sand", law="bekker"), slip=[0.0, 0.5], load_n=load_n)
    assert 0.0 < seen.sinkage_m[0] < seen.sinkage_m[1] < 0.058
