"""Where a number comes from: its grade (quality of evidence) and its source."""

from __future__ import annotations

from dataclasses import dataclass

from twin.errors import UnknownName

GRADES = {
    "measured": "measured on this very machine",
    "published": "printed for it, or for its kind, in the source that is named",
    "derived": "follows from other numbers by the rule that is given",
    "assumed": "chosen within what is usual",
    "given": "stands in the file without a grade",
}


@dataclass(frozen=True, kw_only=True)
class Source:
    """Grade and source of one number of a file, where they differ from those of the file."""

    path: str
    """Field with its tables before it: `rear.track_m`."""
    grade: str = "given"
    """One of GRADES."""
    source: str = ""

    def __post_init__(self) -> None:
        check_grade(f"{self.path}.grade", self.grade)


@dataclass(frozen=True)
class Graded:
    """A number with its grade and source."""

    value: float
    grade: str
    source: str
    """Publication or document, or the rule by which it was derived."""


def check_grade(path: str, grade: str) -> None:
    """Raise UnknownName if `grade` is not in GRADES; `path` is the field for the message."""
    if grade not in GRADES:
        raise UnknownName(f"grade ({path})", grade, GRADES)
