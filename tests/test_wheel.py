"""What is shipped: the wheel, made from the source distribution, in an environment of its own.

What it depends on is lent by the environment of the tests, and its list of that is compared with
what it imports. With TWIN_WHEEL_ALONE=1 pip installs it all anew, as `.ci/long wheel` does.
"""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
from collections.abc import Iterator
from importlib.metadata import packages_distributions
from pathlib import Path, PurePosixPath
from zipfile import ZipFile

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[1]
PACKAGES = ("twin", "scenarios", "estimators")
HEAVY = ("mujoco", "numba", "scipy", "pyarrow", "matplotlib", "rerun", "gymnasium", "cv2", "pandas")
LARGEST_BYTES = 20_000_000
ALONE = os.environ.get("TWIN_WHEEL_ALONE") == "1"
BROUGHT = {
    "glfw": "mujoco",
    "llvmlite": "numba",
    "pandas": "an extra, and only imported where it is asked for",
    "stable_baselines3": "an extra, and only imported where it is asked for",
}
"""What the wheel imports and does not name -> what brings it."""


@pytest.fixture(scope="module")
def folder() -> Iterator[Path]:
    """Work room that does not outlive the tests: an environment is more than a gigabyte."""
    with tempfile.TemporaryDirectory(prefix="tractor-twin-wheel-") as name:
        yield Path(name)


@pytest.fixture(scope="module")
def built(folder: Path) -> Path:
    """Folder with the source distribution, and the wheel made from that alone."""
    build = [sys.executable, "-m", "build", "--outdir", str(folder / "dist"), str(ROOT)]
    quietly(build, cwd=folder)
    return folder / "dist"


@pytest.fixture(scope="module")
def wheel(built: Path) -> Path:
    (path,) = built.glob("*.whl")
    return path


@pytest.fixture(scope="module")
def installed(folder: Path, wheel: Path) -> Path:
    """`bin` of an environment that holds the wheel and what the wheel asks for."""
    venv = folder / "venv"
    if ALONE:
        quietly([sys.executable, "-m", "venv", str(venv)], cwd=folder)
        quietly([str(venv / "bin" / "pip"), "install", "--quiet", str(wheel)], cwd=folder)
        return venv / "bin"
    quietly([sys.executable, "-m", "venv", "--without-pip", str(venv)], cwd=folder)
    pip = [sys.executable, "-m", "pip", "--python", str(venv / "bin" / "python")]
    quietly([*pip, "install", "--quiet", "--no-deps", str(wheel)], cwd=folder)
    (site,) = venv.glob("lib/python*/site-packages")
    (site / "lent.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return venv / "bin"


def quietly(command: list[str], *, cwd: Path) -> None:
    """Run a step of the set-up; its output is shown if it fails."""
    env = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "VIRTUAL_ENV"))}
    done = subprocess.run(command, cwd=cwd, env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]


def alone(folder: Path, *command: str, **env: str) -> subprocess.CompletedProcess[str]:
    """Run in `/` with nothing of this checkout, or of the user, in sight but machine code kept."""
    clean = {"PATH": "/usr/bin:/bin", "HOME": str(folder), "LANG": "C.UTF-8", **env}
    if not ALONE:
        clean["XDG_CACHE_HOME"] = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return subprocess.run(command, cwd="/", env=clean, capture_output=True, text=True, timeout=300)


def names_in(wheel: Path) -> list[PurePosixPath]:
    with ZipFile(wheel) as archive:
        return [PurePosixPath(name) for name in archive.namelist()]


def test_it_owns_three_names_and_no_more(wheel: Path) -> None:
    top = {name.parts[0] for name in names_in(wheel)}
    info = [name for name in top if name.endswith(".dist-info")]
    assert len(info) == 1
    assert top == {*PACKAGES, *info}


def test_it_holds_the_packages_whole_and_typed(wheel: Path) -> None:
    inside = {str(name) for name in names_in(wheel)}
    modules = {
        str(p.relative_to(ROOT)) for package in PACKAGES for p in (ROOT / package).rglob("*.py")
    }
    assert modules <= inside
    assert {f"{package}/py.typed" for package in PACKAGES} <= inside


