"""`twin tune` at the command line: its file, table and JSON, and one line for what is wrong."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from twin import cli
from twin.pipeline import tuned

PAGE = Path(__file__).parents[2] / "docs" / "tuning.md"
MAP = """
[log]
time = {column = "t", unit = "s"}
[gnss]
east = {column = "x", unit = "m"}
north = {column = "y", unit = "m"}
v_east = {column = "v", unit = "m/s"}
v_north = {column = "y", unit = "m/s"}
[wheels]
driven_speed = {column = "w", unit = "m/s"}
[setup]
machine = "my tractor"
wheelbase_m = 2.8
[setup.gnss]
velocity_sd_mps = 0.03
"""


@pytest.fixture
def log(tmp_path, monkeypatch):
    """90 s at 10 Hz, whose receiver is four times as noisy as told, and the page's own.py."""
    t = np.arange(0.0, 90.0, 0.1)
    v = 2.0 + 0.3 * np.sin(0.2 * t)
    seen = v + 0.12 * np.random.default_rng(1).standard_normal(len(t))
    path = np.concatenate([[0.0], np.cumsum(0.05 * (v[1:] + v[:-1]))])
    rows = [f"{a:.1f},{x:.3f},0,{s:.4f},{1.1 * w:.4f}" for a, x, s, w in np.c_[t, path, seen, v]]
    (tmp_path / "drive.csv").write_text("t,x,y,v,w\n" + "\n".join(rows) + "\n")
    (tmp_path / "drive.toml").write_text(MAP)
    own = re.search(r"<!-- file: own.py -->\n```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    (tmp_path / "own_walk.py").write_text(own[1])
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    return ["drive.csv", "--map", "drive.toml"]


def test_the_file_goes_back_into_estimate(log, capsys):
    assert cli.main(["tune", *log, "--estimators", "own_walk:Walk"]) == 0
    out = capsys.readouterr().out
    assert "gnss_velocity sd, factor" in out
    assert re.search(r"log density of a measurement .* better", out)
    noises = tuned.read(Path("drive-tuning.toml"))["own_walk:Walk"]
    assert noises.factors["gnss_velocity"] == pytest.approx(4.0, rel=0.15)
    tuning = ["--tuning", "drive-tuning.toml", "--estimators", "own_walk:Walk", "--out", "r"]
    assert cli.main(["estimate", *log, *tuning]) == 0
    assert "own_walk:Walk: tuned: " in capsys.readouterr().out


def test_json(log, capsys):
    assert cli.main(["tune", *log, "--estimators", "own_walk:Walk", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["schema"] == 1
    found = told["estimators"]["own_walk:Walk"]
    assert found["verdict"] == "better"
    value = next(v for v in found["values"] if v["name"] == "gnss_velocity")
    assert value["low"] < value["value"] < value["high"]
    assert {"name", "before", "grade", "why", "gain"} <= value.keys()
    assert {"quantity", "before", "after", "change", "low", "high", "verdict"} <= found["gains"][
        0
    ].keys()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["no.csv"], "no.csv: there is no such file"),
        ([], "no log is named"),
        (["LOG", "--learn-share", "0.95"], "learn_share = 0.95 is outside"),
        (["LOG", "--estimators", "ratio"], "'ratio' has no innovations"),
        (["LOG", "--estimators", "four"], "no estimator is called 'four'"),
        (["LOG", "--out", "drive.toml"], "drive.toml exists and twin tune did not write it"),
    ],
)
def test_what_is_wrong_is_one_line(log, capsys, options, message):
    args = [word for option in options for word in (log if option == "LOG" else [option])]
    assert cli.main(["tune", *args]) == 2
    said = capsys.readouterr().err.strip()
    assert message in said
    assert "\n" not in said
    assert not Path("drive-tuning.toml").exists()


def test_a_file_of_no_use_is_one_line(log, capsys):
    Path("t.toml").write_text("schema = 1\n[four-state.values]\njerk = 1\n")
    for estimators, message in (("ratio", "is of four-state, and ratio are run"),
                                ("four-state", "'jerk'")):  # fmt: skip
        args = ["--estimators", estimators, "--tuning", "t.toml"]
        assert cli.main(["estimate", *log, *args]) == 2
        assert message in capsys.readouterr().err
