"""Every short script of examples/ runs, without a warning, and writes the figure it tells of."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LONG = ("train_slip_control.py",)
"""Learns for minutes, and needs the extra `rl`."""
SCRIPTS = sorted(
    path
    for path in (ROOT / "examples").glob("*.py")
    if "__main__" in path.read_text(encoding="utf-8") and path.name not in LONG
)


@pytest.mark.slow
@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.name)
def test_every_script_runs_and_writes_what_it_tells_of(script: Path, tmp_path: Path) -> None:
    ran = subprocess.run(
        [sys.executable, "-W", "error", str(script)],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert ran.returncode == 0, ran.stderr
    told = re.findall(r"^Writes (\S+\.png)\.$", script.read_text(encoding="utf-8"), re.MULTILINE)
    assert [path.name for path in tmp_path.iterdir()] == told
    assert (tmp_path / told[0]).stat().st_size > 10_000


def test_there_are_scripts() -> None:
    assert len(SCRIPTS) >= 2
    assert all((ROOT / "examples" / name).exists() for name in LONG)
