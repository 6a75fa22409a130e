"""`twin run NAME`: simulate, estimate, score, write the run folder, show the table."""

from __future__ import annotations

import dataclasses
import json
import shlex
import sys
from collections.abc import Collection, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from twin.commands.output import check_folder
from twin.commands.terminal import progress, say
from twin.errors import BadInput, TwinError
from twin.io.atomic import moved_when_complete
from twin.pipeline import named as registry
from twin.pipeline import public

if TYPE_CHECKING:
    from twin.pipeline.estimating import Estimator
    from twin.pipeline.result import Result
    from twin.plugins.lookup import Thing
    from twin.simulation.levers import Controlled

DEFAULT_ESTIMATORS = ",".join(public.DEFAULT_ESTIMATORS)
LEAST_DRAWN = 2
"""Machines that a band needs."""


@dataclass(frozen=True, kw_only=True)
class Options:
    """Simulate a scenario, run the estimators on its streams and score them against the truth."""

    out: Path | None = None
    """Folder for the results; by default runs/<name>-seed<N>, with the machine and the implement
    between where they are given."""
    estimators: str = DEFAULT_ESTIMATORS
    """Estimators, separated by commas: names, or module:Name of your own."""
    controller: str = ""
    """Controller that sets throttle and hitch in work, in the driver's place: a name that `twin
    compare-controllers` knows, module:Name of your own, or FILE.zip, a policy saved by
    stable-baselines3."""
    figures: Path | None = None
    """Folder for the report's figures as SVG and PDF, one column (85 mm) wide."""
    frames: Path | None = None
    """Folder for the frames of the camera as PNG."""
    events: Path | None = None
    """TOML file of events: throttle, shifts, stops and more, by time, place or condition."""
    mask: tuple[float, float] | None = None
    """Mask both GNSS antennas: start of the mask and its duration [s]."""
    posterior: int = 0
    """Drive this many machines more, drawn from the posterior beside a calibrated machine's file,
    and show the band of every figure."""
    view: bool = False
    """Open the recording in the rerun viewer at the end."""
    quiet: bool = False
    """Print errors only."""
    json: bool = False
    """Print the scores as JSON instead of a table."""


def main(args: Sequence[str]) -> int:
    """Run a scenario by name. Options and overrides follow the name."""
    name, rest = _split(args)
    default, prog = registry.load("scenario", name), f"twin run {name}"
    from twin.commands.overrides import named_fields, read

    if {"-h", "--help"} & set(rest):
        _help(prog, default)
    options, scenario = read(Options(), default, rest, prog=prog)
    command = f"twin run {shlex.join(args)}"
    result, directory = execute(scenario, options, command, named_fields(rest))
    if options.view:
        from twin import viz

        viz.view(directory / "run.rrd")
    return status(result)


def execute(
    scenario: Thing, options: Options, command: str = "", named: Collection[str] = ()
) -> tuple[Result, Path]:
    """Run one scenario and write its folder, whose report says the command; both are returned.

    `named` are the fields that the user gave: those the run would not read are refused.
    """
    from twin.io import run_folder
    from twin.pipeline.unread import refuse_unread

    directory = options.out or run_folder.default_directory(_called(scenario, named), scenario.seed)
    run_folder.refuse_foreign(directory)  # before the work, not after it
    scenario = _masked(_with_events(scenario, options.events), options.mask)
    refuse_unread(scenario, named)
    _check_posterior(scenario, options.posterior)
    _check_frames(scenario, options.frames)
    check_folder("figures", options.figures)
    estimators = load_estimators(options.estimators)
    controlled = _controlled(options.controller)
    from twin.pipeline.run import run  # heavy, so only once the input is known to be good

    shown = not (options.quiet or options.json)
    with progress(scenario.name, shown=shown) as report, _pngs(options.frames) as frames:
        result = run(
            scenario, estimators=estimators, progress=report, frames=frames, controlled=controlled
        )
        result.save(directory, command=command)
        if options.figures is not None:
            result.figures(options.figures)
    _say(result, directory, options)
    if options.posterior:
        _drawn(scenario, options, directory)
    return result, directory


def _check_posterior(scenario: Thing, count: int) -> None:
    """Refuse a count that makes no band, and a machine without a posterior."""
    if not count:
        return
    if count < LEAST_DRAWN:
        raise BadInput(f"--posterior {count}: {LEAST_DRAWN} or more would do")
    if not hasattr(scenario, "machine"):
        raise BadInput(f"--posterior {count}: scenario '{scenario.name}' has no machine")
    from twin.calibration.drawn import posterior_of

    posterior_of(scenario.machine)


def _drawn(scenario: Thing, options: Options, directory: Path) -> None:
    """Drive machines of the posterior; write and print the bands of the drive's figures."""
    from twin.calibration.drawn import bands, drawn
    from twin.io.atomic import write_text
    from twin.pipeline.run import run

    machines = list(drawn(scenario, options.posterior, scenario.seed))
    if len(machines) < LEAST_DRAWN:
        raise BadInput(
            f"--posterior {options.posterior}: {len(machines)} of the machines drawn can be; a "
            "posterior that is narrower would do"
        )
    truths, shown = [], not (options.quiet or options.json)
    with progress("posterior", shown=shown) as report:
        estimators = load_estimators("ratio")
        for i, each in enumerate(machines):
            truths.append(run(each, estimators=estimators).scores["truth"])
            report((i + 1) / len(machines))
    found = bands(truths)
    write_text(directory / "posterior.json", json.dumps(found, indent=2))
    if shown:
        if refused := options.posterior - len(machines):
            say(f"{refused} of {options.posterior} machines drawn cannot be, and are left out")
        for name, (median, low, high) in found.items():
            say(f"{name}: {median:.4g}, {low:.4g} to {high:.4g} (95 % of the machines)")


