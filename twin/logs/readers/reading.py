"""How files are to be read: what a map's [log] says beside the time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True, kw_only=True)
class Reading:
    """What nobody can see in a file, or what is to be read otherwise than it looks."""

    columns: frozenset[str] | None = None
    """The signals that are asked for; None for all."""
    encoding: str = ""
    """Of text, as Python calls it; empty for what it looks like."""
    delimiter: str = ""
    """Between cells; empty for what it looks like."""
    decimal: str = ""
    """The decimal sign, `.` or `,`; empty for what it looks like."""
    dbc: tuple[Path, ...] = ()
    """Files that say what is in CAN frames."""
    bad_rows: float | None = None
    """Share of the rows that may be bad; None for `losses.SHARE`."""
    fastest_kmh: float | None = None
    """Speed up to which the vehicle drives, where that is no tractor's."""
    offset_s: Mapping[str, float] = field(default_factory=dict)
    """File name -> how far its clock is ahead of the first file's."""
