"""Machines drawn from the posterior beside a calibrated machine's file."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import twin
from twin import cli
from twin.calibration.drawn import bands, drawn
from twin.calibration.files import soil_toml
from twin.calibration.posterior import beside
from twin.vehicle.files import models_folder

RADIUS_M, SD = 0.66, 0.01


@pytest.fixture
def machine(tmp_path: Path) -> Path:
    text = (models_folder() / "catalogue" / "tym_tx58.toml").read_text()
    (path := tmp_path / "my.calibrated.toml").write_text(text)
    known = {
        "names": ["rear.free_rolling_radius_m", "soil.draft_scale", "log.set_rpm"],
        "mean": np.log([RADIUS_M, 0.8, 1700.0]).tolist(),
        "cov": np.diag([SD**2, 0.02**2, 0.01**2]).tolist(),
        "transform": ["log"] * 3,
    }
    beside(path).write_text(json.dumps(known))
    return path


@pytest.mark.parametrize("varies", [True, False])
def test_machines_are_drawn_and_the_soil_where_it_is_the_calibrated_one(
    machine: Path, varies: bool
) -> None:
    own = machine.with_suffix(".soil.toml")
    own.write_text(soil_toml(twin.Soil(preset="tilled"), "log"))
    preset = str(own) if varies else "tilled"
    scenario = twin.load("plough-20cm", {"machine": str(machine), "soil.preset": preset})
    assert isinstance(scenario, twin.Scenario)
    found = list(drawn(scenario, 12, seed=1))
    radii = [s.facts.numbers["tyre_rear.free_rolling_radius_m"] for s in found]
    assert np.log(radii).std() == pytest.approx(SD, rel=0.6)
    assert np.mean(radii) == pytest.approx(RADIUS_M, rel=4 * SD / 12**0.5)
    assert (len({s.soil.resolved.draft_scale for s in found}) > 1) is varies
    again = [s.facts.numbers["tyre_rear.free_rolling_radius_m"] for s in drawn(scenario, 12, 1)]
    assert again == radii
    assert {replace(s, machine_numbers=None, soil=scenario.soil).seed for s in found} == {0}


def test_a_band_holds_the_middle_of_the_figures_that_all_runs_have() -> None:
    found = bands([{"slip": float(i), "none": None, "word": "a"} for i in range(101)])
    assert found == {"slip": (50.0, 2.5, 97.5)}


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--posterior", "5"], "has no posterior"),
        (["--posterior", "1"], "2 or more"),
        (["--posterior", "5", "--machine", "FILE"], "is missing"),
    ],
)
def test_what_has_no_posterior_is_refused(
    words: list[str], said: str, machine: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    beside(machine).unlink()
    given = [str(machine) if w == "FILE" else w for w in words]
    assert cli.main(["run", "plough-20cm", *given]) == 2
    err = capsys.readouterr().err
    assert said in err
    assert err.count("\n") == 1


def test_a_draw_that_no_machine_can_be_is_left_out(machine: Path) -> None:
    known = json.loads(beside(machine).read_text())
    known["names"][0] = "transmission.efficiency"  # at most 1
    known["mean"][0], known["cov"][0][0] = 0.0, 0.01
    beside(machine).write_text(json.dumps(known))
    scenario = twin.load("plough-20cm", {"machine": str(machine)})
    assert isinstance(scenario, twin.Scenario)
    assert 0 < len(list(drawn(scenario, 20, seed=1))) < 20
