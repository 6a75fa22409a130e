from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.synthetic_run import STUB, synthetic_run
from twin import cli
from twin.commands.parse import one_line
from twin.errors import UnknownName
from twin.pipeline import named as registry
from twin.pipeline import saved
from twin.pipeline.result import Result
from twin.trajectory.end import End, Outcome

HEAVY = ("mujoco", "numba", "rerun", "pyarrow", "matplotlib", "scipy", "gymnasium")


DRIVEN = End(outcome=Outcome.DRIVEN, time_s=12.0, along_m=20.0, left_m=0.0, measured=20.0)
NOTE = "front wheels: W/(b d) = 8 kPa is outside [15, 55] kPa"


class Silent:
    def init(self, setup: object) -> None:
        return None

    def run(self, state: None, chunk: object) -> tuple[None, dict[str, Any]]:
        return None, {}


def load(kind: str, name: str) -> Any:
    if kind == "estimator":
        return Silent()
    if name != "stub":
        raise UnknownName(kind, name, ["stub"])
    return STUB


@pytest.fixture
def stub(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[Any]:
    """A registry of one scenario, a run that costs nothing, an empty working directory."""
    driven: list[Any] = []

    def drive(
        scenario: Any,
        *,
        estimators: Any,
        progress: Callable[[float, float], None],
        frames: Path | None,
        controlled: object = None,
    ) -> Any:
        driven.append(scenario)
        progress(1.0, 20.0)
        record = synthetic_run(scenario=scenario, duration_s=12.0)
        return Result(
            scenario, record.setup, record.streams, record.truth or {}, record.estimates,
            end=DRIVEN, notes=(NOTE,),
        )  # fmt: skip

    monkeypatch.setattr(registry, "load", load)
    monkeypatch.setitem(sys.modules, "twin.pipeline.run", SimpleNamespace(run=drive))
    monkeypatch.setattr(saved, "pictures", lambda result, command: {})
    monkeypatch.chdir(tmp_path)
    return driven


def refused(capsys: pytest.CaptureFixture[str], *args: str) -> str:
    """Exit status 2 and one line on stderr; the line."""
    assert cli.main(args) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("twin: ")
    assert err.count("\n") == 1
    return err.removeprefix("twin: ").rstrip("\n")


def test_a_run_writes_its_folder_and_prints_the_table(
    stub: list[Any], capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["run", "stub", "--seed", "7", "--soil.friction", "0.8"]) == 0
    assert (stub[0].seed, stub[0].soil.friction) == (7, 0.8)
    assert json.loads(Path("runs/stub-seed7/scenario.json").read_text())["soil"]["friction"] == 0.8
    out, err = capsys.readouterr()
    assert "ekf4" in out
    assert "sideslip [m]" in out
    assert out.count(NOTE) == 1
    assert json.loads(Path("runs/stub-seed7/scores.json").read_text())["notes"] == [NOTE]
    assert err == ""


@pytest.mark.parametrize("spelling", ["--plough.depth-m", "--plough.depth_m"])
def test_both_spellings_of_an_override(stub: list[Any], spelling: str) -> None:
    assert cli.main(["run", "stub", spelling, "0.2", "--quiet"]) == 0
    assert stub[0].plough.depth_m == 0.2


def test_json_is_the_scores(stub: list[Any], capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["run", "stub", "--json", "--out", "here"]) == 0
    assert json.loads(capsys.readouterr().out) == json.loads(Path("here/scores.json").read_text())


def test_quiet_says_nothing(stub: list[Any], capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["run", "stub", "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["run", "stab"], "no scenario is called 'stab'; did you mean 'stub'?"),
        (["rum"], "no command is called 'rum'; did you mean 'run'?"),
        (["--seed", "3"], "--seed comes before the command"),
        (["run"], "twin run needs the name of a scenario first"),
        (["run", "--seed", "3", "stub"], "twin run needs the name of a scenario first"),
        (["run", "stub", "--soil.friction", "9"], "soil.friction = 9 is outside [0.05, 1.5]"),
        (["run", "stub", "--soil.friction", "nan"], "soil.friction = nan is outside [0.05, 1.5]"),
        (["run", "stub", "--soil.friction", "wet"], "--soil.friction = wet is not a number"),
        (["run", "stub", "--seed", "x"], "--seed = x is not a whole number"),
        (["run", "stub", "--soil.preset", "mud"], "invalid choice 'mud'"),
        (["run", "stub", "--sol.friction", "1"], "did you mean --soil.friction?"),
        (["run", "stub", "--length-m", "0"], "length_m = 0 is outside [1, 2000]"),
        (["run", "stub", "--seed"], "Missing value for argument '--seed'"),
        (["run", "stub", "--estimators", ","], "--estimators is empty"),
        (["run", "stub", "--out", "/"], "/ exists and is not a run folder"),
        (["view", "nowhere"], "nowhere does not exist"),
        (["view"], "twin view needs"),
        (["estimate", "nothing.csv"], "nothing.csv: there is no such file"),
        (["bench", "--json", "no/where.json"], "there is no directory no"),
    ],
)
def test_bad_input_is_one_line(
    stub: list[Any], capsys: pytest.CaptureFixture[str], args: list[str], message: str
) -> None:
    assert message in refused(capsys, *args)
    assert stub == []
    assert os.listdir() == []


WORDS = st.sampled_from(
    [
        "--soil.friction", "--field.cross-slope-deg", "--plough.depth_m", "--length-m", "--seed",
        "--soil.preset", "--plough.offsets-m", "--json", "--estimators", "--", "-", "=", "",
    ]
) | st.text(max_size=8)  # fmt: skip
VALUES = st.floats().map(repr) | st.integers().map(str) | st.text(max_size=6)


@settings(
    max_examples=120, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(st.lists(st.tuples(WORDS, VALUES), max_size=3))
def test_no_arguments_whatever_give_a_traceback(
    stub: list[Any], capsys: pytest.CaptureFixture[str], pairs: list[tuple[str, str]]
) -> None:
    args = [word for pair in pairs for word in pair if not word.startswith(("-h", "--h"))]
    status = cli.main(["run", "stub", "--quiet", *args])
    err = capsys.readouterr().err
    assert status in (0, 2)
    assert err.count("\n") == (status == 2)


def test_interrupted_is_130_and_leaves_nothing(
    stub: list[Any], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def stop(*args: object, **kwargs: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setitem(sys.modules, "twin.pipeline.run", SimpleNamespace(run=stop))
    assert cli.main(["run", "stub"]) == 130
    assert os.listdir() == []
    assert capsys.readouterr().err == "twin: interrupted; nothing was written\n"


SHARED = Path(__file__).parents[2] / "shared" / "data" / "t7165s_field.csv"
MAP = Path(__file__).parents[1] / "examples" / "t7165s.toml"


@pytest.mark.skipif(not SHARED.exists(), reason="the tractor's log is not beside the checkout")
@pytest.mark.skipif(not MAP.exists(), reason="examples are not beside the tests")
def test_a_real_log_gives_its_steady_slip(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    args = ["estimate", str(SHARED), "--map", str(MAP), "--out", str(tmp_path / "log"), "--json"]
    assert cli.main([*args, "--estimators", "ratio"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["steady"]["slip_median"] == pytest.approx(0.070, abs=0.015)  # data/README.md
    assert found["steady_slip"]["ratio"]["median"] == pytest.approx(0.070, abs=0.015)
    assert {"report.html", "run.rrd", "scores.json"} <= set(os.listdir(tmp_path / "log"))


def test_a_run_folder_is_a_log_with_its_truth(
    stub: list[Any], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    class Still(Silent):
        def run(self, state: None, chunk: Any) -> tuple[None, dict[str, Any]]:
            epoch_ns = chunk["wheels"]["epoch_ns"]
            return None, {"epoch_ns": epoch_ns, "slip": 0.0 * epoch_ns}

    monkeypatch.setattr(registry, "load", lambda kind, name: Still())
    truth = synthetic_run(duration_s=12.0)
    from twin.io import run_folder as runfolder

    runfolder.write(truth, {}, Path("drive"))
    assert cli.main(["estimate", "drive", "--out", "again", "--json", "--estimators", "still"]) == 0
    slip = json.loads(capsys.readouterr().out)["estimators"]["still"]["slip"]
    assert slip["bias"] == pytest.approx(-0.1, abs=0.01)


def test_bench_writes_its_rows(
    stub: list[Any], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import twin.bench as package

    row = {"case": "step", "quantity": "share of native", "ours": 0.44, "high": 0.8, "passed": True}
    bench = SimpleNamespace(rows=lambda: [row])
    monkeypatch.setitem(sys.modules, "twin.bench.bench", bench)
    monkeypatch.setattr(package, "bench", bench, raising=False)
    assert cli.main(["bench", "--json", "rows.json"]) == 0
    assert json.loads(Path("rows.json").read_text()) == {"rows": [row]}
    assert "0.44" in capsys.readouterr().out


def test_list_names_everything_with_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    import estimators
    import scenarios

    assert cli.main(["list", "--json"]) == 0
    groups = json.loads(capsys.readouterr().out)
    assert list(groups["scenarios"]) == list(scenarios.REGISTRY)
    assert list(groups["estimators"]) == list(estimators.REGISTRY)
    assert all(line for group in groups.values() for line in group.values())


@pytest.mark.parametrize("args", [["--help"], ["list"]])
def test_answers_at_once_and_imports_nothing_heavy(args: list[str]) -> None:
    code = (
        f"import sys; from twin.cli import main; status = main({args!r}); "
        f"print([m for m in {HEAVY!r} if m in sys.modules]); sys.exit(status)"
    )
    start = time.perf_counter()
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"
    assert time.perf_counter() - start < 5.0  # a second where nothing else runs


BOX = """
╭─ Value error ──────────────────────────────╮
│ Error parsing scenario.soil: soil.friction │
│ = 9 is outside [0.05, 1.5]                 │
│ ────────────────────────────────────────── │
│ For full helptext, see twin run --help     │
╰────────────────────────────────────────────╯
"""
PLAIN_BOX = """
 Value error
 -------------------------------------------
  Error parsing scenario.soil: soil.friction
  = 9 is outside [0.05, 1.5]
  ------------------------------------------
  For full helptext, see twin run --help
"""


@pytest.mark.parametrize("box", [BOX, PLAIN_BOX])
def test_boxes_become_a_line(box: str) -> None:
    assert one_line(box.lstrip("\n")) == "soil.friction = 9 is outside [0.05, 1.5]"


def test_the_pace_is_told_where_time_is_simulated() -> None:
    from twin.commands.terminal import pace

    assert pace(42.0, 2.0) == "42 s driven, 21.0 x real time"
    assert pace(None, 2.0) == ""
