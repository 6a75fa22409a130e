"""Maps of a scenario: from a seed or a file, in the model, and what is refused."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from scipy.fft import next_fast_len

from tests.simulation.rigs import BARE, driven
from twin.errors import BadInput
from twin.physics import block
from twin.scenario import Course, Field, Soil
from twin.simulation.build import build
from twin.terrain import maps
from twin.terrain.maps import ground_maps

FLAT = Field(roughness_class="smooth")


def saved(folder, nodes, name="map.npy"):
    np.save(folder / name, nodes)
    return str(folder / name)


def test_the_same_seed_makes_the_same_ground_and_another_another():
    rough = replace(BARE, field=Field(roughness_class="C", other_share=0.3))
    first, again = ground_maps(rough), ground_maps(rough)
    other = ground_maps(replace(rough, seed=1))
    for name in ("heights", "mixture"):
        assert np.array_equal(first[name].nodes, again[name].nodes)
        assert not np.array_equal(first[name].nodes, other[name].nodes)
    assert ground_maps(replace(BARE, field=FLAT)) == {}


def test_the_model_carries_the_heights_and_shows_them_where_the_laws_find_them():
    slope = Field(roughness_class="D", cross_slope_deg=8.0, grade_deg=-3.0)
    machine = build(replace(BARE, field=slope), looks=True)
    model, heights = machine.model, machine.maps["heights"]
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    geom = model.geom("terrain").id
    rotation = machine.world_from_ground
    for s, t in ((0.0, 0.0), (7.3, 2.2), (31.0, -4.0)):
        place = rotation @ [s, t, float(heights.at(np.array([s]), np.array([t]))[0])]
        above = place + 2.0 * rotation[:, 2]
        distance = mujoco.mj_rayHfield(
            model, data, geom, above, -rotation[:, 2].copy(), np.zeros(3)
        )
        assert distance == pytest.approx(2.0, abs=0.01)


def test_a_users_hill_carries_the_tractor(tmp_path):
    """A plane that rises 3 % to the left and 2 % ahead, as a map: the tractor stands on it so."""
    cell_m = 0.5
    t, s = np.mgrid[-40:41, -40:161] * cell_m
    hill = saved(tmp_path, 0.02 * s + 0.03 * t + 1.0)
    field = Field(height_map=hill, map_cell_m=cell_m, map_start_m=-20.0)
    machine = build(replace(BARE, field=field, course=Course(approach_m=5.0, length_m=20.0)))
    columns = driven(machine.scenario)
    place = columns["position_w"][-1]
    w, x, y, z = columns["world_from_body"][-1]
    up = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    normal = np.array([-0.02, -0.03, 1.0]) / np.hypot(1.0, np.hypot(0.02, 0.03))
    assert up == pytest.approx(normal, abs=0.004)
    ground_m = 0.02 * place[0] + 0.03 * place[1] + 1.0
    assert 0.7 < place[2] - ground_m < 0.95  # the rear axle's height on its tyres


def test_a_map_of_soil_is_felt_where_it_lies(tmp_path):
    """Half of the grip from 10 m on: the slip of the same pull grows there."""
    shares = np.zeros((3, 61))
    shares[:, 20:] = 1.0  # from s = 10 m
    field = Field(
        soil_map=saved(tmp_path, shares), map_cell_m=1.0, map_start_m=-10.0,
        other_soil=Soil(preset="soft", strength_cv=0.0),
    )  # fmt: skip
    course = Course(approach_m=0.0, length_m=25.0)
    scenario = replace(BARE, field=field, course=course, soil=Soil(strength_cv=0.0))
    columns = driven(scenario)
    along, rolling = columns["position_w"][:, 0], columns["resistance_n"].sum(axis=1)
    before, after = (along > 4.0) & (along < 7.0), along > 15.0
    soft = driven(replace(scenario, field=FLAT, soil=Soil(preset="soft", strength_cv=0.0)))
    late = soft["position_w"][:, 0] > 15.0
    assert rolling[after].mean() == pytest.approx(
        soft["resistance_n"].sum(axis=1)[late].mean(), rel=0.01
    )
    assert rolling[after].mean() > 1.2 * rolling[before].mean()


@pytest.mark.parametrize(
    ("nodes", "message"),
    [
        (np.zeros(5), r"holds \(5,\); rows and columns"),
        (np.zeros((1, 5)), r"holds \(1, 5\)"),
        (np.array([["a", "b"], ["c", "d"]]), "of type <U1"),
        (np.array([[0.0, np.nan], [0.0, 0.0]]), r"nan at row 0, column 1 is outside \[-10, 10\]"),
        (np.array([[0.0, 0.0], [0.0, 20.0]]), r"20 at row 1, column 1 is outside \[-10, 10\]"),
        (np.array([[0.0, 1.0], [0.0, 1.0]]), "has a step of 1 m between nodes 0.25 m apart; 0.125"),
    ],
)
def test_a_map_that_cannot_be_used_is_refused_by_name(tmp_path, nodes, message):
    scenario = replace(BARE, field=Field(height_map=saved(tmp_path, nodes)))
    with pytest.raises(BadInput, match=message) as refusal:
        build(scenario)
    assert str(tmp_path) in str(refusal.value)


def test_files_that_are_no_arrays_are_refused(tmp_path):
    (tmp_path / "text.npy").write_text("heights")
    for name, message in (("text.npy", "cannot be read"), ("none.npy", "No such file")):
        with pytest.raises(BadInput, match=message):
            build(replace(BARE, field=Field(soil_map=str(tmp_path / name))))


def test_a_flat_map_is_a_plane(tmp_path):
    flat = replace(BARE, field=Field(height_map=saved(tmp_path, np.full((4, 4), 0.25))))
    machine = build(flat)
    part = machine.model.numeric_data[-block.SIZE :][block.FIELD :]
    assert part[block.Field.HEIGHTS + block.Grid.RANGE] == 0.0
    on_plane = build(replace(BARE, field=FLAT))
    assert machine.start_qpos[2] - on_plane.start_qpos[2] == pytest.approx(0.25, abs=1e-6)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"height_map": "a.npy", "roughness_class": "C"}, "leave one of them"),
        ({"soil_map": "a.npy", "other_share": 0.2}, "leave one of them"),
        ({"other_share": 1.5}, r"field.other_share = 1.5 is outside \[0, 0.9\]"),
    ],
)
def test_two_sources_of_one_map_are_refused(given, message):
    with pytest.raises(Exception, match=message):
        Field(**given)


@pytest.mark.parametrize("count", [1, 7, 97, 1001, 4099])
def test_sizes_are_those_whose_transform_is_fast(count: int) -> None:
    assert maps._fast(count) == next_fast_len(count, real=True)
