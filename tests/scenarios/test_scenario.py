"""Every field of a scenario is refused by name where it means nothing."""

import math
from dataclasses import replace

import pytest

from twin.errors import OutOfRange, UnknownName
from twin.scenario import Course, Drive, Driver, Field, Patch, Plough, Scenario, Soil
from twin.scenario.soil import DEFORMABLE_RANGES
from twin.scenario.soils import PRESETS

LIMITS = [
    (Soil, "soil.friction", 0.05, 1.5),
    (Soil, "soil.cone_index_kpa", 50.0, 5000.0),
    (Soil, "soil.draft_scale", 0.0, 2.0),
    (Soil, "soil.draft_cv", 0.0, 0.5),
    (Soil, "soil.draft_length_m", 0.2, 100.0),
    (Soil, "soil.ripple_cv", 0.0, 0.5),
    (Soil, "soil.strength_cv", 0.0, 0.3),
    (Soil, "soil.rocks_per_100m2", 0.0, 25.0),
    (Soil, "soil.rock_kn", 0.0, 50.0),
    (Soil, "soil.k_c_kn_per_m_n1", 0.0, 1000.0),
    (Soil, "soil.k_phi_kn_per_m_n2", 10.0, 1e5),
    (Soil, "soil.sinkage_exponent", 0.1, 1.6),
    (Soil, "soil.cohesion_kpa", 0.0, 150.0),
    (Soil, "soil.friction_angle_deg", 0.0, 50.0),
    (Soil, "soil.shear_modulus_m", 0.002, 0.2),
    (Soil, "soil.lateral_shear_ratio", 0.2, 5.0),
    (Soil, "soil.unit_weight_knpm3", 0.0, 25.0),
    (Soil, "soil.stress_peak", 0.0, 0.8),
    (Soil, "soil.stress_peak_slip", 0.0, 0.5),
    (Soil, "soil.slip_sinkage", 0.0, 5.0),
    (Patch, "patch.start_m", -20000.0, 10000.0),
    (Patch, "patch.length_m", 0.5, 40000.0),
    (Patch, "patch.friction_factor", 0.1, 2.0),
    (Patch, "patch.cone_index_factor", 0.1, 4.0),
    (Field, "field.cross_slope_deg", -25.0, 25.0),
    (Field, "field.grade_deg", -15.0, 15.0),
    (Field, "field.map_cell_m", 0.02, 10.0),
    (Field, "field.map_start_m", -1000.0, 1000.0),
    (Field, "field.other_share", 0.0, 0.9),
    (Field, "field.other_length_m", 1.0, 100.0),
    (Plough, "plough.depth_m", 0.01, 0.8),
    (Plough, "plough.wheel_share", 0.0, 1.0),
    (Plough, "plough.expected_draft_scale", 0.0, 2.0),
    (Plough, "plough.draft_mix", 0.0, 1.0),
    (Plough, "plough.sensitivity_rad", 0.01, 0.1),
    (Plough, "plough.drop_rate_radps", 0.05, 1.0),
    (Plough, "plough.upper_limit_rad", 0.4, 0.9),
    (Plough, "plough.deepest_m", 0.01, 0.9),
    (Plough, "plough.front_ballast_kg", 0.0, 1000.0),
    (Plough, "plough.top_link_drop_m", 0.0, 0.25),
    (Drive, "drive.gear_ratio", 5.0, 1000.0),
    (Drive, "drive.engine_set_rpm", 100.0, 9000.0),
    (Drive, "drive.gear_kmh", 0.5, 60.0),
    (Course, "course.approach_m", 0.0, 500.0),
    (Course, "course.start_left_m", -50.0, 50.0),
    (Course, "course.edge_m", 0.5, 100.0),
    (Course, "course.length_m", 1.0, 5000.0),
    (Course, "course.calibration_m", 5.0, 500.0),
    (Course, "course.heading_deg", -180.0, 180.0),
    (Course, "course.road_m", 0.0, 20000.0),
    (Driver, "driver.reaction_s", 0.0, 3.0),
    (Driver, "driver.headland_rpm", 100.0, 9000.0),
    (Driver, "driver.road_rpm", 100.0, 9000.0),
    (Driver, "driver.pause_s", 0.0, 30.0),
    (Driver, "driver.headland_rpm_sd", 0.0, 1000.0),
    (Driver, "driver.headland_kmh", 0.5, 20.0),
    (Driver, "driver.road_kmh", 1.0, 60.0),
    (Soil, "soil.k_c_kn_per_m_n1", 0.0, 1000.0),
    (Soil, "soil.k_phi_kn_per_m_n2", 10.0, 1e5),
    (Soil, "soil.sinkage_exponent", 0.1, 1.6),
    (Soil, "soil.cohesion_kpa", 0.0, 150.0),
    (Soil, "soil.friction_angle_deg", 0.0, 50.0),
    (Soil, "soil.shear_modulus_m", 0.002, 0.2),
    (Soil, "soil.lateral_shear_ratio", 0.2, 5.0),
    (Soil, "soil.unit_weight_knpm3", 0.0, 25.0),
    (Soil, "soil.stress_peak", 0.0, 0.8),
    (Soil, "soil.stress_peak_slip", 0.0, 0.5),
    (Soil, "soil.slip_sinkage", 0.0, 5.0),
]
NEEDED = {
    Patch: {"start_m": 10.0, "length_m": 5.0},
    Soil: {
        "k_c_kn_per_m_n1": 102.0,
        "k_phi_kn_per_m_n2": 5301.0,
        "sinkage_exponent": 0.793,
        "cohesion_kpa": 1.3,
        "friction_angle_deg": 31.1,
        "shear_modulus_m": 0.012,
    },
}
"""What a part cannot do without for all of its numbers to mean something."""


