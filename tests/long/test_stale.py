"""A whole run after an edit of what compiled code reads: warm and cold caches give the same."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROGRAM = """
from dataclasses import replace
import numpy as np
from twin.pipeline.named import load
from twin.pipeline.run import run
scenario = load("scenario", "slope-9-dry")
short = replace(scenario, course=replace(scenario.course, length_m=4.0, calibration_m=5.0))
names = ("ratio", "four-state", "sideslip-ekf")
result = run(short, estimators={n: load("estimator", n) for n in names})
tables = {"truth": result.truth, "camera": result.streams["camera"], **result.estimates}
for name, table in sorted(tables.items()):
    for column, values in sorted(table.items()):
        if np.issubdtype(values.dtype, np.number):
            print(name, column, repr(float(np.nansum(np.asarray(values, float)))))
"""
STREAMS, BLOCK = "twin/streams.py", "twin/physics/block.py"
PLACES = {
    "order of columns": (STREAMS, '"v_east_mps", "v_north_mps"', '"v_north_mps", "v_east_mps"'),
    "order of sensors": (STREAMS, '    "gnss": (\n', '    "odometer": (),\n    "gnss": (\n'),
    "place in the block": (BLOCK, "DAMPING_S = 4\n    SIZE = 5", "DAMPING_S = 5\n    SIZE = 6"),
}
"""Which what writes and what reads must agree on, and which change nothing else."""
CONSTANTS = {
    "law's constant": ("twin/physics/brixius.py", "-0.1 * bn", "-0.05 * bn"),
    "picture's constant": ("twin/camera/chance.py", "0x8DA6B343", "0x8DA6B345"),
}
"""On which results depend."""
EDITS = PLACES | CONSTANTS


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("checkout")
    for name in ("twin", "scenarios", "estimators", "models"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


@pytest.fixture(scope="module")
def warm(checkout: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cache that holds what the unedited sources need."""
    cache = tmp_path_factory.mktemp("warm")
    assert told(checkout, cache) == told(checkout, cache)
    return cache


def told(checkout: Path, cache: Path) -> str:
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], cwd=checkout, capture_output=True, text=True, check=True,
        env=os.environ | {"XDG_CACHE_HOME": str(cache), "PYTHONPATH": str(checkout),
                          "PYTHONDONTWRITEBYTECODE": "1"},
    )  # fmt: skip
    return done.stdout


@pytest.mark.parametrize("edit", EDITS)
def test_an_edit_runs_at_once(edit: str, checkout: Path, warm: Path, tmp_path: Path) -> None:
    before = told(checkout, warm)
    file, old, new = EDITS[edit]
    text = (checkout / file).read_text()
    assert text.count(old) == 1
    (checkout / file).write_text(text.replace(old, new))
    from_warm, from_cold = told(checkout, warm), told(checkout, tmp_path)
    (checkout / file).write_text(text)
    assert from_warm == from_cold
    assert (from_warm != before) == (edit in CONSTANTS)
