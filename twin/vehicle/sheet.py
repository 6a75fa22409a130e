"""A sheet on which a file's numbers and those that follow from them are written, with grades."""

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
        """What the file says at a path; None for nothing."""
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
        """The file's number at a path, or else the rule's, written down; its value."""
        value = self.given(path)
        if value is None:
            return self.write(path, rule, grade, why)
        return self.write(path, float(value), *self.origin(path))

    def write(self, path: str, value: float, grade: str, why: str) -> float:
        """Write a number down; its value."""
        self.numbers[path] = Graded(float(value), grade, why)
        return float(value)

    def values(self) -> Mapping[str, float]:
        """The numbers alone."""
        return {path: number.value for path, number in self.numbers.items()}
