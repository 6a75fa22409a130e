"""A run that ends early says so wherever it is looked at, and is no failure."""

import json
from dataclasses import replace

import pyarrow.parquet as pq
import pytest

from scenarios.plough import CM_25
from scenarios.slope import DRY_9
from tests.simulation.rigs import BARE
from twin import cli
from twin.commands.run import Options, execute
from twin.pipeline.run import run
from twin.scenario import Course, Field, Patch

BOG = Patch(start_m=45.0, length_m=100.0, friction_factor=0.1)


def test_a_run_stuck_from_the_start_is_named_and_not_scored(tmp_path, capsys):
    out = tmp_path / "run"
    words = ("--soil.cone-index-kpa", "50", "--estimators", "ratio", "--out", str(out))
    assert cli.main(["run", "plough-25cm", *words]) == 0
    said = capsys.readouterr().out
    table = json.loads((out / "scores.json").read_text())
    assert said.startswith(f"STUCK at {table['end']['time_s']:.1f} s")
    assert "not scored: it ended before the plough was at its full depth" in said
    assert table["ended"].startswith("stuck at ")
    assert table["end"]["measured"] > 0.6
    assert table["end"]["as_planned"] is False
    assert table["window_s"] is table["bound"] is None
    assert table["unscored"] in said
    page = (out / "report.html").read_text()
    assert f'<p class="ended">STUCK{table["ended"].removeprefix("stuck")}' in page
    assert "not scored" in page


def test_a_run_stuck_late_is_named_and_what_it_drove_is_scored(tmp_path, capsys):
    scenario = replace(CM_25, course=Course(length_m=100.0), field=Field(patches=(BOG,)))
    execute(scenario, Options(out=tmp_path / "run", estimators="ratio"))
    table = json.loads((tmp_path / "run" / "scores.json").read_text())
    assert table["end"]["outcome"] == "stuck"
    assert 45.0 < table["end"]["along_m"] < 60.0
    assert table["unscored"] is None
    assert table["estimators"]["ratio"]["slip"]["n"] > 100
    assert table["window_s"][1] == pytest.approx(table["end"]["time_s"], abs=0.1)
    said = capsys.readouterr().out
    assert said.startswith("STUCK at ")
    assert "slip RMSE" in said


def test_a_study_counts_and_names_the_runs_that_did_not_drive_their_course(tmp_path, capsys):
    asked = ["slope-5-plough", "--seeds", "2", "--estimators", "ratio,ratio-front", "--jobs", "1"]
    asked += ["--sweep", "soil.cone_index_kpa=50,1200", "--out", str(tmp_path / "s")]
    assert cli.main(["study", *asked]) == 0
    said = capsys.readouterr().out
    rows = {
        (r["case"], r["quantity"]): r["ours"]
        for r in json.loads((tmp_path / "s" / "summary.json").read_text())["rows"]
    }
    for estimator in ("ratio", "ratio-front"):
        for value, count in ((50.0, 2), (1200.0, 0)):
            case = f"slope-5-plough, soil.cone_index_kpa = {value}, {estimator}"
            assert rows[case, "not driven as planned"] == count
            assert rows[case, "failed"] == 0
    heading = said.splitlines()[:3]
    assert all(any(word in line for line in heading) for word in ("ended", "early"))
    for seed in (0, 1):
        named = f"slope-5-plough, soil.cone_index_kpa = 50.0, seed {seed}: stuck at "
        assert said.count(f"ended early: {named}") == 1
        assert named in (tmp_path / "s" / "report.html").read_text()
    table = pq.read_table(tmp_path / "s" / "table.parquet").to_pylist()
    assert [r["as_planned"] for r in table] == [False] * 4 + [True] * 4


def test_a_calibration_that_ended_early_is_noted():
    slippery = replace(DRY_9, soil=replace(DRY_9.soil, friction=0.05))
    notes = run(slippery, estimators={}).notes
    assert sum(note.startswith("calibration: stuck at ") for note in notes) == 2
    level = replace(BARE, course=replace(BARE.course, calibration_m=5.0))
    assert not any("calibration" in note for note in run(level, estimators={}).notes)
