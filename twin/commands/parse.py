"""Read arguments into frozen dataclasses with tyro. An error of tyro becomes one line."""

from __future__ import annotations

import contextlib
import io
import re
from collections.abc import Sequence
from typing import TypeVar

import tyro

from twin.commands.output import STDOUT, Output
from twin.errors import BadInput, TwinError

T = TypeVar("T")

_READINGS = (
    (
        r"Error parsing (?P<option>\S+): invalid literal for int.*: '(?P<given>.*)'",
        "a whole number",
    ),
    (
        r"Error parsing (?P<option>\S+): could not convert string to float: '(?P<given>.*)'",
        "a number",
    ),
    (
        r"Error parsing (?P<option>\S+): no type matching (?P<wanted>.+) could be "
        r"instantiated from \['(?P<given>.*)'\]\.?",
        "",
    ),
)
"""Message of tyro -> what the option expects; empty where tyro itself names it."""
_KINDS = {"INT": "a whole number", "FLOAT": "a number", "STR": "text"}
_CONFIG = (tyro.conf.AvoidSubcommands, tyro.conf.FlagCreatePairsOff)


class _NotFound(TwinError):
    """What cannot be found by its name; tyro would swallow a ValueError."""


_REGISTRY = tyro.constructors.ConstructorRegistry()


@_REGISTRY.primitive_rule
def _found_by_name(
    info: tyro.constructors.PrimitiveTypeInfo,
) -> tyro.constructors.PrimitiveConstructorSpec[object] | None:
    """A type whose instances are found by `module:Name` is given so."""
    kind = info.type
    if not (isinstance(kind, type) and hasattr(kind, "by_name")):
        return None

    def found(args: list[str]) -> object:
        try:
            return kind.by_name(args[0])
        except TwinError as error:
            raise _NotFound(str(error)) from None

    return tyro.constructors.PrimitiveConstructorSpec(
        nargs=1,
        metavar="MODULE:NAME",
        instance_from_str=found,
        is_instance=lambda thing: isinstance(thing, kind),
        str_from_instance=lambda thing: [str(getattr(thing, "name", thing))],
    )


def parse(kind: type[T], args: Sequence[str], *, prog: str) -> T:
    """An instance of a dataclass from the command line.

    Args:
        kind: dataclass; its fields are the options.
        args: what stands after `prog`.
        prog: the command as the user typed it, for help.

    Raises:
        BadInput: what tyro refuses, as one line.
        SystemExit: status 0, after help was printed.
    """
    boxes = io.StringIO()
    try:
        with contextlib.redirect_stderr(boxes):
            return tyro.cli(
                kind, args=_with_stdout(kind, args), prog=prog, config=_CONFIG, registry=_REGISTRY
            )
    except SystemExit as end:
        if not end.code:
            raise
        raise BadInput(one_line(boxes.getvalue())) from None
    except _NotFound as error:
        raise BadInput(str(error)) from None


def seconds(option: str, text: str) -> tuple[float, ...]:
    """Times separated by commas, such as 1,10,30; none of an empty text.

    Raises:
        BadInput: a part is no finite number.
    """
    found = []
    for part in text.split(",") if text else ():
        try:
            found.append(float(part))
        except ValueError:
            raise BadInput(
                f"--{option} {text}: '{part.strip()}' is no number of seconds; 1,10,30 would do"
            ) from None
    return tuple(found)


def _with_stdout(kind: type, args: Sequence[str]) -> list[str]:
    """Arguments with `-` after a `--json` that may name a file and does not."""
    given = list(args)
    if issubclass(kind, Output) and "--json" in given:
        after = given.index("--json") + 1
        if after == len(given) or given[after].startswith("--"):
            given.insert(after, str(STDOUT))
    return given


def one_line(boxes: str) -> str:
    """What tyro's box says, without the box, the class names and the pointer to help.

    `Error parsing scenario.soil: soil.friction = 9 is outside [0.05, 1.5]` becomes
    `soil.friction = 9 is outside [0.05, 1.5]`.
    """
    blocks = _blocks(boxes)
    text = blocks[0].split(" Got errors:")[0] if blocks else "the arguments cannot be used"
    for pattern, reading in _READINGS:
        if found := re.fullmatch(pattern, text):
            option, given, wanted = (
                found.groupdict().get(k) for k in ("option", "given", "wanted")
            )
            return f"{option} = {given} is not {reading or _listed(wanted or '')}"
    text = re.sub(r"^Missing from ([^:]+): ", r"\1 needs ", text)
    text = re.sub(r"^Error parsing (?!-)[\w.\[\]{}|-]*:? *", "", text)
    return text + _nearest(text, blocks[1:])


def _blocks(boxes: str) -> list[str]:
    """The parts between a box's rules, each as one line, without its title.

    Where the output takes UTF-8 the title is in the upper edge; elsewhere it is a block of its own.
    """
    blocks: list[list[str]] = [[]]
    for line in boxes.splitlines():
        content = line.strip("│ ")
        if line.startswith(("╭", "╰")):
            continue
        if re.fullmatch("[─-]{4,}", content):
            blocks.append([])
        elif content:
            blocks[-1].append(content)
    told = blocks if boxes.startswith("╭") else blocks[1:]
    return [" ".join(block) for block in told if block]


def _nearest(text: str, blocks: Sequence[str]) -> str:
    """`; did you mean --soil.friction?` where tyro knows a similar option."""
    if not text.startswith("Unrecognized"):
        return ""
    for block in blocks:
        if block.startswith(("Perhaps", "Arguments similar")):
            options = re.findall(r"(?<=[: ])--[\w.-]+(?=[ ,])", block)
            near = [o for o in options if o not in text.split(": ", 1)[-1].split(", ")]
            if near:
                return f"; did you mean {near[0]}?"
    return ""


def _listed(wanted: str) -> str:
    """`{None}|FLOAT` as `None or a number`."""
    parts = [part.strip("{}").replace(",", ", ") for part in wanted.split("|")]
    return " or ".join(_KINDS.get(part, part) for part in parts)
