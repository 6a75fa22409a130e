"""`twin study SCENARIOS`: do many runs and give means with intervals.

One module, because options, work and what is shown belong to one command.
"""

from __future__ import annotations

import dataclasses
import json
import re
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from twin.commands.output import Output, check_files, check_folder, deliver
from twin.commands.parse import parse
from twin.commands.run import DEFAULT_ESTIMATORS
from twin.commands.terminal import progress, say
from twin.errors import BadInput, check_range
from twin.io.plain import Plain
from twin.pipeline import named as registry
from twin.plugins.lookup import Thing
from twin.scores.table import COVERAGE

if TYPE_CHECKING:
    from twin.commands.tables import Column
    from twin.studies.study import Study as Done
    from twin.studies.summary import Group

REPORT = "report.html"
INTERRUPTED = 130
DEG = 57.29577951308232
SHOWN = {
    "slip.rmse": ("slip RMSE [%]", 100.0, 0),
    "slip.mae": ("MAE [%]", 100.0, 8),
    "slip.max": ("max [%]", 100.0, 7),
    "slip.bias": ("bias [%]", 100.0, 5),
    "slip.coverage_2sd": (COVERAGE, 100.0, 4),
    "bound.slip_causal": ("slip bound [%]", 100.0, 3),
    "sideslip_angle_rad.rmse": ("angle RMSE [°]", DEG, 1),
    "sideslip_m.rel_err": ("sideslip error [%]", 100.0, 6),
}
"""Quantity -> heading on the terminal, its scale, and its rank: the greatest is left out first."""
EARLY_SHOWN = 20
"""Most runs that are named on the terminal as not driven as planned."""
DRAWN = {
    "slip.rmse": ("RMSE of slip [%]", 100.0, "bound.slip_causal"),
    "sideslip_angle_rad.rmse": ("RMSE of sideslip angle [°]", DEG, "bound.sideslip_causal_rad"),
}
"""Quantity -> label, scale, and the quantity that bounds it."""
NO_DIFFERENCE = ("bound.slip_causal",)
"""What is the same for all estimators."""


@dataclass(frozen=True, kw_only=True)
class Study(Output):
    """Run scenarios x sweeps x seeds with every estimator. A stopped study can be continued."""

    estimators: str = DEFAULT_ESTIMATORS
    """Estimators, separated by commas: names, or module:Name of your own."""
    seeds: int = 10
    """Number of seeds. Every scenario and sweep has the same ones."""
    first_seed: int = 0
    """The first seed."""
    machine: str | None = None
    """The tractor of all scenarios: a name of `twin list`, or a file."""
    implement: str | None = None
    """The implement of all scenarios: a name of `twin list`, or a file."""
    sweep: Annotated[tuple[str, ...], tyro.conf.UseAppendAction] = ()
    """FIELD=V1,V2,...: a field of the scenarios and its values. Given several times, every
    combination is run."""
    out: Path | None = None
    """Folder of the study; by default studies/<names>."""
    jobs: int = -1
    """Number of processes; -1 for as many as the backend has."""
    backend: str = "loky"
    """Backend of joblib for the runs: loky (this computer), ray, dask."""
    backend_option: Annotated[tuple[str, ...], tyro.conf.UseAppendAction] = ()
    """Option NAME=VALUE of the backend; may be given several times."""
    against: str | None = None
    """Estimator to compare the others with, seed by seed."""
    retry_failed: bool = False
    """Repeat the runs that ended in an error."""
    figures: Path | None = None
    """Folder for the figures as SVG and PDF, as wide as a printed page's text (175 mm)."""


