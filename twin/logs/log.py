"""Result of a reader of logs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from twin.logs.job import Implement
from twin.logs.protocol_parts import Part, Times
from twin.logs.rules import Rule
from twin.streams import Setup, Streams, Table


@dataclass(frozen=True, kw_only=True)
class Log:
    """A recorded drive in the form that estimators take, with notes from the reading."""

    streams: Streams
    """Samples by sensor; obeys `twin.streams.check`."""
    setup: Setup
    """Nominal machine; values nobody gave are assumed, and `notes` says which."""
    reference: Table | None = None
    """`epoch_ns` and the columns named as reference, under the names an estimate has."""
    rows: Table | None = None
    """Label columns (text), one value for each row of `wheels` (of the file without wheels)."""
    rules: Mapping[str, Rule] = field(default_factory=dict)
    """The map's row rules by name: `zero_slip`, `steady`."""
    implement: Implement | None = None
    """What the map says of the implement."""
    protocol: Mapping[Part, Times] = field(default_factory=dict)
    """When the map says that the parts of the recording protocol were driven."""
    notes: tuple[str, ...] = ()
    """What was handled and not hidden: gaps, rows left out, values assumed."""
