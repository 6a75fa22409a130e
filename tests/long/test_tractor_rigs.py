"""The whole tractor on the rigs, on more soils and slopes than tests/rig has."""

import pytest

from tests.rig.test_tractor_rigs import crabs_as_the_equilibrium_does, pulls_what_its_wheels_pull
from twin.rig.slope import expected, slope
from twin.scenario import Soil


@pytest.mark.parametrize(
    ("soil", "hitch_m"),
    [
        (Soil(), 0.45),
        (Soil(preset="soft"), 0.45),
        (Soil(), 0.80),
        (Soil(law="bekker"), 0.45),
    ],
    ids=["firm", "soft", "high hitch", "bekker"],
)
def test_the_tractor_pulls_what_its_wheels_pull_after_weight_transfer(soil, hitch_m):
    pulls_what_its_wheels_pull(soil, hitch_m)


@pytest.mark.parametrize("preset", ["firm", "soft"])
def test_the_crab_angle_is_that_of_the_equilibrium(preset):
    crabs_as_the_equilibrium_does(preset, [5.0, 12.0, 18.0])


def test_bekkers_crab_angle_is_that_of_the_equilibrium():
    soil = Soil(law="bekker")
    assert slope(soil, [10.0]).crab_angle_rad == pytest.approx(
        expected(soil, [10.0]).crab_angle_rad, rel=0.01
    )
