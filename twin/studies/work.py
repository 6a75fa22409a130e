"""Run the cases of a study that have no result yet, in parallel processes of joblib.

Each process writes its result to a file in the folder and returns nothing. On a cluster, all nodes
must therefore share that folder.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import joblib

from twin.compute.parallel import Counted
from twin.errors import BadInput, NoSpace
from twin.io.plain import Plain
from twin.plugins.lookup import attribute, line
from twin.studies import part
from twin.studies.plan import Case

LOCAL = "loky"
"""Name of joblib's backend of local processes."""
REGISTERED_BY = {"ray": "ray.util.joblib:register_ray"}
"""Backends that joblib knows only once their own package has registered them."""


def missing(cases: Sequence[Case], folder: Path) -> list[Case]:
    """Cases that have no result file in the folder."""
    there = {path.name for path in folder.glob("*.parquet")}
    return [case for case in cases if case.part not in there]


def work(
    cases: Sequence[Case],
    folder: Path,
    *,
    jobs: int = -1,
    backend: str = LOCAL,
    options: Mapping[str, Plain] | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> None:
    """Do the runs that have no part yet.

    Args:
        cases: the plan.
        folder: where the parts are; made if need be.
        jobs: processes; -1 for all that the backend has.
        backend: as joblib calls it: loky, multiprocessing, dask, ray, or one of the user's.
        options: what the backend takes besides.
        progress: called with the share of the plan that is done.

    Raises:
        NoSpace: the disk is full.
        BadInput: there is no such backend, it cannot be reached, or a worker was lost.
    """
    folder = folder.absolute()
    folder.mkdir(parents=True, exist_ok=True)
    todo = missing(cases, folder)
    done = len(cases) - len(todo)
    progress(done / max(len(cases), 1))
    if not todo:
        return
    workers = _workers(backend, jobs, options or {})
    parallel = Counted(n_jobs=jobs)
    parallel.report = lambda count: progress((done + count) / len(cases))
    try:
        with workers:
            parallel(joblib.delayed(part.write)(case, folder) for case in todo)
    except Exception as error:  # a run's own are rows; this is a full disk or a lost worker
        text = f"the study stopped: {line(error)}; the same command continues it"
        raise (NoSpace if isinstance(error, NoSpace) else BadInput)(text) from None
    for leftover in folder.glob(".*.parquet"):  # of runs that were killed while writing
        leftover.unlink(missing_ok=True)


def _workers(backend: str, jobs: int, options: Mapping[str, Plain]) -> Any:
    """joblib's context for a backend."""
    try:
        if backend in REGISTERED_BY:
            attribute("backend", REGISTERED_BY[backend])()
        return joblib.parallel_config(backend=backend, n_jobs=jobs, **options)
    except BadInput as error:
        raise BadInput(
            f"--backend {backend}: {error}; install it with: pip install {backend}"
        ) from None
    except Exception as error:  # whatever a backend raises when it cannot be had
        raise BadInput(f"--backend {backend} cannot be used: {line(error)}") from None
