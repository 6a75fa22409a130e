"""`twin study SCENARIOS`: many runs, each kept as it ends, their means with intervals."""

from __future__ import annotations

import dataclasses
import json
import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from twin.commands.output import Output, check_files, deliver
from twin.commands.parse import parse
from twin.commands.terminal import console, progress
from twin.errors import BadInput, check_range
from twin.pipeline import named as registry
from twin.studies.study import PARTS, PLAN, SUMMARY, TABLE, begin, finished

if TYPE_CHECKING:
    from twin.studies.study import Study as Done
    from twin.studies.summary import Group

REPORT = "report.html"
INTERRUPTED = 130
SHOWN = {
    "slip.rmse": ("slip RMSE [%]", 100.0),
    "slip.mae": ("MAE [%]", 100.0),
    "slip.max": ("max [%]", 100.0),
    "slip.bias": ("bias [%]", 100.0),
    "sideslip_angle_rad.rmse": ("angle RMSE [°]", 57.29577951308232),
    "sideslip_m.rel_err": ("sideslip error [%]", 100.0),
}
"""Quantity -> heading on the terminal, and its scale."""
EARLY_SHOWN = 20
"""So many runs that were not driven as planned are named on the terminal."""
DRAWN = {"slip.rmse": "RMSE of slip", "sideslip_angle_rad.rmse": "RMSE of sideslip angle [rad]"}


@dataclass(frozen=True, kw_only=True)
class Study(Output):
    """Run scenarios x sweeps x seeds, every estimator on each run; a killed study goes on."""

    estimators: str = "ratio,four-state"
    """Names, or module:Name of your own, separated by commas."""
    seeds: int = 10
    """How many seeds, the same for every scenario and sweep."""
    first_seed: int = 0
    """The first of them."""
    sweep: Annotated[tuple[str, ...], tyro.conf.UseAppendAction] = ()
    """FIELD=V1,V2,...: a field of the scenarios and the values it takes; may be given several
    times, for every combination."""
    out: Path | None = None
    """Folder of the study; studies/<names> by default."""
    jobs: int = -1
    """Processes; -1 for as many as the backend has."""
    backend: str = "loky"
    """Where the runs run, as joblib calls it: loky (here), ray, dask."""
    backend_option: Annotated[tuple[str, ...], tyro.conf.UseAppendAction] = ()
    """NAME=VALUE for the backend; may be given several times."""
    against: str | None = None
    """An estimator that the others are compared with, seed by seed."""
    retry_failed: bool = False
    """Do the runs again that ended in an error."""


def main(args: Sequence[str]) -> int:
    """Do what is missing of a study, then its table, summary and figures."""
    names, rest = _split(args)
    options = parse(Study, rest, prog="twin study SCENARIOS")
    for text in options.backend_option:
        if "=" not in text.strip("="):
            raise BadInput(f"--backend-option {text} is not NAME=VALUE")
    check_range("seeds", options.seeds, 1, 1_000_000)
    check_range("first_seed", options.first_seed, 0, 2**31 - options.seeds)
    if options.jobs == 0:
        raise BadInput("jobs = 0 would do nothing; 1, or -1 for as many as the backend has")
    check_files(json=options.json)
    from twin import studies as study

    estimators = _listed("--estimators", options.estimators)
    if options.against is not None and options.against not in estimators:
        raise BadInput(f"--against {options.against} is not among --estimators")
    sweeps = read_sweeps(options.sweep, registry.load("scenario", names[0]))
    seeds = range(options.first_seed, options.first_seed + options.seeds)
    cases = study.plan(names, seeds, estimators, sweeps)
    if options.talks:
        for text in study.left_out(names, sweeps):
            console().print(f"left out: {text}", style="dim", highlight=False, markup=False)
    plain = "+".join(re.sub(r"[:/\\]+", "-", name).strip("-") for name in names)
    folder = options.out or Path("studies") / plain
    begin(folder, list(args))
    try:
        with progress(f"{len(cases)} runs", shown=options.talks) as told:
            _work(cases, folder, options, told)
    except KeyboardInterrupt:
        left = len(study.missing(cases, folder / PARTS))
        done = f"{len(cases) - left} of {len(cases)} runs are in {folder}"
        console(stderr=True).print(f"twin: interrupted; {done}, the same command does the rest")
        return INTERRUPTED
    _finish(cases, folder, list(sweeps), options)
    return 0


def read_sweeps(given: Sequence[str], scenario: Any) -> dict[str, tuple[Any, ...]]:
    """`soil.friction=0.6,0.8` as path and values, read as that field of the scenario is.

    Raises:
        BadInput: no FIELD=VALUES, a field given twice, or a value the field cannot have.
        UnknownName: no such field.
    """
    from twin.scenario import fields

    found: dict[str, tuple[Any, ...]] = {}
    for text in given:
        left, equals, right = text.partition("=")
        if not equals or not left.strip() or not right.strip():
            raise BadInput(f"--sweep {text} is not FIELD=V1,V2,... (soil.friction=0.6,0.8)")
        path = fields.spelled(left)
        if path in ("seed", "name", "about"):
            raise BadInput(f"--sweep {text}: {path} cannot be swept; --seeds takes the seeds")
        if path in found:
            raise BadInput(f"--sweep {path} is given twice")
        kind = fields.kind(scenario, path)
        found[path] = tuple(_value(path, kind, each) for each in _listed("--sweep", right))
    return found


