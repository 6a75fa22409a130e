"""Every column is described, and its page says so."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from twin import streams
from twin.io import columns
from twin.simulation.columns import POWER_COLUMNS
from twin.truth import truth

ROOT = Path(__file__).parents[2]
UNITS = {
    "m": "m", "mps": "m/s", "mps2": "m/s2", "m2ps2": "m2/s2", "rad": "rad", "radps": "rad/s",
    "n": "N", "nm": "N m", "w": "W", "j": "J", "s": "s", "ns": "ns", "lph": "L/h",
}  # fmt: skip
ALL = [
    (name, column)
    for table in (columns.STAMPS, columns.TRUTH, columns.ESTIMATES, *columns.STREAMS.values())
    for name, column in table.items()
]


def test_every_column_of_a_stream_is_described() -> None:
    assert {sensor: tuple(table) for sensor, table in columns.STREAMS.items()} == streams.COLUMNS
    assert tuple(columns.STAMPS) == streams.STAMPS


def test_every_column_of_an_estimate_is_described() -> None:
    assert tuple(columns.ESTIMATES) == streams.ESTIMATES


@pytest.mark.slow
def test_every_column_of_the_truth_is_described() -> None:
    from dataclasses import replace

    from twin.pipeline.named import load
    from twin.pipeline.run import run

    scenario = load("scenario", "plough-25cm")
    course = replace(scenario.course, length_m=1.0)
    table = run(replace(scenario, course=course), estimators={}).truth
    assert sorted(table) == sorted(columns.TRUTH)
    flags = {name for name, values in table.items() if values.dtype == np.bool_}
    assert flags == {n for n, c in columns.TRUTH.items() if c.unit == "true/false"}


def test_every_power_and_joint_is_described() -> None:
    assert set(POWER_COLUMNS) <= set(columns.TRUTH)
    assert {f"joint_{name}_rad" for name in truth.JOINTS} <= set(columns.TRUTH)


@pytest.mark.parametrize(("name", "column"), ALL, ids=[name for name, _ in ALL])
def test_the_unit_is_that_of_the_name(name: str, column: Any) -> None:
    ending = re.search(r"_([a-z0-9]+)$", name)
    unit = UNITS.get(ending[1]) if ending else None
    assert column.unit == (unit or column.unit)
    assert (column.unit in ("-", "count", "code", "true/false")) == (unit is None)
    assert column.frame in ("world", "body", "ground", "-")
    assert column.meaning


def test_the_page_is_what_the_script_writes() -> None:
    path = ROOT / "docs/column_page.py"
    space: dict[str, Any] = {"__name__": "column_page", "__file__": str(path)}
    exec(path.read_text(encoding="utf-8"), space)
    assert space["PAGE"].read_text(encoding="utf-8") == space["page"]()
