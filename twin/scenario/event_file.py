"""A file of events: TOML that a farmer can read and write.

schema = 1

[[event]]
at_s = 30
do = "throttle"
engine_rpm = 1900
"""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

from twin.errors import BadInput, OutOfRange, TwinError
from twin.io.atomic import write_text
from twin.io.plain import Plain, from_plain
from twin.scenario.events import Event, check_order
from twin.vehicle.reading import table_of

SCHEMA = 1
"""Form of the file."""


def read_events(path: Path) -> tuple[Event, ...]:
    """The events of a file, in their order.

    Raises:
        BadInput: it cannot be read, or holds no events; names the event by its place and action.
    """
    table = table_of(path)
    try:
        return _events(table)
    except TwinError as error:
        raise BadInput(f"{path}: {error}") from None


def _events(table: dict[str, Plain]) -> tuple[Event, ...]:
    if (unknown := sorted(set(table) - {"schema", "event"})) != []:
        raise BadInput(f"there is no '{unknown[0]}' in a file of events; schema and [[event]] are")
    if table.get("schema", SCHEMA) != SCHEMA:
        raise OutOfRange("schema", table["schema"], f"what is known: {SCHEMA}")
    rows = table.get("event", [])
    if not isinstance(rows, list) or not rows:
        raise BadInput('it holds no events; [[event]] with do = "stop" and for_s = 30 would do')
    events = tuple(_event(i, row) for i, row in enumerate(rows))
    check_order(events)
    return events


def _event(i: int, row: Plain) -> Event:
    named = f" ({row['do']})" if isinstance(row, dict) and "do" in row else ""
    try:
        return from_plain(Event, row)
    except TwinError as error:
        raise BadInput(f"event {i + 1}{named}: {error}") from None


def write_events(path: Path, events: tuple[Event, ...]) -> None:
    """Write a file that `read_events` reads as the same events."""
    parts = [f"schema = {SCHEMA}\n"]
    for event in events:
        given = {f.name: getattr(event, f.name) for f in dataclasses.fields(event)}
        usual = {f.name: f.default for f in dataclasses.fields(event)}
        lines = [f"{n} = {json.dumps(v)}" for n, v in given.items() if v != usual[n]]
        parts.append("\n".join(["[[event]]", *lines]) + "\n")
    write_text(path, "\n".join(parts))
