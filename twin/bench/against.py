"""What `twin bench --against DIR` measures: CPU time of this checkout over that of another.

Each command runs in a process of its own, alternately in one checkout and in the other, because
the speed of a computer changes with time. The CPU time is that of the process and of all it
started. The case `step` compares ratios of wall times.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from twin.errors import BadInput, UnknownName
from twin.io.result_rows import Rows, row

ROOT = Path(__file__).parents[2]
"""This checkout."""
ESTIMATORS = "ratio,four-state"
DRIVE = """
import sys, time
from importlib import import_module
def found(name, *places):
    for place in places:
        try:
            return getattr(import_module(place), name)
        except (ImportError, AttributeError):
            pass
    sys.exit(f"{name} is in none of {places}")
"""
"""What programs for both checkouts begin with: modules have moved between folders."""
DRIVING = f"""{DRIVE}
load = found("load", "twin.pipeline.named", "twin.registry")
build = found("build", "twin.simulation.build", "twin.machine.build")
simulate = found("simulate", "twin.simulation.simulate", "twin.machine.simulate")
machine = build(load("scenario", "plough-25cm"))
next(simulate(machine))
start = time.process_time()
for chunk in simulate(machine): pass
print(time.process_time() - start)
"""
STEP = f"""{DRIVE}
rows = found("step_rows", "twin.bench.bench", "twin.bench")()
print(next(row["ours"] for row in rows if row["quantity"] == "ratio"))
"""


@dataclass(frozen=True)
class Checkout:
    """A checkout, and where its compiled functions are kept while it is measured."""

    root: Path
    cache: Path

    def run(self, command: Sequence[str], cache: Path | None = None) -> tuple[float, str]:
        """Run Python with arguments; its CPU time [s] and what it printed. Raises BadInput."""
        with tempfile.TemporaryDirectory() as place, tempfile.TemporaryFile("w+") as said:
            paths = {"PYTHONPATH": self.root, "XDG_CACHE_HOME": cache or self.cache}
            # pictures' fonts are listed once, or they would be the greater part of a short run
            fonts = {"MPLCONFIGDIR": self.cache.parent / "fonts"}
            settings = os.environ | {k: str(v) for k, v in (paths | fonts).items()}
            settings.pop("PYTHONDONTWRITEBYTECODE", None)  # or each command compiles all modules
            process = subprocess.Popen(
                [sys.executable, *command], cwd=place, env=settings, text=True, stdout=said,
                stderr=subprocess.STDOUT,
            )  # fmt: skip
            _, ended, used = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(ended)
            said.seek(0)
            printed = said.read()
        if process.returncode:
            last = (printed.strip().splitlines() or ["nothing was printed"])[-1]
            raise BadInput(f"{self.root}: python {' '.join(command)[:60]} fails: {last}")
        return used.ru_utime + used.ru_stime, printed


def _warm(*command: str) -> Callable[[Checkout], float]:
    return lambda checkout: checkout.run(("-m", "twin", *command))[0]


def _cold(checkout: Checkout, command: Sequence[str]) -> float:
    with tempfile.TemporaryDirectory() as cache:
        return checkout.run(("-m", "twin", *command), Path(cache))[0]


def _printed(program: str) -> Callable[[Checkout], float]:
    return lambda checkout: float(checkout.run(("-c", program))[1].split()[-1])


_LONG = ("run", "plough-25cm", "--quiet", "--estimators", ESTIMATORS, "--out", "made")
_SHORT = (*_LONG, "--course.length-m", "10")
CASES: Mapping[str, tuple[str, Callable[[Checkout], float]]] = {
    "list": ("twin list", _warm("list")),
    "short": ("plough-25cm, 10 m", _warm(*_SHORT)),
    "long": ("plough-25cm, 200 m", _warm(*_LONG)),
    "cold": ("plough-25cm, 10 m, nothing compiled", partial(_cold, command=_SHORT)),
    "driving": ("plough-25cm, 200 m, driving alone", _printed(DRIVING)),
    "step": ("physics step over one on MuJoCo's own contacts", _printed(STEP)),
}
"""Case -> what it is, and its measurement in a checkout."""


def rows(other: Path, cases: Collection[str] = (), rounds: int = 3) -> Rows:
    """Ratios of this checkout to another: median, least and greatest of the rounds.

    Args:
        other: the root of the other checkout.
        cases: names of CASES; all when empty.
        rounds: measurements of each case in each checkout; one more goes before and is left out,
            which compiles what the others find.

    Raises:
        UnknownName: there is no such case.
        BadInput: the folder is no checkout, or a command fails in it.
    """
    if not (other / "twin" / "__init__.py").is_file():
        raise BadInput(f"--against {other}: there is no twin/__init__.py; name a checkout's root")
    for case in cases:
        if case not in CASES:
            raise UnknownName("case", case, CASES)
    with tempfile.TemporaryDirectory() as made:
        places = [Path(made) / name for name in ("ours", "theirs")]
        pair = [Checkout(r.resolve(), p) for r, p in zip((ROOT, other), places, strict=True)]
        return [r for case in cases or CASES for r in _case(case, pair, rounds)]


def _case(case: str, pair: Sequence[Checkout], rounds: int) -> Rows:
    name, measure = CASES[case]
    if case != "cold":
        for checkout in pair:
            measure(checkout)
    measured = [[measure(checkout) for checkout in pair] for _ in range(rounds)]
    ratios = [ours / theirs for ours, theirs in measured]
    unit = "1" if case == "step" else "s"
    ours, theirs = (statistics.median(column) for column in zip(*measured, strict=True))
    return [
        row(name, "ours", ours, unit),
        row(name, "theirs", theirs, unit),
        row(name, "ratio, median", statistics.median(ratios), "1"),
        row(name, "ratio, least", min(ratios), "1"),
        row(name, "ratio, greatest", max(ratios), "1"),
    ]
