"""`twin study`: what it takes, what it writes, and that a killed one goes on."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pyarrow.parquet as pq
import pytest

from scenarios.plough import CM_25
from twin import cli
from twin.commands.study import read_sweeps


def study(*args):
    return cli.main(["study", *map(str, args)])


def test_sweeps_are_read_as_the_fields_are():
    found = read_sweeps(
        ["soil.friction=0.6,0.8", "--course.length-m=50", "plough.hitch=draft"], CM_25
    )
    assert found == {
        "soil.friction": (0.6, 0.8), "course.length_m": (50.0,), "plough.hitch": ("draft",),
    }  # fmt: skip
    assert read_sweeps(["drive.differential_lock=True,False"], CM_25) == {
        "drive.differential_lock": (True, False)
    }
    assert read_sweeps(["course.edge_m=None,2"], CM_25) == {"course.edge_m": (None, 2.0)}


@pytest.mark.parametrize(
    ("args", "says"),
    [
        ([], "needs scenarios first"),
        (["plough"], "did you mean 'plough-"),
        (["ima-pkf", "--seeds", "0"], "seeds = 0 is outside"),
        (["ima-pkf", "--jobs", "0"], "jobs = 0"),
        (["ima-pkf", "--estimators", "ratoi"], "did you mean 'ratio'"),
        (["ima-pkf", "--against", "pkf"], "--against pkf is not among"),
        (["ima-pkf", "--sweep", "track"], "is not FIELD=V1,V2"),
        (["ima-pkf", "--sweep", "trak=rough"], "did you mean 'track'"),
        (["ima-pkf", "--sweep", "track=odd"], "odd"),
        (["ima-pkf", "--sweep", "seed=3"], "seed cannot be swept: `--seeds` takes the seeds"),
        (["plough-25cm", "--sweep", "soil.friction=high"], "is not None or a number"),
        (["plough-25cm", "--sweep", "soil.friction=0.6,9"], "soil.friction = 9 is outside"),
        (["road-grass-5kmh", "--sweep", "plough.depth_m=0.2"], "cannot be set"),
        (["ima-pkf", "--backend", "abacus"], "--backend abacus cannot be used"),
        (["ima-pkf", "--backend-option", "x"], "--backend-option x is not NAME=VALUE"),
    ],
)
def test_bad_input_is_one_line(args, says, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert study(*args) == 2
    said = capsys.readouterr().err
    assert says in said
    assert said.count("\n") == 1
    assert not list(tmp_path.rglob("*.parquet"))


def test_a_folder_that_is_no_study_is_left_alone(tmp_path, capsys):
    (tmp_path / "thesis.tex").write_text("years of work")
    assert study("ima-pkf", "--seeds", 1, "--out", tmp_path) == 2
    assert "is not a study's folder" in capsys.readouterr().err
    assert [p.name for p in tmp_path.iterdir()] == ["thesis.tex"]


def test_what_a_study_leaves(tmp_path, capsys):
    out, copy = tmp_path / "study", tmp_path / "rows.json"
    asked = [
        "ima-pkf",
        "--seeds",
        3,
        "--first-seed",
        7,
        "--sweep",
        "track=medium,rough",
        "--jobs",
        1,
    ]
    asked += ["--estimators", "ratio,pkf", "--against", "ratio", "--out", out, "--json", copy]
    assert study(*asked) == 0
    assert "12" not in capsys.readouterr().err
    table = pq.read_table(out / "table.parquet").to_pylist()
    assert [(r["track"], r["seed"], r["estimator"]) for r in table] == [
        (track, seed, name)
        for track in ("medium", "rough") for seed in (7, 8, 9) for name in ("ratio", "pkf")
    ]  # fmt: skip
    rows = {(r["case"], r["quantity"]): r for r in json.loads(copy.read_text())["rows"]}
    assert json.loads((out / "summary.json").read_text())["rows"] == list(rows.values())
    rmse = [r["slip.rmse"] for r in table if (r["track"], r["estimator"]) == ("rough", "pkf")]
    assert rows["ima-pkf, track = rough, pkf", "slip.rmse"]["ours"] == pytest.approx(np.mean(rmse))
    assert rows["ima-pkf, track = rough, pkf", "slip.rmse less that of ratio"]["high"] < 0.0
    assert (out / "slip_rmse.png").exists()
    assert len(list((out / "parts").iterdir())) == 6


def test_failed_runs_are_told_kept_and_tried_again_only_when_asked(tmp_path, capsys):
    asked = [
        "tests.studies.brought:ODD",
        "--seeds",
        2,
        "--estimators",
        "ratio",
        "--jobs",
        1,
        "--out",
        tmp_path / "s",
    ]
    assert study(*asked) == 0
    said = (
        "failed: tests.studies.brought:ODD, ratio: "
        "scenario 'odd': measure fails: ArithmeticError: odd"
    )
    assert said in capsys.readouterr().out
    parts = {p: p.stat().st_mtime_ns for p in (tmp_path / "s" / "parts").iterdir()}
    assert study(*asked, "--retry-failed") == 0
    changed = [p.name for p, before in parts.items() if p.stat().st_mtime_ns != before]
    assert len(changed) == 1
    assert "seed1" in changed[0]


@pytest.mark.slow
def test_interrupted_it_says_how_far_it_came(tmp_path):
    asked = [sys.executable, "-m", "twin", "study", "ima-pkf", "--jobs", "2", "--seeds", "5000"]
    asked += ["--estimators", "ratio", "--out", str(tmp_path / "s")]
    running = subprocess.Popen(asked, stderr=subprocess.PIPE, text=True, start_new_session=True)
    while len(list((tmp_path / "s" / "parts").glob("[!.]*"))) < 20 and running.poll() is None:
        time.sleep(0.05)
    os.kill(running.pid, signal.SIGINT)
    _, said = running.communicate(timeout=60)
    assert running.returncode == 130, said
    assert "Traceback" not in said
    assert "of 5000 runs are in" in said
