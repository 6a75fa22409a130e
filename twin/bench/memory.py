"""Peak memory of a program in a process of its own."""

from __future__ import annotations

import resource
import subprocess
import sys
from pathlib import Path

STATUS = Path("/proc/self/status")
PRINTED = """
from twin.bench.memory import own_peak_mb
print(own_peak_mb())
"""


def own_peak_mb() -> float:
    """Most memory that this process has held at once [MB].

    Linux: VmHWM. The rusage of a new process there begins at the memory of the one that started it.
    """
    if STATUS.exists():
        line = next(row for row in STATUS.read_text().splitlines() if row.startswith("VmHWM"))
        return float(line.split()[1]) * 1024.0 / 1e6
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / 1e6 if sys.platform == "darwin" else peak * 1024.0 / 1e6


def peak_mb(program: str, *arguments: str) -> float:
    """Most memory of a process of its own that runs a Python program [MB].

    Args:
        program: Python source.
        arguments: its `sys.argv[1:]`.
    """
    command = [sys.executable, "-c", program + PRINTED, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return float(done.stdout.split()[-1])
