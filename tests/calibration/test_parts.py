"""Gears, files, posteriors, and parameters put into machines."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from twin.calibration import posterior
from twin.calibration.applied import believed, can_fit, machine_with, soil_with
from twin.calibration.files import machine_toml, soil_toml
from twin.calibration.gears import found, gear_of
from twin.calibration.posterior import Posterior
from twin.calibration.verdicts import Told
from twin.errors import BadInput, UnknownName
from twin.scenario import Soil
from twin.vehicle import files
from twin.vehicle.machine import Numeric
from twin.vehicle.numerics import machine_facts

RADIUS = "rear.free_rolling_radius_m"


def test_gears_are_found_among_ratios_that_slip() -> None:
    random = np.random.default_rng(0)
    ratio = np.concatenate([r * (1 + 0.004 * random.standard_normal(200)) for r in (40.0, 66.0)])
    ratio = np.append(ratio, random.uniform(20, 100, 30))
    gears = found(ratio, (80.0, 66.0, 41.0))
    assert [g.name for g in gears] == ["gear 2", "gear 3"]
    assert [g.ratio for g in gears] == pytest.approx([66.0, 40.0], rel=0.005)
    assert gear_of(65.0, gears) is gears[0]
    assert gear_of(52.0, gears) is None


def test_no_gear_is_found_where_engine_and_wheels_keep_no_ratio() -> None:
    assert found(np.exp(np.linspace(0.0, 5.0, 400))) == []
    assert found(np.array([np.nan, -1.0])) == []


@pytest.mark.parametrize("name", ["tym_tx58", "taishan_1404a"])
def test_a_radius_reaches_the_numerics_of_any_machine(name: str) -> None:
    machine = files.machine(name)
    before, _, _ = believed(machine, Soil(), RADIUS)
    changed = machine_facts(machine_with(machine, {RADIUS: 1.02 * before})).numbers
    assert changed["tyre_rear.free_rolling_radius_m"] == pytest.approx(1.02 * before)


def test_a_hand_made_machine_has_no_mass_to_fit() -> None:
    machine = files.machine("taishan_1404a")
    assert not can_fit(machine, "mass_kg")
    with pytest.raises(BadInput, match="mass_kg cannot be fitted"):
        machine_with(machine, {"mass_kg": 5000.0})


def test_numerics_are_refused_where_there_is_no_mjcf_or_no_such_name() -> None:
    with pytest.raises(BadInput, match="numerics need a hand-made MJCF"):
        replace(files.machine("tym_tx58"), numerics=(Numeric(name="a", value=1.0),))
    odd = replace(files.machine("taishan_1404a"), numerics=(Numeric(name="a", value=1.0),))
    with pytest.raises(UnknownName, match="numeric"):
        machine_facts(odd)


def test_a_measured_number_is_believed_more_than_an_assumed_one() -> None:
    machine = files.machine("tym_tx58")
    _, published, grade = believed(machine, Soil(), "mass_kg")
    _, assumed, _ = believed(machine, Soil(), "transmission.efficiency")
    assert grade == "published"
    assert published == pytest.approx(0.04)
    assert assumed == pytest.approx(0.05)


def test_the_soil_takes_fields_and_numbers_of_its_preset() -> None:
    soil = soil_with(Soil(), {"soil.friction": 0.7, "soil.mobility_resistance": 1.4, "mass_kg": 1})
    assert (soil.resolved.friction, soil.resolved.mobility_resistance) == (0.7, 1.4)


@pytest.mark.parametrize("name", ["tym_tx58", "taishan_1404a", "nh_t7165s"])
def test_the_machine_file_reads_as_what_was_found(name: str, tmp_path: Path) -> None:
    radius_m = 1.01 * believed(files.machine(name), Soil(), RADIUS)[0]
    machine = machine_with(files.machine(name), {RADIUS: radius_m})
    row = Told(RADIUS, "m", radius_m, 0.79, 0.81, 0.7, 0.6, 0.9, "identified", "", False)
    path = tmp_path / "my.calibrated.toml"
    path.write_text(machine_toml(machine, [row], "twin calibrate field.csv"), encoding="utf-8")
    again = files.machine(str(path))
    assert machine_facts(again).numbers == machine_facts(machine).numbers
    assert again.name == f"{name}_calibrated"


def test_the_soil_file_is_a_preset(tmp_path: Path) -> None:
    soil = soil_with(Soil(), {"soil.cone_index_kpa": 777.0, "soil.mobility_resistance": 1.4})
    path = tmp_path / "my.soil.toml"
    path.write_text(soil_toml(soil, "field.csv"), encoding="utf-8")
    again = Soil(preset=str(path)).resolved
    assert replace(again, about="", name="") == replace(soil.resolved, about="", name="")


def test_a_soil_file_that_is_none_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"absent.toml is missing"):
        Soil(preset=str(tmp_path / "absent.toml"))
    (path := tmp_path / "odd.toml").write_text("about = 'x'\ncolour = 3\n")
    with pytest.raises(BadInput, match=r"odd.toml: Preset has no field 'colour'"):
        Soil(preset=str(path))


def test_a_posterior_comes_back_and_draws_about_its_mean(tmp_path: Path) -> None:
    known = Posterior(("a", "b"), np.log([2.0, 3.0]), np.array([[0.01, 0.005], [0.005, 0.01]]))
    path = posterior.beside(tmp_path / "my.calibrated.toml")
    assert path.name == "my.calibrated.posterior.json"
    known.write(path)
    again = posterior.read(path)
    draws = np.log([list(d.values()) for d in again.draw(4000, seed=1)])
    assert draws.mean(axis=0) == pytest.approx(known.mean, abs=0.01)
    assert np.cov(draws.T) == pytest.approx(known.cov, abs=0.001)
    assert again.draw(3, seed=2) == again.draw(3, seed=2)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{", "is no posterior"),
        ('{"names": ["a"], "mean": [0, 1], "cov": [[1]], "transform": ["log"]}', "do not fit"),
        ('{"names": ["a"], "mean": [0], "cov": [[1]], "transform": ["cube"]}', "'log' would do"),
        ('{"names": ["a"], "mean": [0], "cov": [[-1]], "transform": ["log"]}', "no covariance"),
    ],
)
def test_a_posterior_that_is_none_is_refused(text: str, said: str, tmp_path: Path) -> None:
    (path := tmp_path / "p.json").write_text(text)
    with pytest.raises(BadInput, match=said):
        posterior.read(path)
    with pytest.raises(BadInput, match="twin calibrate writes it"):
        posterior.read(tmp_path / "absent.json")
