"""Fields by dotted path, as sweeps name them."""

import pytest

from scenarios.plough import CM_25, SLIP_PATCH
from twin.errors import BadInput, OutOfRange, UnknownName
from twin.scenario import fields


def test_a_field_is_read_and_replaced_at_any_depth():
    assert fields.value(CM_25, "soil.draft_cv") == CM_25.soil.draft_cv
    changed = fields.replaced(CM_25, {"soil.draft_cv": 0.3, "plough.depth_m": 0.2, "seed": 4})
    assert (changed.soil.draft_cv, changed.plough.depth_m, changed.seed) == (0.3, 0.2, 4)
    assert fields.replaced(changed, {"soil.draft_cv": CM_25.soil.draft_cv}) != CM_25
    back = {"soil.draft_cv": CM_25.soil.draft_cv, "plough.depth_m": 0.25, "seed": CM_25.seed}
    assert fields.replaced(changed, back) == CM_25


def test_an_element_of_a_tuple_is_a_field_too():
    changed = fields.replaced(SLIP_PATCH, {"field.patches.0.length_m": 33.0})
    assert changed.field.patches[0].length_m == 33.0
    assert changed.field.patches[0].start_m == SLIP_PATCH.field.patches[0].start_m
    assert len(changed.field.patches) == len(SLIP_PATCH.field.patches)


def test_fields_of_one_object_are_checked_only_together():
    """Brixius' law needs a cone index, which sand has none of: neither alone would do."""
    both = {"soil.preset": "lete-sand", "soil.law": "bekker"}
    assert fields.replaced(CM_25, both).soil.law == "bekker"
    with pytest.raises(BadInput, match="cone index"):
        fields.replaced(CM_25, {"soil.preset": "lete-sand"})


def test_what_the_scenario_refuses_is_refused():
    with pytest.raises(OutOfRange, match=r"soil\.friction = 9"):
        fields.replaced(CM_25, {"soil.friction": 9.0})


def test_hyphens_and_dashes_are_spelling():
    assert fields.spelled(" --course.length-m ") == "course.length_m"


@pytest.mark.parametrize(
    ("path", "error", "says"),
    [
        ("soil.frction", UnknownName, "did you mean 'friction'"),
        ("soil", BadInput, "group of fields; name one of soil.preset"),
        ("seed.digits", BadInput, "beyond a plain value"),
        ("field.patches.0.length_m", UnknownName, "no field of tuple"),
    ],
)
def test_a_path_that_is_no_field(path, error, says):
    with pytest.raises(error, match=says):
        fields.kind(CM_25, path)


def test_a_path_through_nothing():
    from scenarios.road import GRASS_5

    with pytest.raises(BadInput, match=r"plough\.depth_m cannot be set"):
        fields.kind(GRASS_5, "plough.depth_m")