def _value(path: str, kind: Any, text: str) -> Any:
    """A value as the command line of `twin run` reads it."""
    annotation = Annotated[kind, tyro.conf.arg(name=path)]
    holder = dataclasses.make_dataclass("Swept", [("value", annotation)], frozen=True)
    read: Any = parse(holder, [f"--{path}", *shlex.split(text)], prog="twin study")
    return read.value


def _listed(option: str, text: str) -> list[str]:
    values = [each.strip() for each in text.split(",") if each.strip()]
    if not values:
        raise BadInput(f"{option} names none")
    return values


def _split(args: Sequence[str]) -> tuple[list[str], Sequence[str]]:
    if args and args[0] in ("-h", "--help"):
        parse(Study, ["--help"], prog="twin study SCENARIOS")
    if not args or args[0].startswith("-"):
        known = ", ".join(registry.names("scenario"))
        raise BadInput(f"twin study needs scenarios first, as a,b; there are: {known}")
    return _listed("twin study", args[0]), args[1:]


def _work(cases: Sequence[Any], folder: Path, options: Study, told: Any) -> None:
    from twin import studies as study

    if options.retry_failed:
        for path in study.failed(cases, folder / PARTS):
            path.unlink()
    pairs = [text.partition("=") for text in options.backend_option]
    study.work(
        cases,
        folder / PARTS,
        jobs=options.jobs,
        backend=options.backend,
        options={name: value for name, _, value in pairs},
        progress=told,
    )


def _finish(cases: Sequence[Any], folder: Path, swept: list[str], options: Study) -> None:
    done = finished(cases, folder, swept, options.against)
    deliver(done.summary, options.json)
    early = done.not_driven
    drawn = [*_draw(done.groups, folder), *_report(done, options.against)]
    if not options.talks:
        return
    print_means(done.groups)
    failed = [row for row in done.table.to_pylist() if row["error"] is not None]
    for text in dict.fromkeys(f"{r['scenario']}, {r['estimator']}: {r['error']}" for r in failed):
        console().print(f"failed: {text}", style="dim", highlight=False, markup=False)
    for text in early[:EARLY_SHOWN]:
        console().print(f"not driven: {text}", style="red", highlight=False, markup=False)
    if len(early) > EARLY_SHOWN:
        console().print(f"and {len(early) - EARLY_SHOWN} more, in {TABLE}", style="red")
    files = ", ".join(str(folder / name) for name in (TABLE, SUMMARY, *drawn))
    console().print(f"{len(cases)} runs; {files}", highlight=False)


def _report(done: Done, against: str | None) -> list[str]:
    """The page of the scores that are shown, and of their paired differences."""
    from twin.report import rows

    folder = done.folder
    shown = [
        _scaled(row, f"{heading}{less}", scale)
        for quantity, (heading, scale) in SHOWN.items()
        for less in ("", f" less that of {against}")
        for row in done.summary
        if row["quantity"] == f"{quantity}{less}"
    ]
    if not (shown or done.not_driven):
        return []
    about = f"Means of {len(done.cases)} runs over the seeds, and their 95 % intervals."
    asked = json.loads((folder / PLAN).read_text())["twin study"]
    command = f"twin study {shlex.join(asked)}"
    title = f"Study: {folder.name}"
    rows.write_intervals(folder / REPORT, title, about, shown, command, not_driven=done.not_driven)
    return [REPORT]


def _scaled(row: Mapping[str, Any], heading: str, scale: float) -> dict[str, Any]:
    """A row in the unit of its heading."""
    values = {key: scale * row[key] for key in ("ours", "low", "high") if key in row}
    return {**row, **values, "quantity": heading, "unit": "1"}


def _draw(groups: Sequence[Group], folder: Path) -> list[str]:
    from twin.studies import figures

    names = {quantity: quantity.replace(".", "_") + ".png" for quantity in DRAWN}
    return [
        name
        for quantity, name in names.items()
        if figures.draw(groups, quantity, folder / name, label=DRAWN[quantity])
    ]


def print_means(groups: Sequence[Group]) -> None:
    """A line for each setting and estimator: mean ± half the 95 % interval."""
    from rich import box
    from rich.table import Table

    from twin.studies.summary import mean

    shown = [q for q in SHOWN if any(group.values(q) for group in groups)]
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, title="mean ± half the 95 % interval")
    for heading in ("setting", "estimator"):
        table.add_column(heading)
    for heading in (
        "runs",
        "failed",
        "not driven",
        *(SHOWN[q][0].replace("[", r"\[") for q in shown),
    ):
        table.add_column(heading, justify="right")
    for group in groups:
        means = {q: mean(group.values(q).values()) for q in shown}
        cells = [_cell(means[q], SHOWN[q][1]) for q in shown]
        counts = (str(len(group.rows)), str(group.failed or ""), str(group.not_driven or ""))
        table.add_row(group.setting, group.estimator, *counts, *cells)
    console().print(table)


def _cell(found: Any, scale: float) -> str:
    if found.n == 0:
        return "-"
    half = "" if found.n == 1 else f" ± {scale * (found.high - found.mean):.3f}"
    return f"{scale * found.mean:.3f}{half}"
