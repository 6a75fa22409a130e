"""What the README says is true: its commands, its example, its names, its links."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

import estimators
import scenarios
from twin.cli import COMMANDS

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
NUMBER = re.compile(r"\d+\.\d+")


def block(language: str, after: str = "") -> str:
    """The first fenced block of a language after some text."""
    found = re.search(rf"```{language}\n(.*?)```", README[README.index(after) :], re.DOTALL)
    assert found is not None, f"README.md has no {language} block after {after!r}"
    return found[1]


@pytest.mark.parametrize("command", ["run", "test"])
def test_each_command_is_one_line_that_starts_from_nothing(command: str) -> None:
    line = block("bash", after=f"<!-- command: {command} -->")
    assert line.count("\n") == 1
    assert line.startswith("python3 -m venv .venv && .venv/bin/pip install ")


@pytest.mark.slow
def test_the_example_prints_what_is_shown(tmp_path: Path) -> None:
    example, shown = block("python"), block("text")
    assert len(example.splitlines()) <= 9
    ran = subprocess.run(
        [sys.executable, "-W", "error", "-c", example],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert ran.returncode == 0, ran.stderr
    assert NUMBER.sub("#", ran.stdout) == NUMBER.sub("#", shown)
    ours, theirs = (list(map(float, NUMBER.findall(text))) for text in (ran.stdout, shown))
    assert ours == pytest.approx(theirs, abs=0.11)  # the last digit depends on the processor


def test_every_command_named_exists_and_each_has_its_row() -> None:
    assert set(re.findall(r"\btwin ([a-z-]+)\b", "\n".join(commands()))) <= set(COMMANDS)
    assert re.findall(r"^\| `twin ([a-z-]+)", README, re.MULTILINE) == list(COMMANDS)


def test_every_scenario_and_estimator_named_exists() -> None:
    runs = re.findall(r"twin run ([a-z0-9-]+)", README)
    assert runs
    assert set(runs) <= set(scenarios.REGISTRY)
    used = re.findall(r"--estimators ([\w,:-]+)", README)
    assert used
    named = {name for names in used for name in names.split(",") if ":" not in name}
    assert named <= set(estimators.REGISTRY)


def test_every_environment_named_is_registered() -> None:
    from twin.env import IDS

    named = re.findall(r"twin\.env:([\w-]+)", README)
    assert named
    assert set(named) <= set(IDS)


def test_the_estimator_shown_is_as_long_as_said() -> None:
    said = re.search(r"\((examples/\S+\.py)\) is a whole one in (\d+) lines", README)
    assert said is not None
    assert len((ROOT / said[1]).read_text(encoding="utf-8").splitlines()) == int(said[2])


def test_links_lead_somewhere() -> None:
    targets = re.findall(r"\]\(([^)#]+)\)", README)
    assert targets
    assert [t for t in targets if "://" not in t and not (ROOT / t).exists()] == []


def test_the_table_of_folders_is_the_folders() -> None:
    told = set(re.findall(r"^\| `(\w+)/`", README, re.MULTILINE))
    holding = {
        p.name for p in ROOT.iterdir() if p.is_dir() and p.name[0] not in "._" and any(p.iterdir())
    }
    assert told <= holding
    assert {p.name for p in ROOT.iterdir() if (p / "__init__.py").exists()} <= told


def commands() -> list[str]:
    return re.findall(r"`([^`\n]+)`", README) + re.findall(r"```bash\n(.*?)```", README, re.DOTALL)