def _controlled(controller: str) -> Controlled | None:
    if not controller:
        return None
    from twin.control.on_machine import controlled_by

    return controlled_by(controller)


def _called(scenario: Thing, named: Collection[str]) -> str:
    """Its name, with the machine and the implement that the user gave it."""
    given = [str(getattr(scenario, name)) for name in ("machine", "implement") if name in named]
    files = (".toml", ".xml")
    return "-".join([scenario.name, *(Path(g).stem if g.endswith(files) else g for g in given)])


def status(result: Result) -> int:
    """Exit status: 1 if an estimator failed. Each failure is printed on stderr."""
    for why in result.failed.values():
        print(f"twin: {why}; its estimates are NaN", file=sys.stderr)
    return 1 if result.failed else 0


def _with_events(scenario: Thing, path: Path | None) -> Thing:
    """The scenario with the events of a file in place of its own."""
    if path is None:
        return scenario
    if not hasattr(scenario, "events"):
        raise BadInput(f"--events {path}: scenario '{scenario.name}' has no machine that is driven")
    from twin.scenario.event_file import read_events

    try:
        return dataclasses.replace(scenario, events=read_events(path))
    except TwinError as error:
        raise BadInput(str(error) if str(path) in str(error) else f"{path}: {error}") from None


def _masked(scenario: Thing, mask: tuple[float, float] | None) -> Thing:
    """The scenario with one more scheduled fault of its receiver."""
    from twin.sensors import Outage

    if mask is None:
        return scenario
    gnss = getattr(getattr(scenario, "sensors", None), "gnss", None)
    if gnss is None:
        raise BadInput(f"--mask: scenario '{scenario.name}' has no GNSS receiver to mask")
    fault = Outage(start_s=mask[0], duration_s=mask[1], kind="mask")
    outages = tuple(sorted((*gnss.outages, fault), key=lambda o: o.start_s))
    gnss = dataclasses.replace(gnss, outages=outages)
    return dataclasses.replace(scenario, sensors=dataclasses.replace(scenario.sensors, gnss=gnss))


def _check_frames(scenario: Thing, folder: Path | None) -> None:
    if folder is None:
        return
    if getattr(getattr(scenario, "sensors", None), "camera", None) is None:
        raise BadInput(f"--frames {folder}: scenario '{scenario.name}' has no camera")
    if folder.exists() and not folder.is_dir():
        raise BadInput(f"--frames {folder} is not a folder; choose another")


def _pngs(folder: Path | None) -> AbstractContextManager[Path | None]:
    """A temporary folder for the frames, which are moved when all are written."""
    return nullcontext() if folder is None else moved_when_complete(folder)


def load_estimators(names: str) -> dict[str, Estimator]:
    """Estimators by name from `a,b,module:Name`. Raises UnknownName, or BadInput for none."""
    wanted = [name.strip() for name in names.split(",") if name.strip()]
    if not wanted:
        raise BadInput("--estimators is empty; twin list shows the names")
    return public.by_name(list(dict.fromkeys(wanted)))


def _split(args: Sequence[str]) -> tuple[str, Sequence[str]]:
    if args and args[0] in ("-h", "--help"):
        _help("twin run NAME")
    if not args or args[0].startswith("-"):
        known = ", ".join(registry.names("scenario"))
        raise BadInput(f"twin run needs the name of a scenario first; there are: {known}")
    return args[0], args[1:]


def _help(prog: str, default: Thing = None) -> None:
    """Print the options, and every field of a scenario with its value; then leave."""
    from twin.commands.parse import parse

    parse(Options if default is None else _with_fields(default), ["--help"], prog=prog)


def _with_fields(default: Thing) -> type[Options]:
    """Options and every field of the scenario, whose defaults are the named scenario's values."""
    import tyro

    fields = dataclasses.field(default=default)
    kind: Thing = type(default)
    annotation = Annotated[kind, tyro.conf.arg(name="")]  # fields stand at the top level
    return dataclasses.make_dataclass(
        "Options",
        [("scenario", annotation, fields)],
        bases=(Options,),
        frozen=True,
        kw_only=True,
        namespace={"__doc__": f"{getattr(default, 'about', '') or Options.__doc__}"},
    )


def _say(result: Result, directory: Path, options: Options) -> None:
    if options.json:
        print(json.dumps(result.scores, indent=2))
    elif not options.quiet:
        import numpy as np

        from twin.commands.score_table import print_scores

        print_scores(result.scores)
        for note in result.notes:
            say(f"note: {note}", style="dim")
        simulated_s = float(np.ptp(result.truth["epoch_ns"])) * 1e-9
        pace = f"{simulated_s:.0f} s driven in {result.wall_s:.1f} s; " if result.wall_s else ""
        say(f"{pace}{directory}/report.html, {directory}/run.rrd")
