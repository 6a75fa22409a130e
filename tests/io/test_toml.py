"""Plain values as TOML text."""

import tomllib

from twin.io.toml import Inline, text

TABLE = {
    "name": 'a "quoted" name', "number": 1.5, "whole": 3, "yes": True, "none": None,
    "list": [1.0, 2.5], "pairs": [[1400.0, 400.0], [2200.0, 321.0]],
    "mass_kg": Inline({"value": 5260.0, "grade": "measured"}),
    "front": {"tyre": "18.4-38", "inner": {"deep": -1}, "empty": {"none": None}},
    "ballast": [{"mass_kg": 100.0}, {"mass_kg": 50.0, "x_m": 2.0}],
}  # fmt: skip


def test_what_is_written_is_read_again():
    read = tomllib.loads(text(TABLE))
    expected = {k: v for k, v in TABLE.items() if v is not None}
    expected["front"] = {"tyre": "18.4-38", "inner": {"deep": -1}}
    assert read == expected


def test_a_graded_number_stands_in_one_line():
    assert 'mass_kg = {value = 5260.0, grade = "measured"}' in text(TABLE)
