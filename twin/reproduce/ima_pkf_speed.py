"""How fast the adaptive filters are: a search, an update, and the paper's hundred trials."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from scenarios.ima_pkf import CLEAN
from twin import studies as study
from twin.io.result_rows import Rows, row
from twin.pipeline.estimating import Estimator
from twin.pipeline.named import load
from twin.streams import Streams

METHODS = (
    "ratio", "ratio-front", "kf-z2", "pkf", "kf-tuned", "mmae", "whiteness",
    "pso-pkf", "ma-pkf", "ima-pkf",
)  # fmt: skip
ADAPTIVE = ("pso-pkf", "ma-pkf", "ima-pkf")
TRIALS, JOBS = 100, 2
TURNS, SAMPLES = 60, 450
"""Stretches of 3 s of signals: short enough to fall between the machine's other work."""


def rows() -> Rows:
    """Shortest times of many turns, and the wall time of one study, everything compiled before."""
    return [*filter_rows(), *study_rows()]


def filter_rows() -> Rows:
    """Time of an update of both observers, and of a search for both by what it adds to a run."""
    setup, streams, truth = CLEAN.measure()
    start = next(iter(streams.chunks(SAMPLES)))
    adaptive = {name: load("estimator", name) for name in ADAPTIVE}
    fixed = replace(adaptive["ima-pkf"], optimiser="none")

    def taking(estimator: Estimator, chunk: Streams) -> Callable[[], object]:
        state = estimator.init(setup)
        return lambda: estimator.run(state, chunk)

    whole_us, plain_us, short_us, *adaptive_us = _best(
        taking(fixed, streams),
        taking(load("estimator", "pkf"), streams),
        taking(fixed, start),
        *(taking(estimator, start) for estimator in adaptive.values()),
    )
    steps, case = len(truth["epoch_ns"]), "parallel Kalman filter at 50 Hz, streams read"
    out = [
        row(case, "update of both observers", whole_us / steps, "us", high=3.0),
        row(case, "the same, pkf", plain_us / steps, "us", high=3.0),
    ]
    for (name, estimator), taken_us in zip(adaptive.items(), adaptive_us, strict=True):
        searches = len(start["wheels"]["epoch_ns"]) // estimator.every
        search_ms = (taken_us - short_us) / searches * 1e-3
        out.append(row(case, f"adaptation of both observers, {name}", search_ms, "ms", high=1.0))
    return out


def study_rows(trials: int = TRIALS) -> Rows:
    """Wall time of the disturbed trials, every method, in two processes, parts written."""
    with tempfile.TemporaryDirectory() as folder:
        study.work(_cases(range(1)), Path(folder) / "compiled", jobs=JOBS)
        start = time.perf_counter()
        study.work(_cases(range(trials)), Path(folder) / "parts", jobs=JOBS)
        wall_s = time.perf_counter() - start
    case = f"ima-pkf-disturbed, {trials} seeds, {len(METHODS)} estimators, {JOBS} processes"
    return [row(case, "wall time of the study", wall_s, "s", high=90.0)]


def _cases(seeds: range) -> list[study.Case]:
    return study.plan(["ima-pkf-disturbed"], seeds, METHODS, {})


def _best(*actions: Callable[[], object]) -> list[float]:
    """Shortest time of each action [us], the actions taken in turn."""
    best = [float("inf")] * len(actions)
    for turn in range(TURNS + 1):
        for i, action in enumerate(actions):
            start = time.perf_counter()
            action()
            if turn > 0:  # the first one compiles
                best[i] = min(best[i], (time.perf_counter() - start) * 1e6)
    return best
