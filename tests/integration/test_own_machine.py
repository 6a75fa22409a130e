"""A new user's way: a tractor from a data sheet, driven by every part of the twin."""

from pathlib import Path

import gymnasium
import numpy as np
import pytest

import twin
from tests.vehicle.wrong_files import IMPLEMENT, MACHINE
from twin import cli
from twin.pipeline.named import load

SHORT = ["--course.length-m", "10", "--quiet"]


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    assert len([line for line in MACHINE.splitlines() if line]) <= 15
    Path("mine.toml").write_text(MACHINE)
    Path("tool.toml").write_text(IMPLEMENT)
    return tmp_path


def test_it_ploughs_and_cultivates_and_its_folder_repeats_it_without_the_files(own, capsys):
    plough = ["run", "plough-20cm", "--machine", "mine.toml", *SHORT]
    assert cli.main([*plough, "--out", "ploughed"]) == 0
    cultivate = ["--implement", "tool.toml", "--plough.depth-m", "0.1", "--out", "cultivated"]
    assert cli.main([*plough, *cultivate]) == 0
    for folder in ("ploughed", "cultivated"):
        assert {"report.html", "run.rrd", "truth.parquet", "scenario.json"} <= {
            p.name for p in Path(folder).iterdir()
        }  # fmt: skip
    Path("mine.toml").unlink()
    Path("tool.toml").unlink()
    kept = load("scenario", "cultivated")
    assert (kept.machine, kept.implement) == ("mine", "my_cultivator")
    again = twin.run(kept, ["ratio"])
    assert again.setup.machine == "mine"
    assert again.truth["draft_n"][again.truth["ploughing"]].mean() > 2000.0


def test_rig_study_export_and_checks_take_it(own, capsys):
    assert (
        cli.main(["rig", "drawbar", "--machine", "mine.toml", "--step-n", "4000", "--quiet"]) == 0
    )
    assert cli.main(["rig", "park", "--machine", "mine.toml", "--parked-s", "2", "--quiet"]) == 0
    study = ["study", "plough-20cm", "--machine", "mine.toml", "--seeds", "1", "--jobs", "1"]
    assert cli.main([*study, "--sweep", "course.length_m=6", "--quiet"]) == 0
    assert cli.main(["machine", "export", "mine.toml", "mine.xml"]) == 0
    assert cli.main(["run", "plough-20cm", "--machine", "mine.xml", *SHORT, "--out", "xml"]) == 0
    assert cli.main(["machine", "show", "mine.toml", "--json"]) == 0
    assert '"rear.stiffness_npm"' in capsys.readouterr().out


@pytest.mark.parametrize("implement", [[], ["--implement", "none"], ["--implement", "tool.toml"]])
def test_a_mjcf_with_an_implement_is_refused_in_one_line(own, implement, capsys):
    export = ["machine", "export", "mine.toml", "full.xml", "--implement", "tool.toml"]
    assert cli.main(export) == 0
    for command in (
        ["run", "plough-20cm", "--machine", "full.xml", *implement],
        ["machine", "export", "full.xml", "again.xml", *implement],
        ["machine", "check", "full.xml"],
        ["machine", "show", "full.xml"],
    ):
        capsys.readouterr()
        assert cli.main(command) == 2
        err = capsys.readouterr().err
        assert err.count("\n") == 1
        assert "carries an implement already" in err
        assert "without --implement" in err
    assert {p.name for p in own.iterdir()} == {"mine.toml", "tool.toml", "full.xml"}


@pytest.mark.parametrize(
    "chosen",
    [{"machine": "mine.toml", "implement": "tool.toml", "depth_m": 0.1},
     {"machine": "jd_4250", "implement": "chisel_3m"}],
)  # fmt: skip
def test_an_environment_takes_it(own, chosen):
    env = gymnasium.make("twin.env:Plough-v0", **chosen)
    first, _ = env.reset(seed=1)
    assert np.all(np.isfinite(first))
    for _ in range(100):
        observation, _, ended, _, info = env.step(np.array([0.0, 0.5], np.float32))
        assert np.all(np.isfinite(observation))
    assert info["draft_n"] > 500.0
    assert not ended
    many = gymnasium.make_vec(
        "twin.env:Plough-v0", num_envs=2, vectorization_mode="vector_entry_point", **chosen
    )
    assert many.reset(seed=1)[0].shape == (2, *first.shape)


@pytest.mark.parametrize(
    ("chosen", "said"),
    [({"implement": "cultivator_3m"},
      r"^depth_m = 0\.25 is outside \[0\.03, 0\.15\], the depths of cultivator_3m$"),
     ({"depth_m": 0.9}, r"^depth_m = 0\.9 is outside \[0\.\d+, 0\.\d+\]")],
)  # fmt: skip
def test_a_depth_that_does_not_do_is_refused_by_the_arguments_name(chosen, said):
    for make in (gymnasium.make, gymnasium.make_vec):
        with pytest.raises(twin.errors.OutOfRange, match=said):
            make("twin.env:Plough-v0", **chosen)


def test_a_machine_without_motors_on_its_wheels_is_refused_by_wheelslip():
    with pytest.raises(twin.errors.BadInput, match=r"engine\.wheel_torque_nm"):
        gymnasium.make("twin.env:WheelSlip-v0", machine="jd_4250")
