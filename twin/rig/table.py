"""Columns of a rig as a CSV file."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Measured:
    """What a rig measured: fields that are arrays of one value per point."""

    def columns(self) -> dict[str, Array]:
        """Everything measured, by name."""
        return {f.name: getattr(self, f.name) for f in fields(self)}


def write_csv(columns: Mapping[str, NDArray[np.generic]], path: Path) -> None:
    """One row per point, one column per name; numbers with nine digits, nothing where NaN."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows([_text(v) for v in row] for row in zip(*columns.values(), strict=True))


def _text(value: object) -> str:
    if isinstance(value, (float, np.floating)):
        return "" if np.isnan(value) else f"{round(float(value), 12) + 0.0:.9g}"  # -0.0 as 0
    return str(value)
