"""What `import twin` offers."""

import dataclasses
import subprocess
import sys

import numpy as np
import pytest

import twin
from twin.errors import BadInput, OutOfRange, UnknownName
from twin.testing import streams as drive_streams
from twin.testing.checks import DRIVE, SETUP


@dataclasses.dataclass(frozen=True)
class Measured:
    name: str = "measured"
    seed: int = 1

    def measure(self):
        streams = drive_streams(DRIVE, SETUP, self.seed)
        epoch_ns = streams["wheels"]["epoch_ns"]
        t = (epoch_ns - 1_000_000_000) * 1e-9
        truth = {"epoch_ns": epoch_ns, "slip": DRIVE.slip(t), "speed_mps": DRIVE.speed(t)}
        return SETUP, streams, truth


class Zero:
    def init(self, setup):
        return None

    def run(self, state, chunk):
        epoch_ns = chunk["wheels"]["epoch_ns"]
        return state, {"epoch_ns": epoch_ns, "slip": np.zeros(len(epoch_ns))}


class Failing(Zero):
    def run(self, state, chunk):
        raise RuntimeError("no idea")


def test_importing_it_imports_nothing_heavy() -> None:
    heavy = ("mujoco", "numba", "scipy", "numpy", "gymnasium", "rerun", "pyarrow")
    code = f"import sys, twin; twin.run; print([m for m in {heavy} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("name", twin.__all__)
def test_every_public_name_is_there_and_says_what_it_is(name: str) -> None:
    assert getattr(twin, name).__doc__


def test_an_unknown_name_is_told_with_those_there_are() -> None:
    with pytest.raises(AttributeError, match=r"no attribute 'simulate'; it has: .*run"):
        twin.simulate  # noqa: B018


def test_a_scenario_is_loaded_with_other_fields() -> None:
    loaded = twin.load("plough-25cm", {"soil.friction": 0.8, "seed": 3})
    assert (loaded.soil.friction, loaded.seed) == (0.8, 3)
    with pytest.raises(UnknownName, match="sail"):
        twin.load("plough-25cm", {"sail.friction": 0.8})
    with pytest.raises(OutOfRange, match="friction = 8 is outside"):
        twin.load("plough-25cm", {"soil.friction": 8.0})


def test_objects_and_names_go_together() -> None:
    result = twin.run(Measured(), ["ratio", Zero], seed=4)
    assert result.scenario.seed == 4
    assert set(result.estimates) == {"ratio", "Zero"}
    due = np.sqrt(np.mean(result.truth["slip"] ** 2))
    assert result.scores["estimators"]["Zero"]["slip"]["rmse"] == pytest.approx(due)
    assert result.scores["estimators"]["ratio"]["slip"]["rmse"] < 0.05


def test_one_that_fails_leaves_the_others_alone() -> None:
    result = twin.run(Measured(), {"a": Failing(), "b": Zero()})
    assert list(result.failed) == ["a"]
    assert "no idea" in result.failed["a"]
    assert np.isnan(result.estimates["a"]["slip"]).all()
    assert result.scores["estimators"]["b"]["slip"]["rmse"] > 0.0
    assert any("no idea" in note for note in result.notes)


def test_two_of_one_name_are_refused() -> None:
    with pytest.raises(BadInput, match="two estimators are called 'Zero'"):
        twin.run(Measured(), [Zero(), Zero()])
    with pytest.raises(BadInput, match="has no init"):
        twin.run(Measured(), [object()])


def test_a_result_is_saved_and_shown(tmp_path) -> None:
    result = twin.run(Measured(), ["ratio"])
    folder = result.save(tmp_path / "run")
    assert {p.name for p in folder.iterdir()} >= {"scores.json", "report.html", "run.rrd"}
    result.report(tmp_path / "only.html")
    assert (tmp_path / "only.html").read_text().startswith("<!doctype html>")
    again = twin.estimate(folder, estimators=["ratio"])
    for name, column in result.estimates["ratio"].items():
        np.testing.assert_array_equal(again.estimates["ratio"][name], column)
