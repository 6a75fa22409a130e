"""One run of a study, from the scenario to a Parquet file with a row for each estimator.

An error is kept in the rows: that of a run in all its rows, that of an estimator in its own. A run
that was not driven as planned is no failure: its rows say how it ended, with the scores there are.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from twin.errors import TwinError
from twin.io.atomic import written_when_complete
from twin.io.plain import Plain
from twin.pipeline import named as registry
from twin.pipeline.estimating import estimates
from twin.pipeline.scored import bound
from twin.plugins.lookup import Thing, line
from twin.scores import scores
from twin.studies.plan import Case

if TYPE_CHECKING:
    from twin.pipeline.result import Result

Row = dict[str, Plain]


def write(case: Case, folder: Path) -> None:
    """Do a run and write its part, which appears under its name only when whole."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pa.Table.from_pylist(rows(case))
    with written_when_complete(folder / case.part) as partial:
        pq.write_table(table, partial, compression="zstd")


def rows(case: Case) -> list[Row]:
    """A row for each estimator: what was run, `error`, `ended`, `truth.*`, its scores, `bound.*`.

    `ended` is how the run ended in words, `as_planned` whether that is the end of its course.
    """
    from twin.pipeline.run import run

    head = {"scenario": case.scenario, "seed": case.run.seed, **dict(case.swept)}
    try:
        done = run(case.run, estimators={})
    except Exception as error:  # whatever a user's scenario or soil law raises
        failed = head | {"error": _said(error), "ended": None, "as_planned": None}
        return [failed | {"estimator": name} for name in case.estimators]
    bounds = _bounds(case, done)
    return [
        head | {"estimator": name} | _estimated(case, name, done) | bounds
        for name in case.estimators
    ]


def _bounds(case: Case, done: Result) -> Row:
    """`bound.*`: the smallest errors that the sensors and the motion allow, where there are any."""
    if scores.why_unscored(done.truth, case.run, done.end) is not None:
        return {}
    window = scores.scored_window_s(done.truth, case.run)
    try:
        return flat({"bound": bound(done, done.truth, window) or {}})
    except Exception:  # a user's streams may be of a kind that the bound does not know
        return {}


def _estimated(case: Case, name: str, done: Result) -> Row:
    planned = done.end is None or done.end.as_planned
    head: Row = {"error": None, "ended": done.ended, "as_planned": planned}
    if scores.why_unscored(done.truth, case.run, done.end) is not None:
        return head
    window = scores.scored_window_s(done.truth, case.run)
    head |= flat({"truth": scores.truth_summary(done.truth, window)})
    try:
        estimator = seeded(registry.load("estimator", name), case.run.seed)
        table = estimates(name, estimator, done.setup, done.streams)
        found = flat(scores.estimator_scores(done.truth, table, window))
    except Exception as error:  # whatever a user's estimator raises
        return head | {"error": _said(error)}
    return head | found


def seeded(estimator: Thing, seed: int) -> Thing:
    """The estimator with the run's seed, if it has chance of its own."""
    chance = dataclasses.is_dataclass(estimator) and hasattr(estimator, "seed")
    return dataclasses.replace(estimator, seed=seed) if chance else estimator


def flat(tree: Mapping[str, Plain]) -> Row:
    """`{"slip": {"rmse": x}}` as `{"slip.rmse": x}`; counts become plain numbers."""
    out: Row = {}
    for name, value in tree.items():
        if isinstance(value, Mapping):
            out |= {f"{name}.{inner}": each for inner, each in flat(value).items()}
        else:
            out[name] = value if value is None else float(value)
    return out


def _said(error: Exception) -> str:
    return " ".join(str(error).split()) if isinstance(error, TwinError) else line(error)
