"""Options that replace fields of a scenario: those that are given are read as all of them were."""

from __future__ import annotations

from dataclasses import replace

import pytest

from twin.commands.overrides import named_fields, read
from twin.commands.parse import parse
from twin.commands.run import Options, _with_fields
from twin.errors import BadInput
from twin.pipeline.named import load
from twin.scenario import fields


@pytest.mark.parametrize(
    "args",
    [
        [],
        ["--soil.friction", "0.8"],
        ["--soil.friction", "None", "--quiet"],
        ["--soil.cone_index_kpa=800", "--seed", "7", "--out", "here"],
        ["--no-course.hold-line"],
        ["--course.no-hold-line"],
        ["--plough.offsets-m", "0.1", "0.2"],
        ["--mask", "3", "4", "--json"],
        ["--seed", "1", "--seed", "2"],
        ["--sensors.gnss.rate-hz", "10", "--sensors.imu.rate-hz", "100"],
        ["0.5"],
        ["--"],
        ["--seed"],
        ["--view", "yes"],
    ],
)
def test_what_is_given_is_read_as_tyro_reads_all_options(args: list[str]) -> None:
    scenario = load("scenario", "plough-25cm")
    try:
        whole = parse(_with_fields(scenario), args, prog="twin run")
    except BadInput:
        with pytest.raises(BadInput):
            read(Options(), scenario, args, prog="twin run")
        return
    own, found = read(Options(), scenario, args, prog="twin run")
    assert found == whole.scenario  # type: ignore[attr-defined]
    assert own == Options(**{name: getattr(whole, name) for name in own.__dataclass_fields__})


@pytest.mark.parametrize("name", ["plough-25cm", "slope-9-dry", "fault-all", "ima-pkf"])
def test_every_field_can_be_named_and_keeps_its_value(name: str) -> None:
    scenario = load("scenario", name)
    for path, value in fields.leaves(scenario):
        if isinstance(value, bool) or value is None or not isinstance(value, int | float | str):
            continue
        args = [f"--{path.replace('_', '-')}", str(value)]
        assert read(Options(), scenario, args, prog="twin run")[1] == scenario, path


def test_flags_and_groups() -> None:
    scenario = load("scenario", "plough-25cm")
    flags = [path for path, value in fields.leaves(scenario) if value is True]
    for path in flags:
        group, dot, name = path.rpartition(".")
        option = f"--{group}{dot}no-{name}".replace("_", "-")
        found = read(Options(), scenario, [option], prog="twin run")[1]
        assert fields.value(found, path) is False, path
    paths = dict(fields.leaves(load("scenario", "fault-all")))
    assert "soil" not in paths
    assert any(".0." in path for path in paths)  # what stands in a tuple has its place as a name
    assert named_fields(["--soil.cone-index-kpa=8", "x"]) == {"soil.cone_index_kpa"}


def test_only_what_is_given_is_replaced() -> None:
    scenario = load("scenario", "plough-25cm")
    _, found = read(Options(), scenario, ["--seed", "3"], prog="twin run")
    assert found == replace(scenario, seed=3)
