"""A study as one call: do its missing runs, then write its table and summary."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from twin.errors import BadInput
from twin.io.plain import Plain
from twin.pipeline.public import DEFAULT_ESTIMATORS

if TYPE_CHECKING:
    import pyarrow as pa

    from twin.studies.plan import Case
    from twin.studies.summary import Group

PARTS, TABLE, SUMMARY, PLAN = "parts", "table.parquet", "summary.json", "study.json"


@dataclass(frozen=True, kw_only=True)
class Study:
    """The result of a study."""

    folder: Path
    cases: Sequence[Case]
    table: pa.Table
    """A row for each run and estimator."""
    groups: Sequence[Group]
    """Rows of one setting and estimator, over the seeds."""
    summary: Sequence[Mapping[str, Plain]]
    """Means with 95 % intervals, as rows of results."""
    not_driven: Sequence[str] = ()
    """Runs that were not driven as planned, in words."""


def study(
    scenarios: Iterable[str],
    estimators: Iterable[str] = DEFAULT_ESTIMATORS,
    *,
    out: Path | str,
    seeds: Iterable[int] = range(10),
    sweeps: Mapping[str, Sequence[Plain]] | None = None,
    against: str | None = None,
    jobs: int = -1,
    backend: str = "loky",
    options: Mapping[str, Plain] | None = None,
    retry_failed: bool = False,
    asked: Plain = None,
    progress: Callable[[float], None] = lambda share: None,
) -> Study:
    """Scenarios x sweeps x seeds, every estimator on each; a stopped study can be continued.

    There is an argument for each option of `twin study`, which is this function's command line.

    Args:
        scenarios, estimators: names, or `module:Name` of your own.
        out: folder of the study; what is done there is not done again.
        seeds: of the runs; every scenario and every combination of swept values has the same.
        sweeps: field by dotted path -> the values it takes.
        against: an estimator that the others are compared with, seed by seed.
        jobs: processes; -1 for as many as the backend has.
        backend, options: name of a joblib backend, and its keyword arguments.
        retry_failed: repeat the runs that failed.
        asked: what `study.json` keeps; the arguments above where None.
        progress: called with the share of the runs done.

    Raises:
        UnknownName: there is no such scenario, estimator or field.
        BadInput, OutOfRange: a field cannot be swept or cannot have a value, all combinations are
            left out, `against` is none of the estimators, or the folder is not a study's.
        NoSpace: the disk is full.

    Example:
        >>> done = twin.study(["plough-25cm"], ["ratio"], out="studies/one")  # doctest: +SKIP
    """
    from twin.studies.plan import plan
    from twin.studies.table import failed
    from twin.studies.work import work

    swept, folder = dict(sweeps or {}), Path(out)
    names, runs, chosen = list(scenarios), list(seeds), list(estimators)
    if against is not None and against not in chosen:
        raise BadInput(f"against = {against} is none of the estimators {', '.join(chosen)}")
    cases = plan(names, runs, chosen, swept)
    arguments = {"scenarios": names, "seeds": runs, "estimators": chosen, "against": against}
    begin(folder, asked or {**arguments, "sweeps": {k: list(v) for k, v in swept.items()}})
    if retry_failed:
        for path in failed(cases, folder / PARTS):
            path.unlink()
    work(
        cases, folder / PARTS, jobs=jobs, backend=backend, options=dict(options or {}),
        progress=progress,
    )  # fmt: skip
    return finished(cases, folder, list(swept), against)


def begin(folder: Path, asked: Plain) -> None:
    """Make the folder, or see that it is a study's, and write down what was asked.

    Raises:
        NoSpace, BadInput: it is another folder, or cannot be written.
    """
    import json

    from twin.io.atomic import made, refusal, write_text

    ours = (folder / PLAN).exists() or not folder.exists() or not any(folder.iterdir())
    if not ours:
        raise BadInput(f"{folder} exists and is not a study's folder; choose another --out")
    try:
        with made(folder / PARTS):
            write_text(folder / PLAN, json.dumps({"twin study": asked}) + "\n")
    except OSError as error:
        raise refusal(folder, error) from None


def finished(
    cases: Sequence[Case], folder: Path, swept: Sequence[str], against: str | None
) -> Study:
    """Read all parts of a study, and write its table and its summary."""
    from twin.io import result_rows
    from twin.studies.summary import early_ends, groups, quantities
    from twin.studies.summary import rows as summary_rows
    from twin.studies.table import read, write_table

    table = read(cases, folder / PARTS)
    write_table(table, folder / TABLE)
    rows = table.to_pylist()
    grouped = groups(rows, swept)
    summary = summary_rows(grouped, quantities(rows, swept), against)
    result_rows.write(summary, folder / SUMMARY)
    return Study(
        folder=folder,
        cases=cases,
        table=table,
        groups=grouped,
        summary=summary,
        not_driven=early_ends(rows, swept),
    )
