"""Points of a dynamometer at the PTO, as published tests give them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from twin import cli
from twin.calibration.by_points import by_points, foretold_drawbar, read_points
from twin.vehicle import Machine, files

TESTS = {1458: "jd_4250", 1475: "jd_4250", 1459: "jd_4450", 1476: "jd_4450"}


def sheet(number: int) -> Path:
    return Path(__file__).parent / "nebraska" / f"{number}.toml"


def before(name: str) -> Machine:
    """The catalogue's machine, but for the PTO's efficiency, which is from these tests."""
    machine = files.machine(name)
    return replace(machine, engine=replace(machine.engine, pto_efficiency=None))


def test_points_tell_the_engine_and_nothing_behind_the_gearbox() -> None:
    points = replace(read_points(sheet(1458)), drawbar=None)
    found = by_points(points, before("jd_4250"), "1458")
    told = {p.name: p for p in found.parameters}
    power = told["engine.rated_power_kw"].value * told["engine.pto_efficiency"].value
    assert power == pytest.approx(90.1, rel=0.01)
    assert told["engine.fuel_l_per_kwh"].value == pytest.approx(28.4 / 90.1, rel=0.01)
    for name in ("transmission.efficiency", "mass_kg"):
        assert told[name].verdict == "not identified"
        assert told[name].value == pytest.approx(told[name].prior)
    assert any("PTO's efficiency only together" in line for line in found.together)


@pytest.mark.slow
@pytest.mark.parametrize("number", TESTS)
def test_drawbar_power_of_a_published_test_is_foretold(number: int) -> None:
    points, machine = read_points(sheet(number)), before(TESTS[number])
    found = by_points(replace(points, drawbar=None), machine, str(number))
    pulled = foretold_drawbar(machine, found.fit)
    assert points.drawbar is not None
    assert pulled.power_kw == pytest.approx(points.drawbar.power_kw, rel=0.06)
    assert pulled.low_kw < points.drawbar.power_kw < pulled.high_kw


def test_the_command_writes_a_machine_and_no_soil(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "sheet.toml"
    path.write_text(sheet(1459).read_text().partition("[drawbar]")[0])
    words = ["calibrate", str(path), "--machine", "jd_4450", "--out", str(tmp_path), "--json"]
    assert cli.main(words) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["holdout"]["slip_rms"] is None
    names = sorted(p.name.partition(".")[2] for p in tmp_path.glob("jd_4450*"))
    assert names == ["calibrated.html", "calibrated.posterior.json", "calibrated.toml"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[pto]\nengine_rpm = [2200]\npower_kw = []\nfuel_lph = [28]\n", "need a value for"),
        ("[pto]\nengine_rpm = [2200]\npower_kw = [-1]\nfuel_lph = [28]\n", "above 0 would do"),
        ("[drawbar]\npower_kw = 75\n", "pto"),
        ("[pto", "is no TOML file"),
    ],
)
def test_a_sheet_that_says_too_little_is_refused(
    text: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "sheet.toml"
    path.write_text(text)
    assert cli.main(["calibrate", str(path), "--machine", "jd_4450"]) == 2
    err = capsys.readouterr().err
    assert said in err
    assert err.count("\n") == 1


def test_a_hand_made_machine_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["calibrate", str(sheet(1458)), "--machine", "taishan_1404a"]) == 2
    assert "cannot be fitted to taishan_1404a" in capsys.readouterr().err
