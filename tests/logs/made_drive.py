"""A made drive with known slip, as columns that tests bend."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

SLIP = 0.08
MAP = """
[log]
time = {column = "t", unit = "s"}
[gnss]
latitude = {column = "lat", unit = "deg"}
longitude = {column = "lon", unit = "deg"}
speed = {column = "v", unit = "m/s"}
course = {column = "course", unit = "deg"}
[wheels]
driven_speed = {column = "wheel", unit = "km/h"}
[setup]
machine = "made"
wheelbase_m = 2.8
"""


def drive(seconds: float = 120.0, rate_hz: float = 5.0, seed: int = 0) -> dict[str, np.ndarray]:
    """Starts and stops on a bending track at 1 to 3 m/s, with a receiver's noise and slip SLIP."""
    generator = np.random.default_rng(seed)
    t = np.arange(round(seconds * rate_hz)) / rate_hz
    v = 2.0 + 0.8 * np.sin(t / 9.0 + 3.0 * np.sin(t / 41.0)) + 0.2 * np.sin(t / 2.3)
    course = 40.0 + 60.0 * np.sin(t / 25.0)
    north = np.cumsum(v * np.cos(np.radians(course))) / rate_hz
    east = np.cumsum(v * np.sin(np.radians(course))) / rate_hz
    return {
        "t": t,
        "lat": 48.0 + north / 111_200.0,
        "lon": 9.0 + east / (111_320.0 * np.cos(np.radians(48.0))),
        "v": v + 0.02 * generator.normal(size=len(t)),
        "course": np.mod(course, 360.0),
        "wheel": 3.6 * v / (1.0 - SLIP),
        "yaw": -np.gradient(np.radians(course), t),
    }


def as_text(columns: Mapping[str, np.ndarray], delimiter: str = ",", decimal: str = ".") -> str:
    """The columns as a table; a NaN is an empty cell."""
    digits = {"t": 6, "lat": 9, "lon": 9}
    cells = [
        [
            "" if isinstance(x, float) and x != x
            else x if isinstance(x, str)
            else f"{x:.{digits.get(name, 4)}f}".replace(".", decimal)
            for x in values.tolist()
        ]
        for name, values in columns.items()
    ]  # fmt: skip
    lines = [delimiter.join(columns), *(delimiter.join(row) for row in zip(*cells, strict=True))]
    return "\n".join(lines) + "\n"


def written(folder: Path, columns: Mapping[str, np.ndarray], name: str = "log.csv") -> Path:
    """The columns as a CSV file."""
    path = folder / name
    path.write_text(as_text(columns))
    return path


def mapped(folder: Path, text: str = MAP, **changed: str) -> Path:
    """A map, with parts of it replaced."""
    for old, new in changed.items():
        text = text.replace(old, new)
    path = folder / "map.toml"
    path.write_text(text)
    return path
