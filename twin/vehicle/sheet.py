"""A sheet that collects the numbers of a file and those derived from them, with grades."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from twin.io.plain import Plain
from twin.vehicle.implement import Implement
from twin.vehicle.machine import Machine
from twin.vehicle.source import Graded


@dataclass
class Sheet:
    """Numbers by path, in the order in which they were written."""

    part: Machine | Implement
    numbers: dict[str, Graded] = field(default_factory=dict)

    def given(self, path: str) -> Plain:
        """Value of the file's field at a path, as `rear.track_m`; None where it is left out."""
        held: Plain = self.part
        for name in path.split("."):
            held = getattr(held, name)
        return held

    def origin(self, path: str) -> tuple[str, str]:
        """Grade and source of a number of the file."""
        for own in self.part.sources:
            if own.path == path:
                return own.grade, own.source or self.part.source
        return self.part.grade, self.part.source

    def take(self, path: str, rule: float, grade: str, why: str) -> float:
        """Write the file's number at a path, or `rule` where there is none; return it.

        `grade` and `why` are the grade and the source of `rule`.
        """
        value = self.given(path)
        if value is None:
            return self.write(path, rule, grade, why)
        return self.write(path, float(value), *self.origin(path))

    def write(self, path: str, value: float, grade: str, why: str) -> float:
        """Write a number with its grade and its source `why`; return it."""
        self.numbers[path] = Graded(float(value), grade, why)
        return float(value)

    def values(self) -> Mapping[str, float]:
        """The numbers by path, without grades."""
        return {path: number.value for path, number in self.numbers.items()}
