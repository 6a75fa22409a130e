"""Every code block of the README and of docs/ is run, here or in tests/long; every command exists.

A comment before a block says if something else becomes of it:

    <!-- file: NAME -->      written to NAME in the page's folder, in which its blocks run in order
    <!-- not run: WHY -->    only its `twin` commands and their options must exist
    <!-- command: NAME -->   the README's, run on a fresh copy by `.ci/run` and the wheel's test
"""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
import tomllib
from contextlib import redirect_stdout
from dataclasses import dataclass
from functools import cache
from io import StringIO
from pathlib import Path

import pytest

from twin import cli

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
ROOT_PAGES = [ROOT / name for name in ("CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md")]
FENCE = re.compile(r"(?:^<!-- ([^\n]*?) -->\n)?^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
MARKS = ("file: ", "not run: ", "command: ")
SUPERSEDED = re.compile(r"^.*DeprecationWarning.*-v0 is out of date.*$", re.MULTILINE)
"""What Gymnasium says of an environment that has a newer version."""
FLAG = re.compile(r"--[a-z][\w.-]*")


def name(page: Path) -> str:
    return page.name


@dataclass(frozen=True)
class Block:
    mark: str
    language: str
    text: str

    @property
    def file(self) -> str | None:
        return self.mark.removeprefix("file: ") if self.mark.startswith("file: ") else None

    @property
    def runs(self) -> bool:
        return self.language in ("python", "bash") and not self.mark.startswith(MARKS)


def blocks(page: Path) -> list[Block]:
    return [Block(*found) for found in FENCE.findall(page.read_text(encoding="utf-8"))]


RUN = [p for p in PAGES[1:] if any(b.runs for b in blocks(p))]
"""The README's example has a test of its own, which compares what it prints."""
WITH_PYTHON = [p for p in RUN if any(b.runs and b.language == "python" for b in blocks(p))]


def commands(page: Path) -> list[list[str]]:
    """Every `twin ...` of a page's bash blocks and of its code spans, as words."""
    text = page.read_text(encoding="utf-8")
    lines = [b.text.replace("\\\n", " ") for b in blocks(page) if b.language == "bash"]
    spans = re.findall(r"`((?:\.venv/bin/)?twin [^`\n]+)`", FENCE.sub("", text))
    pieces = [
        p for line in "\n".join([*lines, *spans]).split("\n") for p in re.split("&&|[|;]", line)
    ]
    found = [re.split(r"\s#\s", p)[0].strip().removeprefix(".venv/bin/") for p in pieces]
    return [shlex.split(p) for p in found if p.startswith("twin ")]


@pytest.mark.slow
@pytest.mark.parametrize("page", WITH_PYTHON, ids=name)
def test_every_block_of_python_runs(page: Path, tmp_path: Path) -> None:
    """Commands, too: tests/long. That they and their options exist is tested below."""
    runs(page, tmp_path, "python")


def runs(page: Path, folder: Path, *languages: str) -> None:
    """Run a page's blocks in a folder, after its files are written there."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    chosen = [b for b in blocks(page) if b.file or (b.runs and b.language in languages)]
    ran = subprocess.run(
        [sys.executable, "-W", "error", str(Path(__file__).with_name("run_page.py"))],
        input=json.dumps([(b.file or b.language, b.text) for b in chosen]),
        cwd=folder,
        env={**os.environ, "PATH": path, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert ran.returncode == 0, ran.stderr
    assert "Warning" not in SUPERSEDED.sub("", ran.stderr)


def test_every_block_is_run_or_says_why_not() -> None:
    marked = {(p.name, b.mark) for p in PAGES for b in blocks(p) if b.mark}
    assert [m for _, m in marked if not m.startswith(MARKS)] == []
    left_out = [(p, m.removeprefix("not run: ")) for p, m in marked if m.startswith("not run: ")]
    assert all(len(why.split()) > 3 for _, why in left_out)
    assert len(left_out) <= 5


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_every_command_and_option_exists(page: Path) -> None:
    for _, *words in commands(page):
        if words and words[0] in cli.COMMANDS:
            known = help_of(*_named(words))
            given = [w.split("=")[0] for w in words if FLAG.match(w)]
            assert [g for g in given if g not in known] == [], f"{page.name}: {' '.join(words)}"


@pytest.mark.parametrize("page", [*PAGES, *ROOT_PAGES], ids=name)
def test_links_and_pictures_lead_somewhere(page: Path) -> None:
    targets = re.findall(r"\]\(([^)#\s]+)[^)]*\)", FENCE.sub("", page.read_text(encoding="utf-8")))
    assert [t for t in targets if "://" not in t and not (page.parent / t).exists()] == []


@pytest.mark.parametrize(
    ("page", "name", "lines"),
    [
        ("your-own-estimator.md", "mine.py", 25),
        ("your-own-controller.md", "gentle.py", 20),
        ("your-own-scenario.md", "wet_hollow.py", 25),
        ("your-own-sensor.md", "radar.py", 40),
        ("your-own-log-reader.md", "data_logger.py", 25),
    ],
)
def test_what_a_page_shows_is_the_example_and_short(page: str, name: str, lines: int) -> None:
    shown = {b.file: b.text for b in blocks(ROOT / "docs" / page)}
    assert shown[name] == (ROOT / "examples" / name).read_text(encoding="utf-8")
    assert len(shown[name].splitlines()) <= lines


def test_the_citation_is_of_this_version() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    version = f"version: {project['version']}\n"
    assert version in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    page = (ROOT / "docs/cite.md").read_text(encoding="utf-8")
    assert page.count(project["version"]) == 2


def test_the_drawings_are_what_the_script_draws() -> None:
    space: dict[str, object] = {"__name__": "drawings", "__file__": str(ROOT / "docs/drawings.py")}
    exec((ROOT / "docs/drawings.py").read_text(encoding="utf-8"), space)
    for name, text in space["drawings"]().items():  # type: ignore[operator]
        assert (ROOT / "docs/pictures" / name).read_text(encoding="utf-8") == text


def _named(words: list[str]) -> tuple[str, ...]:
    """A command with the name that its options depend on, if it has one that exists."""
    bare = len(words) > 1 and re.fullmatch(r"[a-z][a-z0-9-]*", words[1]) is not None
    if words[0] == "run" and not bare:
        return "run", "plough-25cm"
    return (words[0], words[1]) if words[0] in ("run", "rig", "reproduce") and bare else (words[0],)


@cache
def help_of(*command: str) -> frozenset[str]:
    told = StringIO()
    with redirect_stdout(told):
        assert cli.main([*command, "--help"]) == 0, command
    return frozenset(FLAG.findall(told.getvalue()))
