"""`twin machine show | check | export`: a machine's or an implement's file, and what follows."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from twin.commands.parse import parse
from twin.commands.tables import Column, print_table
from twin.commands.terminal import say
from twin.errors import BadInput, TwinError, UnknownName
from twin.vehicle import Implement, Machine, files
from twin.vehicle.check import Finding, findings
from twin.vehicle.derive import derive
from twin.vehicle.files import mjcf_path
from twin.vehicle.implement import NONE
from twin.vehicle.implement_derive import derive_implement
from twin.vehicle.numerics import implement_numbers, machine_facts
from twin.vehicle.reading import read
from twin.vehicle.source import Graded

ACTIONS = {"show": "NAME|FILE", "check": "FILE", "export": "NAME|FILE OUT.xml"}
"""What is done -> the arguments that come first."""
INCONSISTENT = 1


@dataclass(frozen=True, kw_only=True)
class Show:
    """Show every number of a machine or an implement, its grade and where it comes from."""

    json: bool = False
    """Print JSON instead of a table."""


@dataclass(frozen=True, kw_only=True)
class Check:
    """Say what is inconsistent in a machine's file; status 1 where there is something."""


@dataclass(frozen=True, kw_only=True)
class Export:
    """Write a machine as MJCF, which plain MuJoCo opens: twin machine export FILE OUT.xml."""

    implement: str | None = None
    """The implement on its linkage; None for none."""


def main(args: Sequence[str]) -> int:
    """Show, check or export."""
    if not args or args[0] in ("-h", "--help"):
        print("twin machine show NAME|FILE    every number, its grade and its source")
        print("twin machine check FILE        what is inconsistent")
        print("twin machine export NAME|FILE OUT.xml [--implement NAME|FILE]    as MJCF")
        print("twin machine ACTION --help describes an action, --json among them.")
        if args:
            return 0
        raise BadInput(f"twin machine needs to know what to do: {', '.join(ACTIONS)}")
    action, rest = args[0], list(args[1:])
    if action not in ACTIONS:
        raise UnknownName("action of twin machine", action, ACTIONS)
    prog = f"twin machine {action} {ACTIONS[action]}"
    if {"-h", "--help"} & set(rest):
        parse({"show": Show, "check": Check, "export": Export}[action], ["--help"], prog=prog)
    wanted = len(ACTIONS[action].split())
    names, options = rest[:wanted], rest[wanted:]
    if len(names) < wanted or any(name.startswith("-") for name in names):
        what = "a name or a file" + (", and a file to write" if action == "export" else "")
        raise BadInput(f"twin machine {action} needs {what} first")
    if action == "show":
        return _show(names[0], parse(Show, options, prog=prog))
    if action == "check":
        parse(Check, options, prog=prog)
        return _check(names[0])
    return _export(names[0], Path(names[1]), parse(Export, options, prog=prog))


def _found(spec: str) -> Machine | Implement:
    """A machine, or an implement: by name, or by what is in the file."""
    if spec in files.implement_names():
        return files.implement(spec)
    if spec.endswith(".toml") and files.kind_of(Path(spec)) is Implement:
        return files.implement(spec)
    return files.machine(spec)


def _numbers(part: Machine | Implement) -> dict[str, Graded]:
    """Every number, as the twin uses it."""
    if isinstance(part, Machine):
        if part.mjcf is None:
            return dict(derive(part).numbers)
        return {
            n: Graded(v, "given", _by_hand(part)) for n, v in machine_facts(part).numbers.items()
        }
    if part.kind == NONE:
        return {}
    if part.mjcf is None:
        return dict(derive_implement(part).numbers)
    return {n: Graded(v, "given", _by_hand(part)) for n, v in implement_numbers(part).items()}


def _by_hand(part: Machine | Implement) -> str:
    """Where the numbers of a MJCF stand, and their sources where somebody wrote them down."""
    path = mjcf_path(part)
    told = path is not None and (path.parent / "README.md").is_file() and not part.folder
    return f"numeric of {part.mjcf}" + "; README.md beside it has grade and source" * told


def _notes(part: Machine | Implement) -> list[str]:
    """What a reader of the numbers would else miss."""
    if isinstance(part, Machine) and part.drive.driven == "all":
        return [
            "drive.driven = all says that the front axle can be engaged; a run drives the rear "
            "axle alone unless --drive.all-wheel-drive engages the front"
        ]
    return []


def _show(spec: str, options: Show) -> int:
    part = _found(spec)
    numbers = _numbers(part)
    if options.json:
        rows = {
            path: {"value": n.value, "grade": n.grade, "source": n.source}
            for path, n in numbers.items()
        }
        print(json.dumps({"schema": 1, "name": part.name, "about": part.about, "numbers": rows,
                          "notes": _notes(part)}, indent=2))  # fmt: skip
        return 0
    say(f"{part.name}: {part.about}", style="bold")
    values = [f"{n.value:.6g}" for n in numbers.values()]
    print_table([
        Column(heading="number", cells=list(numbers), text=True),
        Column(heading="value", cells=values),
        Column(heading="grade", cells=[n.grade for n in numbers.values()], text=True),
        Column(heading="source or rule", cells=[n.source or "-" for n in numbers.values()], rank=1,
               text=True),
    ])  # fmt: skip
    for note in _notes(part):
        say(f"note: {note}", style="dim")
    return 0


def _check(spec: str) -> int:
    """Print every inconsistency in a line of its own."""
    if spec.endswith(".toml") and files.kind_of(Path(spec)) is Machine:
        part: Machine | Implement = read(Machine, Path(spec))  # however inconsistent
    else:
        part = _found(spec)
    if isinstance(part, Implement):
        say(f"{part.name}: nothing is inconsistent")
        return 0
    machine_facts(part)  # refuses a MJCF that would not drive
    found = [*_of_implement(part), *findings(part)]
    for finding in found:
        print(finding if finding.fatal else f"{finding} (odd, but can be driven)")
    if not found:
        say(f"{part.name}: nothing is inconsistent")
    return INCONSISTENT if found else 0


def _of_implement(part: Machine) -> Iterator[Finding]:
    """The implement that the file names and that cannot be had."""
    name = files.usual_implement(part)
    try:
        if name is not None:
            files.implement(name)
    except TwinError as error:
        yield Finding("implement", f"= {part.implement}: {error}")


def _export(spec: str, out: Path, options: Export) -> int:
    from twin.io.atomic import write_text
    from twin.machine.export import as_mjcf

    if out.suffix != ".xml":
        raise BadInput(f"{out} is no MJCF; a file that ends in .xml would do")
    part = None if options.implement in (None, NONE) else files.implement(str(options.implement))
    write_text(out, as_mjcf(files.machine(spec), part))
    say(f"{out}: python -m mujoco.viewer --mjcf {out}")
    return 0
