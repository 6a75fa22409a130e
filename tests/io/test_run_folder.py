from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import numpy as np
import pytest

from tests.synthetic_run import Scenario, synthetic_run
from twin.errors import BadInput
from twin.io import run_folder as runfolder
from twin.io.run_folder import Record

RUN = synthetic_run(duration_s=2.0)


def test_what_is_read_is_what_was_written(tmp_path: Path) -> None:
    back = runfolder.read(runfolder.write(RUN, {"seed": 1}, tmp_path / "run"), Scenario)
    assert (back.scenario, back.setup, back.scores) == (RUN.scenario, RUN.setup, {"seed": 1})
    assert RUN.truth is not None
    assert back.truth is not None
    for ours, theirs in (
        (RUN.truth, back.truth),
        *((RUN.streams[s], back.streams[s]) for s in RUN.streams.tables),
        *((RUN.estimates[e], back.estimates[e]) for e in RUN.estimates),
    ):
        assert ours.keys() == theirs.keys()
        for name, column in ours.items():
            assert theirs[name].dtype == column.dtype
            np.testing.assert_array_equal(theirs[name], column)


def test_only_the_folder_itself_is_left_behind(tmp_path: Path) -> None:
    runfolder.write(RUN, {}, tmp_path / "run")
    runfolder.write(RUN, {"again": True}, tmp_path / "run")
    assert os.listdir(tmp_path) == ["run"]
    assert json.loads((tmp_path / "run/scores.json").read_text()) == {"again": True}


def test_a_failing_picture_leaves_nothing(tmp_path: Path) -> None:
    def fail(run: object, scores: object, path: Path) -> None:
        path.write_text("half")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        runfolder.write(RUN, {}, tmp_path / "run", pictures={"report.html": fail})
    assert os.listdir(tmp_path) == []


def test_a_failing_second_run_leaves_the_first(tmp_path: Path) -> None:
    def fail(run: object, scores: object, path: Path) -> None:
        raise KeyboardInterrupt

    runfolder.write(RUN, {"first": True}, tmp_path / "run")
    with pytest.raises(KeyboardInterrupt):
        runfolder.write(RUN, {}, tmp_path / "run", pictures={"report.html": fail})
    assert runfolder.read(tmp_path / "run").scores == {"first": True}


def test_a_killed_run_leaves_no_folder_under_its_name(tmp_path: Path) -> None:
    code = textwrap.dedent(f"""
        import sys, time
        sys.path.insert(0, {str(Path(__file__).parents[2])!r})
        from pathlib import Path
        from tests.synthetic_run import synthetic_run
        from twin.io import run_folder as runfolder

        def wait(run, scores, path):
            print("written", flush=True)
            time.sleep(60)

        runfolder.write(synthetic_run(duration_s=1.0), {{}}, Path({str(tmp_path / "run")!r}),
                        pictures={{"report.html": wait}})
    """)
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"written\n"
        process.send_signal(signal.SIGKILL)
        time.sleep(0.05)
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("kind", ["file", "folder"])
def test_what_is_not_ours_is_not_replaced(tmp_path: Path, kind: str) -> None:
    target = tmp_path / "thesis"
    if kind == "file":
        target.write_text("years of work")
    else:
        target.mkdir()
        (target / "thesis.tex").write_text("years of work")
    with pytest.raises(BadInput, match="exists and is not a run folder"):
        runfolder.write(RUN, {}, target)
    assert target.exists()


def test_an_empty_folder_may_be_filled(tmp_path: Path) -> None:
    assert runfolder.read(runfolder.write(RUN, {}, tmp_path)).scores == {}


@pytest.mark.parametrize(
    ("file", "damage", "message"),
    [
        ("scenario.json", None, "scenario.json is missing"),
        ("scores.json", b"{", "scores.json is not JSON"),
        ("scores.json", b"\xff\xfe", "scores.json is not JSON"),
        ("streams/setup.json", b"[]", "setup.json"),
        ("streams/setup.json", None, "setup.json is missing"),
        ("estimates.parquet", None, "estimates.parquet is missing"),
        ("truth.parquet", b"PAR1 and then nothing", "truth.parquet is not a whole Parquet file"),
        ("streams/gnss.parquet", b"", "gnss.parquet is not a whole Parquet file"),
    ],
)
def test_damage_is_named(tmp_path: Path, file: str, damage: bytes | None, message: str) -> None:
    directory = runfolder.write(RUN, {}, tmp_path / "run")
    if damage is None:
        (directory / file).unlink()
    else:
        (directory / file).write_bytes(damage)
    with pytest.raises(BadInput, match=message) as caught:
        runfolder.read(directory)
    assert "\n" not in str(caught.value)


def test_a_log_has_neither_scenario_nor_truth(tmp_path: Path) -> None:
    log = Record(setup=RUN.setup, streams=RUN.streams, estimates=RUN.estimates)
    back = runfolder.read(runfolder.write(log, {}, tmp_path / "log"), Scenario)
    assert (back.scenario, back.truth) == (None, None)


def test_an_estimator_that_gave_no_row_survives(tmp_path: Path) -> None:
    empty = {"epoch_ns": np.empty(0, np.int64), "slip": np.empty(0)}
    log = Record(setup=RUN.setup, streams=RUN.streams, estimates={"silent": empty})
    back = runfolder.read(runfolder.write(log, {}, tmp_path / "log"))
    assert back.estimates == {}