def test_it_holds_the_models_and_nothing_left_behind(wheel: Path) -> None:
    inside = names_in(wheel)
    models = {str(p.relative_to(ROOT / "models")) for p in (ROOT / "models").rglob("*.xml")}
    shipped = {
        str(n.relative_to("twin/_models")) for n in inside if n.is_relative_to("twin/_models")
    }
    assert models
    assert models <= shipped
    strays = [str(n) for n in inside if n.suffix in (".pyc", ".TXT", ".rrd", ".parquet")]
    assert strays + [str(n) for n in inside if {"tests", "__pycache__"} & set(n.parts)] == []


def test_it_is_not_large(wheel: Path) -> None:
    assert wheel.stat().st_size < LARGEST_BYTES


def test_the_source_distribution_can_be_tested(built: Path) -> None:
    (path,) = built.glob("*.tar.gz")
    with tarfile.open(path) as archive:
        inside = {PurePosixPath(*PurePosixPath(n).parts[1:]) for n in archive.getnames()}
    needed = ("pyproject.toml", "README.md", "CHANGELOG.md", "LICENSE", "tests/test_wheel.py")
    assert {PurePosixPath(n) for n in (*needed, "examples/t7165s.toml")} <= inside


def test_it_asks_for_what_it_imports(wheel: Path) -> None:
    with ZipFile(wheel) as archive:
        (metadata,) = (n for n in archive.namelist() if n.endswith(".dist-info/METADATA"))
        asked = re.findall(
            r"^Requires-Dist: ([\w.-]+)(?!.*extra)", archive.read(metadata).decode(), re.M
        )
        texts = [archive.read(n).decode() for n in archive.namelist() if n.endswith(".py")]
    imported = {name for text in texts for name in top_level(text)}
    brought_by = packages_distributions()
    foreign = imported - {*sys.stdlib_module_names, *PACKAGES, *BROUGHT}
    assert {name for name in foreign if not {*brought_by.get(name, ())} & {*asked}} == set()
    assert foreign > {"mujoco", "numpy"}


def top_level(text: str) -> set[str]:
    """The packages that a source imports anywhere."""
    names = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            names |= {name.name for name in node.names}
        elif isinstance(node, ast.ImportFrom):
            names.add(str(node.module))
    return {name.partition(".")[0] for name in names}


@pytest.mark.parametrize("package", PACKAGES)
def test_what_runs_is_the_installed_one(folder: Path, installed: Path, package: str) -> None:
    program = f"import {package}; print({package}.__file__)"
    where = alone(folder, str(installed / "python"), "-c", program).stdout
    assert where.startswith(str(folder / "venv"))


@pytest.mark.parametrize("words", [["--help"], ["list"], ["--version"]])
def test_it_answers_at_once_and_imports_nothing_heavy(
    folder: Path, installed: Path, words: list[str]
) -> None:
    command = [str(installed / "twin"), *words]
    done = alone(folder, *command, PYTHONPROFILEIMPORTTIME="1")
    assert done.returncode == 0, done.stderr
    assert done.stdout
    imported = {line.rpartition("|")[2].split(".")[0].strip() for line in done.stderr.splitlines()}
    assert "twin" in imported
    assert imported & set(HEAVY) == set()
    assert min(seconds(folder, command) for _ in range(3)) < 1.0


def seconds(folder: Path, command: list[str]) -> float:
    """What the processor needs for it, whatever else it does meanwhile."""
    before = os.times()
    alone(folder, *command)
    after = os.times()
    return (
        after.children_user + after.children_system - before.children_user - before.children_system
    )


def test_it_ploughs(folder: Path, installed: Path, tmp_path: Path) -> None:
    out = tmp_path / "ploughed"  # where every recording is verified
    words = ("run", "plough-25cm", "--course.length-m", "10", "--out", str(out))
    before = set(os.listdir("/"))
    done = alone(folder, str(installed / "twin"), *words)
    assert (done.returncode, done.stderr) == (0, "")
    assert "four-state" in done.stdout
    files = {path.name for path in out.iterdir()}
    assert files >= {"scenario.json", "streams", "truth.parquet", "estimates.parquet"}
    assert files >= {"scores.json", "report.html", "run.rrd"}
    assert set(os.listdir("/")) <= before