def main(args: Sequence[str]) -> int:
    """Do the missing runs of a study, then write its table, summary and figures."""
    names, rest = _split(args)
    _refuse_fields(names[0], rest)
    options = parse(Study, rest, prog="twin study SCENARIOS")
    for text in options.backend_option:
        if "=" not in text.strip("="):
            raise BadInput(f"--backend-option {text} is not NAME=VALUE")
    check_range("seeds", options.seeds, 1, 1_000_000)
    check_range("first_seed", options.first_seed, 0, 2**31 - options.seeds)
    if options.jobs == 0:
        raise BadInput(
            "jobs = 0 starts no process; give 1 or more, or -1 for all that the backend has"
        )
    check_files(json=options.json)
    check_folder("figures", options.figures)
    scenarios = [registry.load("scenario", name) for name in names]  # unknown ones refused first
    from twin import studies
    from twin.studies.study import PARTS, study

    estimators = _listed("--estimators", options.estimators)
    if options.against is not None and options.against not in estimators:
        raise BadInput(f"--against {options.against} is not among --estimators")
    own = ((n, getattr(options, n)) for n in ("machine", "implement"))
    fixed = [f"{name}={value}" for name, value in own if value is not None]
    sweeps = read_sweeps([*fixed, *options.sweep], scenarios[0])
    seeds = range(options.first_seed, options.first_seed + options.seeds)
    cases = studies.plan(names, seeds, estimators, sweeps)
    if options.talks:
        for text in studies.left_out(names, sweeps):
            say(f"left out: {text}", style="dim")
    plain = "+".join(re.sub(r"[:/\\]+", "-", name).strip("-") for name in names)
    folder = options.out or Path("studies") / plain
    backend_options = [text.partition("=") for text in options.backend_option]
    try:
        with progress(f"{len(cases)} runs", shown=options.talks) as report:
            done = study(
                names,
                estimators,
                out=folder,
                seeds=seeds,
                sweeps=sweeps,
                against=options.against,
                jobs=options.jobs,
                backend=options.backend,
                options={name: value for name, _, value in backend_options},
                retry_failed=options.retry_failed,
                asked=list(args),
                progress=report,
            )
    except KeyboardInterrupt:
        left = len(studies.missing(cases, folder / PARTS))
        there = f"{len(cases) - left} of {len(cases)} runs are in {folder}"
        say(f"twin: interrupted; {there}, the same command continues the study", stderr=True)
        return INTERRUPTED
    _finish(done, options)
    return 0


def _refuse_fields(name: str, args: Sequence[str]) -> None:
    """Refuse a field of the scenario that is given as `twin run` takes it: here it is swept."""
    own = {field.name for field in dataclasses.fields(Study)}
    for i, arg in enumerate(args):
        option, equals, said = arg.partition("=")
        path = option.removeprefix("--").replace("-", "_")
        if not option.startswith("--") or path in own or path == "help":
            continue
        from twin.scenario import fields  # heavy, and only for what is refused

        if path in {path for path, _ in fields.leaves(registry.load("scenario", name))}:
            after = args[i + 1] if i + 1 < len(args) and not args[i + 1].startswith("--") else "V"
            raise BadInput(
                f"{option} is no option of twin study; --sweep {path}={said if equals else after} "
                "would do"
            )


def read_sweeps(given: Sequence[str], scenario: Thing) -> dict[str, tuple[Any, ...]]:
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
        raise BadInput(f"{option} is empty; give at least one value")
    return values


def _split(args: Sequence[str]) -> tuple[list[str], Sequence[str]]:
    if args and args[0] in ("-h", "--help"):
        parse(Study, ["--help"], prog="twin study SCENARIOS")
    if not args or args[0].startswith("-"):
        known = ", ".join(registry.names("scenario"))
        raise BadInput(f"twin study needs scenarios first, as a,b; there are: {known}")
    return _listed("twin study", args[0]), args[1:]


def _finish(done: Done, options: Study) -> None:
    from twin.studies.study import SUMMARY, TABLE

    folder = done.folder
    deliver(done.summary, options.json)
    early = done.not_driven
    drawn = [*_draw(done.groups, folder, options.figures), *_report(done, options.against)]
    if not options.talks:
        return
    print_means(done.groups, options.against)
    failed = [row for row in done.table.to_pylist() if row["error"] is not None]
    for text in dict.fromkeys(f"{r['scenario']}, {r['estimator']}: {r['error']}" for r in failed):
        say(f"failed: {text}", style="dim")
    for text in early[:EARLY_SHOWN]:
        say(f"ended early: {text}", style="red")
    if len(early) > EARLY_SHOWN:
        say(f"and {len(early) - EARLY_SHOWN} more, in {TABLE}", style="red")
    files = ", ".join(str(folder / name) for name in (TABLE, SUMMARY, *drawn))
    say(f"{len(done.cases)} runs; {files}")


