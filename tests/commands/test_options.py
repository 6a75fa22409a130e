"""The help of every option: what it is, its unit, and the names that it takes."""

from __future__ import annotations

import ast
import io
from collections.abc import Iterator
from contextlib import redirect_stdout
from pathlib import Path

import pytest

from twin import cli
from twin.scenario.soils import PRESETS

TWIN = Path(cli.__file__).parent
UNITS = {
    "m": "m", "s": "s", "deg": "deg", "rad": "rad", "kn": "kN", "n": "N", "kg": "kg", "rpm": "rpm",
    "kpa": "kPa", "kmh": "km/h", "mps": "m/s", "radps": "rad/s", "hz": "Hz", "knpm3": "kN/m3",
    "ratio": "-", "cv": "-", "share": "-", "factor": "-", "scale": "-", "px": "px",
}  # fmt: skip
"""Last part of an option's name -> its unit."""
FILES = sorted([*TWIN.glob("scenario/*.py"), *TWIN.glob("commands/*.py"), TWIN / "rig/tyre.py"])


def options() -> Iterator[tuple[str, str]]:
    """Name and help of every field of the dataclasses that are read from the command line."""
    for file in FILES:
        for kind in ast.walk(ast.parse(file.read_text())):
            if not (isinstance(kind, ast.ClassDef) and kind.name in READ):
                continue
            for node, following in zip(kind.body, [*kind.body[1:], None], strict=True):
                if isinstance(node, ast.AnnAssign):
                    told = following.value if isinstance(following, ast.Expr) else None
                    about = told.value if isinstance(told, ast.Constant) else ""
                    yield f"{kind.name}.{ast.unparse(node.target)}", str(about)


READ = {
    "Scenario", "Soil", "Field", "Patch", "Plough", "Drive", "Course", "Driver", "Event", "Tyre",
    "Options", "Estimate", "Study", "Reproduce", "Validate", "Bench", "CompareControllers", "View",
    "List", "Output", "Told", "Wheel", "Drawbar", "Slope", "Park",
}  # fmt: skip
GROUPS = {"soil", "field", "plough", "drive", "course", "driver", "sensors", "tyre"}
"""Fields that are no options but hold some."""


@pytest.mark.parametrize(("name", "about"), [*options()], ids=lambda text: text[:30])
def test_every_option_says_what_it_is_and_in_which_unit(name: str, about: str) -> None:
    field = name.split(".")[1]
    if field in GROUPS:
        return
    assert about, name
    unit = UNITS.get(field.rsplit("_", 1)[-1]) if "_" in field else None
    if unit is not None:
        assert f"[{unit}]" in about, (name, about)


def test_the_help_names_every_soil() -> None:
    out = io.StringIO()
    with redirect_stdout(out):
        assert cli.main(["run", "plough-25cm", "--help"]) == 0
    words = set(out.getvalue().replace(",", " ").replace(".", " ").replace("│", " ").split())
    assert set(PRESETS) <= words
