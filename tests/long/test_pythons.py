"""The quick start under every Python at hand, in an environment of its own."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CLASSIFIED = re.findall(
    r'"Programming Language :: Python :: (3\.\d+)"', (ROOT / "pyproject.toml").read_text()
)


def at_hand(version: str) -> str | None:
    """The interpreter of a version, if there is one that starts."""
    roots = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    known = [shutil.which(f"python{version}"), *map(str, roots.glob(f"{version}.*/bin/python"))]
    for name in filter(None, known):
        done = subprocess.run([name, "--version"], capture_output=True, text=True, check=False)
        if done.stdout.startswith(f"Python {version}."):
            return name
    return None


@pytest.mark.parametrize("version", CLASSIFIED)
def test_the_quick_start_runs(version: str, tmp_path: Path) -> None:
    python = at_hand(version)
    if python is None:
        pytest.skip(f"there is no Python {version} here")
    home = tmp_path / "env"
    subprocess.run([python, "-m", "venv", home], check=True)
    source = tmp_path / "source"
    ignored = shutil.ignore_patterns(".git", ".venv", "runs", "site", "__pycache__", ".*_cache")
    shutil.copytree(ROOT, source, ignore=ignored)
    install = [home / "bin" / "pip", "install", "-q", source]
    subprocess.run(install, check=True, capture_output=True, text=True)
    command = [home / "bin" / "twin", "run", "plough-25cm", "--course.length-m", "8", "--quiet"]
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    done = subprocess.run(
        command, cwd=tmp_path, capture_output=True, text=True, check=False, env=environment
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "runs" / "plough-25cm-seed0" / "report.html").is_file()
