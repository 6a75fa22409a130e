"""Every estimator runs through stops, shifts, ways backwards and an engine that is off."""

import json

import numpy as np
import pytest

from estimators import REGISTRY
from tests.simulation.test_events import ROWS
from twin import cli
from twin.pipeline.public import by_name
from twin.pipeline.run import run
from twin.trajectory.phase import Phase

NAMES = (
    "stop and restart on 15 degrees up", "reverse with the plough", "brake",
    "synchronised under load", "lug and recover", "headland with backing", "engine off and on",
)  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_every_estimator_runs_through(name):
    result = run(ROWS[name], estimators=by_name(list(REGISTRY)))
    assert not result.failed
    for estimator, table in result.estimates.items():
        for column, values in table.items():
            assert not np.isinf(values).any(), (estimator, column)
        assert np.isfinite(table["slip"]).any() or "slip" not in table, estimator
    for column, values in result.truth.items():
        assert not np.isinf(values).any(), column


@pytest.mark.slow
def test_events_of_a_file_are_driven_and_kept(tmp_path):
    path, out = tmp_path / "day.toml", tmp_path / "run"
    path.write_text('[[event]]\ndo = "stop"\nat_s = 2\nfor_s = 2\n')
    words = ("--events", str(path), "--course.length-m", "8", "--estimators", "ratio")
    assert cli.main(["run", "road-gravel-7kmh", *words, "--out", str(out), "--quiet"]) == 0
    kept = json.loads((out / "scenario.json").read_text())
    assert [(e["do"], e["for_s"]) for e in kept["events"]] == [("stop", 2.0)]
    import pyarrow.parquet as pq

    assert Phase.STOP in set(pq.read_table(out / "truth.parquet")["phase"].to_pylist())


def test_a_bad_file_of_events_is_one_line(tmp_path, capsys):
    path = tmp_path / "day.toml"
    path.write_text('[[event]]\ndo = "shift"\ngear = 40\nat_s = 3\n')
    assert cli.main(["run", "plough-25cm", "--events", str(path)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert f"{path}: events.0: shift at 3 s: gear = 40 is outside [1, 17]" in said
    assert cli.main(["run", "ima-pkf", "--events", str(path)]) == 2
    assert "no machine that is driven" in capsys.readouterr().err
