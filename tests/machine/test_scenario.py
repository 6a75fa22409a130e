"""Every field of a scenario is refused by name where it means nothing."""

import math

import pytest

from twin.errors import OutOfRange, UnknownName
from twin.scenario import Course, Drive, Field, Plough, Scenario, Soil

LIMITS = [
    (Soil, "soil.friction", 0.05, 1.5),
    (Soil, "soil.cone_index_kpa", 50.0, 5000.0),
    (Soil, "soil.draft_scale", 0.0, 2.0),
    (Soil, "soil.draft_cv", 0.0, 0.5),
    (Soil, "soil.draft_length_m", 0.2, 100.0),
    (Field, "field.cross_slope_deg", -25.0, 25.0),
    (Field, "field.grade_deg", -15.0, 15.0),
    (Plough, "plough.depth_m", 0.05, 0.35),
    (Plough, "plough.wheel_share", 0.0, 1.0),
    (Drive, "drive.gear_ratio", 15.0, 300.0),
    (Drive, "drive.engine_set_rpm", 900.0, 2376.0),
    (Course, "course.approach_m", 1.0, 500.0),
    (Course, "course.length_m", 1.0, 5000.0),
    (Course, "course.heading_deg", -180.0, 180.0),
]


@pytest.mark.parametrize(("part", "name", "low", "high"), LIMITS)
def test_a_value_out_of_its_range_is_refused_by_name_with_the_range(part, name, low, high):
    own = name.split(".")[1]
    step = 1e-3 * (high - low)
    for value in (low - step, high + step, math.nan, math.inf, -math.inf):
        with pytest.raises(OutOfRange) as refused:
            part(**{own: value})
        assert str(refused.value).startswith(f"{name} = {value:g} is outside [")
        assert f"[{low:g}, {high:g}]" in str(refused.value)
    for value in (low, high):
        assert getattr(part(**{own: value}), own) == value


def test_no_numeric_field_is_left_unchecked():
    checked = {name.split(".")[1] for _, name, *_ in LIMITS}
    for part in (Soil, Field, Plough, Drive, Course):
        numeric = {n for n, t in part.__annotations__.items() if "float" in str(t)}
        assert numeric <= checked


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Soil(preset="frim"), "no soil preset is called 'frim'; did you mean 'firm'?"),
        (lambda: Soil(law="brixus"), "no soil law is called 'brixus'; did you mean 'brixius'?"),
        (lambda: Field(roughness_class="z"), "no roughness class is called 'z'"),
        (lambda: Scenario(name="x", machine="taishan"), "no machine is called 'taishan'"),
    ],
)
def test_a_wrong_name_is_refused_with_the_right_ones(make, message):
    with pytest.raises(UnknownName) as refused:
        make()
    assert str(refused.value).startswith(message)


@pytest.mark.parametrize("seed", [-1, 2**31])
def test_a_seed_the_ground_cannot_hash_is_refused(seed):
    with pytest.raises(OutOfRange, match="seed"):
        Scenario(name="x", seed=seed)
