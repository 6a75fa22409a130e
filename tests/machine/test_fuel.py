"""The diesel's fuel: the standard's constants, its limits, and what a whole machine burns."""

import numpy as np
import pytest

from twin.machine.fuel import fuel_lph
from twin.scenario import Course, Drive, Scenario, Soil
from twin.simulation.build import build
from twin.simulation.simulate import simulate

RATED_RADPS = 2200.0 * np.pi / 30.0
NUMBERS = {
    "engine.kind": 0.0, "engine.rated_rpm": 2200.0, "engine.rated_torque_nm": 1e5 / RATED_RADPS,
    "engine.pto_efficiency": 0.9,
}  # fmt: skip
"""100 kW at the crank, 90 kW of PTO power."""
LOADS_W = np.linspace(1e3, 1e5, 40)


def test_full_speed_follows_the_standard():
    """By hand: (0.22 + 0.096) 90 kW at full load, (0.11 + 0.096) 90 kW at half load."""
    full, half = fuel_lph(NUMBERS, [100e3, 50e3], RATED_RADPS)
    assert full == pytest.approx(28.44)
    assert half == pytest.approx(18.54)


def test_a_reduced_speed_follows_the_standard_s_other_form():
    """PTM = 1 - (n - 1) (0.45 X - 0.877) with n from 0.5 to 1."""
    n, x = np.meshgrid(np.linspace(0.5, 1.0, 6), np.linspace(0.1, 1.0, 10))
    wanted = (0.22 * x + 0.096) * (1.0 - (n - 1.0) * (0.45 * x - 0.877)) * 90.0
    np.testing.assert_allclose(fuel_lph(NUMBERS, 1e5 * x, n * RATED_RADPS), wanted, rtol=1e-12)


def test_slower_takes_less_for_the_same_power_down_to_half_speed_and_no_less_below():
    speeds = np.array([1.09, 1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.36]) * RATED_RADPS
    rate = fuel_lph(NUMBERS, LOADS_W[:, None], speeds)
    assert np.array_equal(rate[:, 0], rate[:, 1])
    assert np.all(np.diff(rate[:, 1:-1], axis=1) < 0.0)
    assert np.array_equal(rate[:, -1], rate[:, -2])


def test_more_power_takes_more_and_less_each():
    for speed in (1.0, 0.75, 0.5):
        rate = fuel_lph(NUMBERS, LOADS_W, speed * RATED_RADPS)
        assert np.all(np.diff(rate) > 0.0)
        assert np.all(np.diff(rate / LOADS_W) < 0.0)


def test_no_diesel_is_better_than_diesels_are():
    """835 g/L and 42.7 MJ/kg; at most 46 % of that at the crank, wherever the engine may work."""
    power_w, radps = np.meshgrid(LOADS_W, np.linspace(0.3, 1.1, 30) * RATED_RADPS)
    possible = power_w / radps <= 1.4 * NUMBERS["engine.rated_torque_nm"]
    heat_w = fuel_lph(NUMBERS, power_w, radps) * 0.835 * 42.7e6 / 3600.0
    assert np.all((power_w < 0.46 * heat_w)[possible])


def test_an_engine_that_gives_no_power_burns_nothing():
    rate = fuel_lph(NUMBERS, [-10e3, -1.0, 0.0, 0.0], [230.0, 100.0, 0.0, 230.0])
    assert np.array_equal(rate, np.zeros(4))
    assert fuel_lph({"engine.kind": 1.0}, [500.0, -500.0], 100.0) == pytest.approx([0.0, 0.0])


def driven(machine, soil, gear, rpm):
    chunks = list(
        simulate(
            build(
                Scenario(
                    name="fuel", machine=machine, soil=Soil(preset=soil),
                    drive=Drive(gear_ratio=gear, engine_set_rpm=rpm),
                    course=Course(approach_m=1.0, length_m=6.0),
                )
            )
        )
    )  # fmt: skip
    return {name: np.concatenate([c[name] for c in chunks]) for name in chunks[0].columns}


def test_a_run_burns_by_its_own_power_and_speed():
    seen = driven("taishan_1404a", "firm", 66.0, 1665.0)
    numbers = build(Scenario(name="fuel"), settle=False).numbers
    power_w = seen["engine_torque_nm"] * seen["engine_radps"]
    assert np.array_equal(seen["fuel_lph"], fuel_lph(numbers, power_w, seen["engine_radps"]))
    assert 6.0 < np.median(seen["fuel_lph"]) < 15.0


def test_an_electric_tractor_burns_nothing():
    assert not np.any(driven("electric_tractor", "dry", 50.0, 3000.0)["fuel_lph"])
