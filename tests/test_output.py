"""What every command does with --json, --quiet, a bar and Ctrl-C."""

from __future__ import annotations

import importlib
import io
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterable
from contextlib import redirect_stdout
from pathlib import Path
from types import SimpleNamespace

import pytest
from joblib import delayed
from rich.console import Console

from twin import cli
from twin.commands import terminal
from twin.compute.parallel import many, reporting
from twin.io import atomic as written

ROW = {"case": "step", "quantity": "share", "ours": 0.44, "high": 0.8, "passed": True}
RIG = ("rig", "wheel", "--slip", "0.1", "0.2", "--slip-angle-deg", "0")


@pytest.mark.parametrize(
    "command",
    [("run", "plough-25cm"), ("estimate",), ("reproduce", "ima-pkf"), ("validate",), ("study",),
     ("rig", "wheel"), ("compare-controllers",), ("bench",)],
    ids=lambda words: words[0],
)  # fmt: skip
def test_every_command_can_be_quiet_and_give_json(command: tuple[str, ...]) -> None:
    told = io.StringIO()
    with redirect_stdout(told):
        assert cli.main([*command, "--help"]) == 0
    assert {"--quiet", "--json"} <= set(told.getvalue().split())


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    made = SimpleNamespace(rows=lambda: [ROW])
    monkeypatch.setitem(sys.modules, "twin.bench.bench", made)
    monkeypatch.setattr(importlib.import_module("twin.bench"), "bench", made, raising=False)
    monkeypatch.chdir(tmp_path)


@pytest.mark.usefixtures("bench")
@pytest.mark.parametrize("args", [["--json"], ["--json", "-"], ["--json", "--quiet"]])
def test_json_without_a_name_is_all_there_is_on_stdout(
    capsys: pytest.CaptureFixture[str], args: list[str]
) -> None:
    assert cli.main(["bench", *args]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out) == {"rows": [ROW]}
    assert err == ""
    assert os.listdir() == []


@pytest.mark.usefixtures("bench")
def test_quiet_rows_go_to_their_file_and_nowhere_else(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["bench", "--quiet", "--json", "rows.json"]) == 0
    assert capsys.readouterr() == ("", "")
    assert json.loads(Path("rows.json").read_text()) == {"rows": [ROW]}
    assert cli.main(["bench", "--json", "."]) == 2
    assert "is a directory; name a file" in capsys.readouterr().err


def test_a_rig_is_quiet_or_gives_its_columns(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cli.main([*RIG, "--quiet", "--out", "quiet"]) == 0
    assert capsys.readouterr() == ("", "")
    assert cli.main([*RIG, "--json", "--out", "columns"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["wheel.csv"]["slip"] == pytest.approx([0.1, 0.2])
    files = {"wheel.csv", "wheel-free.csv", "wheel.png"}
    assert {p.name for p in Path("quiet").iterdir()} == files
    assert sorted(os.listdir()) == ["columns", "quiet"]


def test_runs_are_told_as_they_end_and_those_inside_them_are_not() -> None:
    told: list[tuple[int, int]] = []
    with reporting(lambda done, total: told.append((done, total))):
        assert many([delayed(many)([delayed(abs)(-1)]), delayed(abs)(-2)]) == [[1], 2]
    assert [done for done, _ in told] == sorted(done for done, _ in told)
    assert told[0] == (0, 2)
    assert told[-1] == (2, 2)
    many([delayed(abs)(-1)])
    assert told[-1] == (2, 2)


def test_a_bar_counts_over_its_stages_and_only_on_a_terminal(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def shown(*, on_terminal: bool) -> str:
        out = io.StringIO()
        made = Console(file=out, force_terminal=on_terminal, width=120)
        monkeypatch.setattr(terminal, "console", lambda stderr=False: made)
        monkeypatch.setattr(terminal, "_plain", lambda stderr=False: False)
        with terminal.counting("paper", "runs", shown=True) as tell:
            for stage in ((0, 2), (1, 2), (2, 2), (0, 4), (1, 4)):
                tell(*stage)
        return out.getvalue()

    assert "3 runs" in shown(on_terminal=True)
    assert shown(on_terminal=False) == ""


def test_a_rate_is_told_a_second_or_a_minute() -> None:
    assert terminal.rate(30, "runs", 20.0) == "30 runs, 1.5 a second"
    assert terminal.rate(3, "runs", 20.0) == "3 runs, 9.0 a minute"
    assert terminal.rate(0, "runs", 20.0) == ""


def test_files_are_there_whole_or_not_at_all(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "kept").write_text("old")

    def stopped() -> None:
        with written.moved_when_complete(tmp_path / "out") as partial:
            (partial / "half").write_text("new")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stopped()
    assert [p.name for p in tmp_path.rglob("*")] == ["out", "kept"]
    with written.moved_when_complete(tmp_path / "out") as partial:
        (partial / "whole").write_text("new")
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["kept", "whole"]


def _deaf() -> bool:
    return signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, [])


def test_processes_leave_ctrl_c_to_the_one_that_began_them() -> None:
    assert many([delayed(_deaf)() for _ in range(4)], jobs=2) == [True] * 4
    assert not _deaf()


INTERRUPTED = {
    "run": ["run", "slope-9-dry", "--course.calibration-m", "200", "--frames", "frames"],
    "reproduce": ["reproduce", "plough-field", "--jobs", "2", "--json", "rows.json"],
    "validate": ["validate", "--json", "rows.json", "--out", "page.md", "--report", "page.html"],
    "rig": ["rig", "slope", "--cross-slope-deg", *(f"{0.1 * i:.1f}" for i in range(120))],
    "compare-controllers": ["compare-controllers", "--json", "rows.json", "--report", "page.html"],
}


@pytest.mark.slow
def test_ctrl_c_ends_a_command_with_a_line_and_leaves_nothing(tmp_path: Path) -> None:
    """The other commands: tests/long."""
    ends_at_ctrl_c(["run", "reproduce"], tmp_path)


def ends_at_ctrl_c(names: Iterable[str], tmp_path: Path) -> None:
    started = {}
    for name in names:
        words = INTERRUPTED[name]
        (tmp_path / name).mkdir()
        started[name] = subprocess.Popen(
            [sys.executable, "-m", "twin", *words], cwd=tmp_path / name,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
            env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])},
        )  # fmt: skip
    time.sleep(8.0)  # all are at work, and none is done by far
    for process in started.values():
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to the workers too
    for name, process in started.items():
        out, err = process.communicate(timeout=60)
        said = err.splitlines()
        assert process.returncode == 130, (name, out, err)
        assert said[-1] == "twin: interrupted; nothing was written"
        assert not any("Traceback" in line for line in said), (name, err)
        assert list((tmp_path / name).iterdir()) == []