@pytest.mark.parametrize(("part", "name", "low", "high"), LIMITS)
def test_a_value_out_of_its_range_is_refused_by_name_with_the_range(part, name, low, high):
    own = name.split(".")[1]
    needed = NEEDED.get(part, {})
    step = 1e-3 * (high - low)
    for value in (low - step, high + step, math.nan, math.inf, -math.inf):
        with pytest.raises(OutOfRange) as refused:
            part(**needed | {own: value})
        assert str(refused.value).startswith(f"{name} = {value:g} is outside [")
        assert f"[{low:g}, {high:g}]" in str(refused.value)
    for value in (low, high):
        assert getattr(part(**needed | {own: value}), own) == value


def test_the_presets_own_numbers_are_in_range():
    """A soil checks only those that are its own."""
    deformable = [preset.deformable for preset in PRESETS.values() if preset.deformable]
    assert deformable
    for name, (low, high) in DEFORMABLE_RANGES.items():
        assert all(low <= getattr(one, name) <= high for one in deformable), name


def test_no_numeric_field_is_left_unchecked():
    checked = {name.split(".")[1] for _, name, *_ in LIMITS}
    for part in (Soil, Patch, Field, Plough, Drive, Course, Driver):
        numeric = {n for n, t in part.__annotations__.items() if "float" in str(t)}
        assert numeric <= checked


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Soil(preset="frim"), "no soil preset is called 'frim'; did you mean 'firm'?"),
        (lambda: Soil(law="brixus"), "no soil law is called 'brixus'; did you mean 'brixius'?"),
        (lambda: Field(roughness_class="z"), "no roughness class is called 'z'"),
        (lambda: Plough(furrow="rigth"), "no furrow side is called 'rigth'; did you mean 'right'?"),
        (lambda: Plough(hitch="darft"), "no hitch mode is called 'darft'; did you mean 'draft'?"),
        (lambda: Scenario(name="x", machine="taishan"), "no machine is called 'taishan'"),
    ],
)
def test_a_wrong_name_is_refused_with_the_right_ones(make, message):
    with pytest.raises(UnknownName) as refused:
        make()
    assert str(refused.value).startswith(message)


