"""What answers at once loads nothing heavy."""

from __future__ import annotations

import subprocess
import sys

import pytest

LOADED = """
import sys
from twin import cli
status = cli.main(sys.argv[1:])
print(status, *sorted({name.partition(".")[0] for name in sys.modules}), file=sys.stderr)
"""
NEVER = {"numba", "mujoco", "scipy", "matplotlib", "pyarrow", "rerun", "cv2", "gymnasium", "joblib"}
TYPED = {"tyro", "rich"}


@pytest.mark.parametrize(
    ("args", "status", "unwanted"),
    [
        ("", 2, {*TYPED, "numpy"}),
        ("--help", 0, {*TYPED, "numpy"}),
        ("lst", 2, {*TYPED, "numpy"}),
        ("list", 0, TYPED),
        ("run plough-25", 2, {*TYPED, "numpy"}),
        ("run plough-25cm --soil.frction 0.5", 2, TYPED),
        ("run plough-25cm --soil.friction x", 2, set()),
        ("run plough-25cm --estimators rat", 2, set()),
        ("estimate nothing.csv", 2, {"numpy"}),
        ("study plough-25", 2, {"numpy"}),
        ("reproduce im", 2, {"numpy"}),
        ("rig whel", 2, set()),
        ("rig wheel --bogus", 2, set()),
        ("view nowhere", 2, {"numpy"}),
        ("bench --bogus", 2, {"numpy"}),
    ],
)
def test_what_answers_at_once_loads_nothing_heavy(
    args: str, status: int, unwanted: set[str]
) -> None:
    command = [sys.executable, "-c", LOADED, *args.split()]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    told, *loaded = done.stderr.splitlines()[-1].split()
    assert int(told) == status
    assert not (NEVER | unwanted) & set(loaded)
