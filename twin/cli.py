"""The command `twin`: finds the subcommand, and turns every error into one line and a status.

Status 0; 1 where a promise or an estimator fails, or the disk is full; 2 for bad input, with one
line on stderr; 130 when interrupted. Nothing heavy is imported before the subcommand that needs it.
"""

from __future__ import annotations

import gc
import io
import os
import sys
from collections.abc import Sequence
from importlib import import_module

from twin.compute.waiting import when_compiling
from twin.errors import BadInput, NoSpace, TwinError, UnknownName

COMMANDS: dict[str, tuple[str, str]] = {
    "list": ("twin.commands.list", "list scenarios, machines, implements, soils, estimators"),
    "run": (
        "twin.commands.run",
        "NAME: simulate a scenario, run and score estimators, write a run folder",
    ),
    "estimate": ("twin.commands.estimate", "LOG: run the estimators on a recorded drive"),
    "calibrate": ("twin.commands.calibrate", "LOG: find the machine and the soil that explain it"),
    "tune": ("twin.commands.tune", "LOG: find an estimator's noises from a recorded drive"),
    "compare": ("twin.commands.compare", "DIR DIR: two runs, or a log and a run, side by side"),
    "map": ("twin.commands.map", "LOG: write a first column map, guessed from names and physics"),
    "export": ("twin.commands.export", "DIR: write a run as the files of a real machine"),
    "reproduce": ("twin.commands.reproduce", "PAPER: compare published results with the twin's"),
    "validate": (
        "twin.commands.validate",
        "check the twin against mechanics, published laws and field data",
    ),
    "study": (
        "twin.commands.study",
        "SCENARIOS: run many seeds and settings; means with intervals",
    ),
    "rig": ("twin.commands.rig", "wheel | drawbar | slope | park: run a test rig; CSV and figure"),
    "compare-controllers": (
        "twin.commands.compare_controllers",
        "compare slip controllers and saved policies on held-out grounds",
    ),
    "machine": (
        "twin.commands.machine",
        "show | check | export: a machine or an implement, every number with its grade",
    ),
    "view": ("twin.commands.view", "DIR: open the recording of a run folder"),
    "bench": ("twin.commands.bench", "measure speed and memory on this machine"),
}
"""Subcommand -> (module with `main(args) -> status`, what it does)."""
COMPILING_S = 35
"""Time to compile the functions of a run where none is kept, on one core [s]."""

COLLECTED_AFTER = (50_000, 20, 20)
"""New objects after which garbage is looked for, and how much seldomer among older ones: importing
and drawing make a million objects that stay, among which Python's own thresholds search in vain."""

FAILED, BAD_INPUT, INTERRUPTED = 1, 2, 130


def main(argv: Sequence[str] | None = None) -> int:
    """Run `twin` and give its exit status.

    Args:
        argv: arguments after the program's name; those of the process when None.
    """
    args = list(sys.argv[1:] if argv is None else argv)
    if argv is None:  # the process is ours
        gc.set_threshold(*COLLECTED_AFTER)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # a terminal without ± gets ?, not a traceback
    try:
        status = _dispatch(args)
        sys.stdout.flush()
        return status
    except NoSpace as error:
        return _refuse(str(error), FAILED)
    except TwinError as error:
        return _refuse(str(error) + _left_by(error))
    except KeyboardInterrupt:
        print("twin: interrupted; nothing was written", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:  # the reader of our output has gone, as in `twin list | head`
        _drop_output()
        return 0
    except OSError as error:
        if error.errno not in _full():
            raise
        _drop_output()
        return _refuse(f"the output cannot be written: {error.strerror}", FAILED)
    except SystemExit as end:  # tyro, after printing help
        return end.code if isinstance(end.code, int) else 0


def _dispatch(args: Sequence[str]) -> int:
    if not args or args[0] in ("-h", "--help"):
        print(_help())
        return 0 if args else BAD_INPUT
    if args[0] == "--version":
        print(_version())
        return 0
    if args[0].startswith("-"):
        raise BadInput(
            f"{args[0]} comes before the command; the commands are: {', '.join(COMMANDS)}"
        )
    if args[0] not in COMMANDS:
        raise UnknownName("command", args[0], COMMANDS)
    module, _ = COMMANDS[args[0]]
    with when_compiling(_say_compiling if _talks(args) else lambda: None):
        status: int = import_module(module).main(args[1:])
    return status


def _talks(args: Sequence[str]) -> bool:
    """Whether progress is shown: on a terminal, unless it is not wanted."""
    return sys.stderr.isatty() and not {"--quiet", "--json"} & set(args)


def _say_compiling() -> None:
    print(f"twin: compiling once, about {COMPILING_S} s", file=sys.stderr)


def _help() -> str:
    width = max(map(len, COMMANDS))
    lines = [f"  {name:<{width}}  {about}" for name, (_, about) in COMMANDS.items()]
    return "\n".join(
        (
            "usage: twin COMMAND [OPTIONS]",
            "",
            "Simulate a tractor and plough and their sensors. Run estimators of wheel slip and",
            "sideslip on the sensor streams. Score them against the truth.",
            "",
            *lines,
            "",
            "twin COMMAND --help describes a command.",
            "twin run NAME --help lists the fields of a scenario.",
        )
    )


def _version() -> str:
    from importlib import metadata

    return f"tractor-twin {metadata.version('tractor-twin')}"


def _left_by(error: TwinError) -> str:
    """Write down what repeats a failed simulation, and say where; other errors leave nothing."""
    evidence = getattr(error, "evidence", None)
    if evidence is None:
        return ""
    from twin.io import run_folder as runfolder

    try:
        folder = runfolder.write_failed(evidence)
    except (TwinError, OSError) as why:
        return f"; what repeats it could not be written: {why}"
    return f"; {folder} repeats it (twin.simulation.guard.replay)"


def _full() -> frozenset[int]:
    from twin.io.atomic import FULL

    return FULL


def _drop_output() -> None:
    """Send what is left of our output nowhere, so that Python does not try again at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _refuse(message: str, status: int = BAD_INPUT) -> int:
    print("twin: " + " ".join(message.split()), file=sys.stderr)
    return status


if __name__ == "__main__":
    sys.exit(main())
