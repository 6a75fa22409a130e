"""Columns of a rig as a CSV file."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray


def write_csv(columns: Mapping[str, NDArray[Any]], path: Path) -> None:
    """One row per point, one column per name; numbers with nine digits, nothing where NaN."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows([_text(v) for v in row] for row in zip(*columns.values(), strict=True))


def _text(value: Any) -> str:
    if isinstance(value, (float, np.floating)):
        return "" if np.isnan(value) else f"{round(float(value), 12) + 0.0:.9g}"  # -0.0 as 0
    return str(value)
