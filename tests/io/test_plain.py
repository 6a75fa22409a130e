from __future__ import annotations

import json
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.synthetic_run import STUB, Field, Plough, Scenario, Soil
from twin.errors import BadInput, OutOfRange
from twin.io.plain import from_plain, to_plain

SCENARIOS = st.builds(
    Scenario,
    seed=st.integers(0, 2**31 - 1),
    soil=st.builds(Soil, friction=st.floats(0.05, 1.5)),
    field=st.builds(Field, cross_slope_deg=st.floats(-30, 30)),
    plough=st.none()
    | st.builds(
        Plough,
        depth_m=st.floats(0.0, 0.4),
        offsets_m=st.lists(st.floats(-1, 1), max_size=4).map(tuple),
    ),
)


@given(SCENARIOS)
def test_json_and_back_is_the_same_scenario(scenario: Scenario) -> None:
    assert from_plain(Scenario, json.loads(json.dumps(to_plain(scenario)))) == scenario


def test_whole_numbers_become_floats_again() -> None:
    made = from_plain(Scenario, {"length_m": 20})
    assert type(made.length_m) is float


def test_an_unknown_field_is_named() -> None:
    with pytest.raises(BadInput, match="Scenario has no field 'sead'; there are: name, "):
        from_plain(Scenario, {"sead": 3})


def test_an_unknown_field_of_what_may_be_absent_is_named() -> None:
    with pytest.raises(BadInput, match="Plough has no field 'deapth_m'; there are: "):
        from_plain(Scenario, {"plough": {"deapth_m": 0.2}})


def test_what_the_dataclass_refuses_stays_refused() -> None:
    plain = to_plain(replace(STUB))
    plain["soil"]["friction"] = 9.0
    with pytest.raises(OutOfRange, match=r"soil\.friction = 9 is outside"):
        from_plain(Scenario, plain)
