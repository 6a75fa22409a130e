"""Two drives beside each other."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.synthetic_log import RUN, SCORES, job
from tests.synthetic_run import synthetic_run
from twin import cli
from twin.io import run_folder
from twin.io.run_folder import Record
from twin.pipeline.compared import compared
from twin.report.compare_page import LOOKS
from twin.scores import scores as scores_of


def a_log(folder: Path, **changes: Any) -> Path:
    return run_folder.write(replace(RUN, **changes), SCORES, folder)


def a_run(folder: Path, duration_s: float = 40.0, estimator: str = "ratio") -> Path:
    run = synthetic_run(duration_s=duration_s)
    run = replace(run, estimates={estimator: run.estimates["ekf4"]})
    found = scores_of.score(run.truth, run.estimates, scenario="stub", seed=1)
    return run_folder.write(run, found, folder)


def values(found: Any) -> dict[str, tuple[float | None, float | None]]:
    return {row.quantity: (row.a, row.b) for row in found.rows}


def test_a_log_and_a_run_of_the_job(tmp_path: Path) -> None:
    found = compared(a_log(tmp_path / "log"), a_run(tmp_path / "run"))
    assert (found.a.kind, found.b.kind) == ("recorded", "simulated")
    rows = values(found)
    assert rows["draft"][0] == pytest.approx(20.0, abs=0.2)
    assert rows["draft"][1] == pytest.approx(18.0, abs=0.5)  # the truth's: no sensor has it
    assert rows["ground speed"] == (pytest.approx(7.2, abs=0.1), pytest.approx(5.4, abs=0.1))
    assert rows["slip, ratio, median"][0] == pytest.approx(10.0, abs=0.2)
    assert rows["slip, truth, mean"][0] is None
    assert found.where == "at work"
    assert found.slip_of == ("ratio", "ratio")
    assert any("B: draft_pin_n" in note for note in found.notes)
    assert any("machines differ" in note for note in found.notes)


def test_without_an_estimator_in_common_the_truth_stands_in(tmp_path: Path) -> None:
    found = compared(a_log(tmp_path / "log"), a_run(tmp_path / "run", estimator="own"))
    assert found.slip_of == ("ratio", "truth")
    assert any("no estimator gives slip in both" in note for note in found.notes)


def test_equal_drives_differ_in_nothing(tmp_path: Path) -> None:
    found = compared(a_log(tmp_path / "a"), a_log(tmp_path / "b"))
    assert all(row.difference in (None, 0.0) for row in found.rows)


def test_a_drive_without_work_is_compared_while_driving(tmp_path: Path) -> None:
    streams, estimate, _ = job(passes=0)
    road = a_log(tmp_path / "road", streams=streams, estimates={"ratio": estimate})
    found = compared(a_log(tmp_path / "log"), road)
    assert found.where.startswith("while driving")
    assert values(found)["ground speed"][1] == pytest.approx(28.8, abs=0.1)


def test_the_command_prints_a_table_within_80_columns_and_writes_a_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    a_log(Path("log")), a_run(Path("run"))
    assert cli.main(["compare", "log", "run"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 80
    assert any(line.startswith("ground speed [km/h]") for line in lines)
    text = Path("runs/log-and-run.html").read_text()
    assert text.count("<svg") >= 4
    assert "twin compare log run" in text
    assert all(f">{name}<" in text for name, *_ in LOOKS)


def test_json_is_the_comparison(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    a_log(Path("log")), a_run(Path("run"))
    assert cli.main(["compare", "log", "run", "--json", "--out", "page.html"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["schema"] == 1
    assert {"quantity", "unit", "a", "b", "difference"} == set(found["rows"][0])
    assert found["a"]["kind"] == "recorded"
    assert Path("page.html").is_file()


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["log", "log"], "log and log are the same folder"),
        (["log", "./log"], "are the same folder"),
        (["log", "nowhere"], "nowhere does not exist"),
        (["log", "log/streams"], "log/streams is not the folder of a run or of a log"),
        (["log", "file.csv"], "file.csv is not the folder of a run or of a log"),
        (["log", "blind"], "have nothing in common"),
        (["log", "hollow"], "hollow holds no measurements"),
        (["log", "run", "--out", "no/where/page.html"], "there is no directory no/where"),
    ],
)
def test_nonsense_is_refused_by_name_and_leaves_nothing(
    args: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    a_log(Path("log")), a_run(Path("run"))
    Path("file.csv").write_text("a,b\n")
    epoch_ns = np.arange(20) * 10**9
    depth = {"epoch_ns": epoch_ns, "arrival_ns": epoch_ns, "laser_m": np.ones(20)}
    blind = type(RUN.streams)({"depth": depth})
    run_folder.write(Record(setup=RUN.setup, streams=blind, estimates={}), {}, Path("blind"))
    hollow = Record(setup=RUN.setup, streams=type(RUN.streams)({}), estimates={})
    run_folder.write(hollow, {}, Path("hollow"))
    assert cli.main(["compare", *args]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert len(error.splitlines()) == 1
    assert not Path("runs").exists()
