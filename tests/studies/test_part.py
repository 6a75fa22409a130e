"""One run's rows: its scores, and its errors where it fails."""

import json

import numpy as np
import pyarrow.parquet as pq
import pytest

from twin import cli
from twin.errors import BadInput, NoSpace
from twin.pipeline import named as registry
from twin.pipeline import run
from twin.scores import scores
from twin.studies import failed, missing, part, plan, read, table, work


def test_rows_are_the_scores_of_the_run():
    case, *_ = plan(["ima-pkf-disturbed"], [3], ["ratio", "pkf"], {"track": ("rough",)})
    ratio, pkf = part.rows(case)
    done = run.run(case.run, estimators={"pkf": registry.load("estimator", "pkf")})
    scored = scores.score(done.truth, done.estimates, scenario="", seed=3, window=(0.0, 30.0))
    assert {pkf["scenario"], pkf["track"], pkf["seed"], pkf["estimator"]} == {
        "ima-pkf-disturbed", "rough", 3, "pkf",
    }  # fmt: skip
    for name in ("rmse", "mae", "max", "bias", "nees_mean"):
        assert pkf[f"slip.{name}"] == scored["estimators"]["pkf"]["slip"][name]
    assert pkf["truth.slip_mean"] == ratio["truth.slip_mean"] == scored["truth"]["slip_mean"]
    assert pkf["slip.rmse"] < ratio["slip.rmse"]
    assert pkf["error"] is None


def test_an_estimator_that_has_chance_of_its_own_takes_the_runs_seed():
    for seed in (2, 5):
        case, *_ = plan(["ima-pkf"], [seed], ["tests.studies.brought:SEEDED"], {})
        row, *_ = part.rows(case)
        assert row["slip.bias"] == pytest.approx(seed - row["truth.slip_mean"])


def test_what_fails_is_a_row_with_its_error(tmp_path):
    cases = plan(
        ["tests.studies.brought:ODD"], range(3), ["ratio", "tests.studies.brought:Failing"], {}
    )
    work(cases, tmp_path, jobs=1)
    rows = read(cases, tmp_path).to_pylist()
    failing = "estimator 'tests.studies.brought:Failing' fails"
    said = f"{failing}: RuntimeError: no idea (brought.py, line 48)"
    odd = "scenario 'odd': measure fails: ArithmeticError: odd (brought.py, line 15)"
    assert [r["error"] for r in rows] == [None, said, odd, odd, None, said]
    assert [r["slip.rmse"] is None for r in rows] == [False, True, True, True, False, True]
    assert [r["seed"] for r in rows] == [0, 0, 1, 1, 2, 2]
    assert len(failed(cases, tmp_path)) == 3
    assert missing(cases, tmp_path) == [], "an error is a result: it is not tried again unasked"


def test_a_part_appears_whole_or_not_at_all(tmp_path, monkeypatch):
    case, *_ = plan(["ima-pkf"], [0], ["ratio"], {})

    def torn(table, file, **_):
        file.write_bytes(b"PAR1 half")
        raise OSError(28, "disk full")

    with monkeypatch.context() as patched:
        patched.setattr(pq, "write_table", torn)
        with pytest.raises(NoSpace, match="No space left on device"):
            part.write(case, tmp_path)
    assert list(tmp_path.iterdir()) == []
    part.write(case, tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == [case.part]


def test_work_does_what_is_missing_and_nothing_else(tmp_path):
    cases = plan(["ima-pkf"], range(4), ["ratio"], {})
    told = []
    work(cases[1:3], tmp_path, jobs=1)
    before = {p.name: p.stat().st_mtime_ns for p in tmp_path.iterdir()}
    work(cases, tmp_path, jobs=1, progress=told.append)
    after = {p.name: p.stat().st_mtime_ns for p in tmp_path.iterdir()}
    assert len(after) == 4
    assert {name: after[name] for name in before} == before
    assert (told[0], told[-1]) == (0.5, 1.0)
    assert np.all(np.diff(told) >= 0)


def test_a_full_disk_is_one_line_and_what_is_done_stays(tmp_path, monkeypatch):
    cases = plan(["ima-pkf"], range(3), ["ratio"], {})
    work(cases[:1], tmp_path, jobs=1)

    def full(case, folder):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(part, "write", full)
    with pytest.raises(BadInput, match=r"the study stopped: OSError.*No space left.*continues"):
        work(cases, tmp_path, jobs=1)
    assert len(missing(cases, tmp_path)) == 2


def test_signals_without_a_machine_are_a_run_like_any_other(tmp_path, monkeypatch, capsys):
    out = tmp_path / "run"
    assert (
        cli.main(["run", "ima-pkf", "--seed", "3", "--estimators", "ratio", "--out", str(out)]) == 0
    )
    case, *_ = plan(["ima-pkf"], [3], ["ratio"], {})
    row, *_ = part.rows(case)
    scored = json.loads((out / "scores.json").read_text())["estimators"]["ratio"]["slip"]
    assert scored["rmse"] == row["slip.rmse"]
    assert {"report.html", "run.rrd", "truth.parquet"} <= {p.name for p in out.iterdir()}
    monkeypatch.chdir(tmp_path)
    capsys.readouterr()
    assert cli.main(["run", "ima-pkf", "--mask", "3", "4"]) == 2
    assert "has no GNSS receiver to mask" in capsys.readouterr().err


def test_a_missing_or_torn_part_is_named_with_what_would_do(tmp_path):
    cases = plan(["ima-pkf"], range(2), ["ratio"], {})
    work(cases[:1], tmp_path, jobs=1)
    with pytest.raises(BadInput, match=rf"{cases[1].part} is missing"):
        read(cases, tmp_path)
    (tmp_path / cases[1].part).write_bytes(b"PAR1")
    with pytest.raises(BadInput, match=rf"{cases[1].part} is not a whole Parquet.*delete it"):
        read(cases, tmp_path)


def test_the_table_does_not_depend_on_how_many_parts_are_joined_at_once(tmp_path, monkeypatch):
    cases = plan(["tests.studies.brought:ODD"], range(7), ["ratio"], {})
    work(cases, tmp_path, jobs=1)
    whole = read(cases, tmp_path)
    monkeypatch.setattr(table, "AT_ONCE", 2)
    assert read(cases, tmp_path).to_pylist() == whole.to_pylist()
    assert whole.num_rows == 7


def test_what_a_killed_run_left_half_written_goes(tmp_path):
    cases = plan(["tests.studies.brought:ODD"], range(1), ["ratio"], {})
    left = tmp_path / f".1234.{cases[0].part}"  # as `twin.io.atomic` names what is not whole yet
    left.write_bytes(b"half")
    work(cases, tmp_path, jobs=1)
    assert [path.name for path in tmp_path.iterdir()] == [cases[0].part]