@pytest.mark.parametrize("set_rpm", [899.0, 2401.0])
def test_the_taishans_governor_is_set_within_its_own_range(set_rpm):
    with pytest.raises(OutOfRange, match=r"drive\.engine_set_rpm = \d+ is outside \[900, 2400\]"):
        Scenario(name="x", drive=Drive(engine_set_rpm=set_rpm))


@pytest.mark.parametrize("seed", [-1, 2**31])
def test_a_seed_the_ground_cannot_hash_is_refused(seed):
    with pytest.raises(OutOfRange, match="seed"):
        Scenario(name="x", seed=seed)


def test_a_time_step_is_one_of_three_and_patches_are_four_at_most():
    for step_s in (0.0005, 0.001, 0.002):
        assert Scenario(name="x", timestep_s=step_s).timestep_s == step_s
    with pytest.raises(OutOfRange, match=r"timestep_s = 0\.003"):
        Scenario(name="x", timestep_s=0.003)
    patches = (Patch(start_m=1.0, length_m=1.0),) * 5
    assert len(Field(patches=patches[:4]).patches) == 4
    with pytest.raises(OutOfRange, match=r"field\.patches = 5"):
        Field(patches=patches)


@pytest.mark.parametrize(
    ("others", "place"),
    [
        ([(0.0, 5.0, 4.0)], "10 to the end"),
        ([(5.0, 20.0, 4.0)], "the start to 5"),
        ([(-5.0, 6.0, 4.0), (6.0, 9.0, 4.0)], "between two others"),
        ([(0.0, 5.0, 4.0), (2.0, 9.0, 0.25)], "where a third begins"),
    ],
)
def test_a_patch_that_ends_leaves_the_others_to_be_checked(others, place):
    rows = [(0.0, 10.0, 0.1), *others]
    patches = tuple(Patch(start_m=s, length_m=n, cone_index_factor=f) for s, n, f in rows)
    with pytest.raises(OutOfRange, match=r"field\.patches\[[03]\].*soil\.cone_index_kpa = 450"):
        Scenario(name=place, soil=Soil(preset="soft"), field=Field(patches=patches))
    covered = (patches[0], replace(patches[0], start_m=-1.0, length_m=12.0, cone_index_factor=4.0))
    Scenario(name="covered", soil=Soil(preset="soft"), field=Field(patches=covered))


def test_patches_that_meet_multiply_in_the_ramps_between_them():
    hard = Soil(preset="firm", cone_index_kpa=2400.0)
    first = Patch(start_m=0.0, length_m=10.0, cone_index_factor=2.0)
    Scenario(name="one", soil=hard, field=Field(patches=(first,)))
    with pytest.raises(OutOfRange, match=r"cone_index_factor = 2\.25 at 10 m"):
        Scenario(name="two", soil=hard, field=Field(patches=(first, replace(first, start_m=10.0))))


def test_a_soil_at_the_end_of_its_range_may_have_a_patch_that_keeps_it_there():
    softest = Soil(preset="soft", cone_index_kpa=50.0)
    for start_m in (0.1, 7.3, 123.456):
        patch = Patch(start_m=start_m, length_m=1.7, cone_index_factor=2.0)
        Scenario(name="x", soil=softest, field=Field(patches=(patch,)))


def test_patches_are_held_to_the_ranges_of_the_other_soil_where_there_is_some():
    soft = Soil(preset="soft", cone_index_kpa=60.0)
    patches = (Patch(start_m=0.0, length_m=10.0, cone_index_factor=0.5),)
    alone = Field(patches=patches, other_soil=soft)
    firm = Soil(cone_index_kpa=1000.0)
    Scenario(name="all of the first", soil=firm, field=alone)
    with pytest.raises(OutOfRange, match=r"field\.patches\[0\].*field\.other_soil\.cone_index_kpa"):
        Scenario(name="both", soil=firm, field=replace(alone, other_share=0.3))