def _report(done: Done, against: str | None) -> list[str]:
    """The page of the scores that are shown, and of their paired differences."""
    from twin.report import rows
    from twin.report.palette import colours
    from twin.studies.study import PLAN

    folder = done.folder
    shown = [
        row
        for quantity in SHOWN
        for less in ("", f" less that of {against}")
        for row in _shown_rows(done, quantity, less)
    ]
    if not (shown or done.not_driven):
        return []
    about = f"Means of {len(done.cases)} runs over the seeds, and their 95 % intervals."
    asked = json.loads((folder / PLAN).read_text())["twin study"]
    command = f"twin study {shlex.join(asked)}"
    palette = colours(group.estimator for group in done.groups)
    rows.write_intervals(
        folder / REPORT,
        f"Study: {folder.name}",
        about,
        shown,
        command,
        not_driven=done.not_driven,
        colour_of={group.case: palette[group.estimator] for group in done.groups},
    )
    return [REPORT]


def _shown_rows(done: Done, quantity: str, less: str) -> list[dict[str, Plain]]:
    """Rows of the summary in the unit of their heading, with the bound where it is known."""
    heading, scale, _ = SHOWN[quantity]
    _, _, bound = DRAWN.get(quantity, ("", 1.0, ""))
    bounds = {row["case"]: row["ours"] for row in done.summary if row["quantity"] == bound}
    found = []
    for row in done.summary:
        if row["quantity"] != f"{quantity}{less}":
            continue
        values = {key: scale * row[key] for key in ("ours", "low", "high") if key in row}
        if not less and row["case"] in bounds:
            values["bound"] = scale * bounds[row["case"]]
        found.append({**row, **values, "quantity": f"{heading}{less}", "unit": "1"})
    return found


def _draw(groups: Sequence[Group], folder: Path, printed: Path | None) -> list[str]:
    """Write the figures of a study as PNG, and for print where asked; the names of the PNG."""
    from twin.io.atomic import moved_when_complete
    from twin.report.printed import write_png, write_print
    from twin.studies.figures import Drawn, picture

    found = {q.replace(".", "_"): picture(groups, q, Drawn(*how)) for q, how in DRAWN.items()}
    pictures = {name: each for name, each in found.items() if each is not None}
    with moved_when_complete(folder) as partial:
        for name, each in pictures.items():
            write_png(each, partial / f"{name}.png")
    if printed is not None:
        write_print(pictures, printed)
    return [f"{name}.png" for name in pictures]


def print_means(groups: Sequence[Group], against: str | None = None) -> None:
    """A line for each setting and estimator: mean ± half the 95 % interval.

    Beside a quantity's mean stands the mean difference to the estimator `against`, seed by seed.
    """
    from twin.commands.tables import Column, print_table

    columns = [
        Column(heading="setting", cells=[group.setting for group in groups], text=True),
        Column(heading="estimator", cells=[group.estimator for group in groups], text=True),
        Column(heading="runs", cells=[str(len(group.rows)) for group in groups], rank=9),
    ]
    for heading, counted in (
        ("failed", [group.failed for group in groups]),
        ("ended early", [group.not_driven for group in groups]),
    ):
        if any(counted):
            columns.append(Column(heading=heading, cells=[str(n or "") for n in counted]))
    for quantity in SHOWN:
        if any(group.values(quantity) for group in groups):
            columns += _mean_columns(groups, quantity, against)
    say("mean ± half the 95 % interval", style="italic")
    print_table(columns)


def _mean_columns(groups: Sequence[Group], quantity: str, against: str | None) -> list[Column]:
    """The column of a quantity, and that of its difference."""
    from twin.commands.tables import Column
    from twin.studies.summary import differences_to, mean_of

    heading, scale, rank = SHOWN[quantity]
    means = [mean_of(group, quantity) for group in groups]
    columns = [Column(heading=heading, cells=[_cell(m, scale) for m in means], rank=rank)]
    if against is not None and quantity not in NO_DIFFERENCE:
        differences = differences_to(groups, quantity, against)
        cells = ["" if d is None else _cell(d, scale, sign="+") for d in differences]
        columns.append(Column(heading=f"{heading} less {against}", cells=cells, rank=rank))
    return columns


def _cell(found: Any, scale: float, sign: str = "") -> str:
    if found.n == 0:
        return "-"
    half = "" if found.n == 1 else f" ± {scale * found.half:.3f}"
    return f"{scale * found.mean:{sign}.3f}{half}"
