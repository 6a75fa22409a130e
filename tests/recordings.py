"""Whether recordings are whole, by rerun's own verification."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path


def broken(recordings: Sequence[Path]) -> list[str]:
    """Those that are not whole, each with what rerun says of it; one call where all are."""
    if not recordings:
        return []
    said = _verified(recordings)
    if said.startswith(f"{len(recordings)} file"):  # the count: what is too short is passed over
        return []
    if len(recordings) == 1:
        return [f"{recordings[0]}: {said}"]
    return [line for recording in recordings for line in broken([recording])]


def _verified(recordings: Sequence[Path]) -> str:
    command = [sys.executable, "-m", "rerun", "rrd", "verify", *map(str, recordings)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    said = (done.stdout + done.stderr).strip()
    return said if done.returncode == 0 else f"not whole: {said}"
