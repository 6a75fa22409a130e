"""The MJCF as it stands: every scene in plain MuJoCo, and the numbers the models promise."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from scenarios.plough import CM_25
from twin.machine.build import Machine
from twin.machine.join import joined
from twin.machine.start import RAISED_RAD
from twin.physics import block
from twin.physics.block import MachineSlot, WheelSlot
from twin.scenario import Field, Plough
from twin.simulation.build import build
from twin.vehicle import files

MODELS = Path(__file__).parents[2] / "models"
SCENES = sorted(MODELS.glob("*/scene.xml"))
FOLDERS = sorted(path for path in MODELS.iterdir() if path.is_dir())
GRADES = ("measured", "published", "assumed", "derived")
VISUAL, COLLISION = 2, 3
FRONT, REAR = ("fl", "fr"), ("rl", "rr")


def named(paths: list[Path]) -> dict[str, Any]:
    return {"argvalues": paths, "ids": [str(path.relative_to(MODELS)) for path in paths]}


def geoms(model: Any, group: int) -> np.ndarray:
    return np.flatnonzero(model.geom_group == group)


def cylinders(model: Any) -> np.ndarray:
    """The rims that plain MuJoCo rolls on."""
    round_ones = model.geom_type == mujoco.mjtGeom.mjGEOM_CYLINDER
    return np.flatnonzero(round_ones & (model.geom_contype != 0))


# --- every scene in plain MuJoCo ------------------------------------------------------------


def test_there_are_scenes_to_look_at() -> None:
    assert {path.parent.name for path in SCENES} >= {"taishan_1404a", "plough_1lf435", "field"}


@pytest.mark.parametrize("scene", **named(SCENES))
def test_a_scene_stands_whatever_its_controls_do(scene: Path) -> None:
    model = mujoco.MjModel.from_xml_path(str(scene))
    state, random = mujoco.MjData(model), np.random.default_rng(7)
    low, high = model.actuator_ctrlrange.T
    rims = cylinders(model)
    mujoco.mj_forward(model, state)
    start_m = state.geom_xpos[rims, 2].copy()
    for _ in range(20):
        state.ctrl[:] = random.uniform(low, high)
        mujoco.mj_step(model, state, round(0.05 / model.opt.timestep))
        hub_m = state.geom_xpos[rims, 2]
        assert np.all(hub_m > 0.9 * model.geom_size[rims, 0]), "a wheel is sinking in"
        assert np.all(hub_m < start_m + 1.2), "a wheel has left the ground for good"
        free = model.jnt_qposadr[model.jnt_type == mujoco.mjtJoint.mjJNT_FREE]
        for address in free:
            upright = 1.0 - 2.0 * np.sum(state.qpos[address + 4 : address + 6] ** 2)
            assert upright > np.cos(0.25), "the machine is falling over"
    assert not np.any(state.warning.number)
    assert np.all(np.isfinite(state.qpos))


@pytest.mark.parametrize("scene", **named(SCENES))
def test_a_scene_opens_by_a_relative_path(scene: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(MODELS.parent)
    assert mujoco.MjModel.from_xml_path(str(scene.relative_to(MODELS.parent))).ngeom > 0


@pytest.mark.parametrize("scene", **named(SCENES))
def test_looks_weigh_nothing_and_move_nothing(scene: Path) -> None:
    spec = mujoco.MjSpec.from_file(str(scene))
    dressed = spec.compile()
    seen = geoms(dressed, VISUAL)
    assert not np.any(dressed.geom_contype[seen] | dressed.geom_conaffinity[seen])
    bare_spec = mujoco.MjSpec.from_file(str(scene))
    bare_spec.compiler.discardvisual = True
    bare = bare_spec.compile()
    np.testing.assert_array_equal(bare.body_mass, dressed.body_mass)
    np.testing.assert_array_equal(bare.body_inertia, dressed.body_inertia)
    states = [mujoco.MjData(model) for model in (dressed, bare)]
    for model, state in zip((dressed, bare), states, strict=True):
        mujoco.mj_step(model, state, 100)
    np.testing.assert_array_equal(states[0].qpos, states[1].qpos)


def test_a_machine_is_something_to_look_at() -> None:
    model = mujoco.MjModel.from_xml_path(str(MODELS / "taishan_1404a" / "scene.xml"))
    assert 90 < len(geoms(model, VISUAL)) < 250
    dressed = {model.body(model.geom_bodyid[g]).name for g in geoms(model, VISUAL)}
    assert {f"taishan_1404a/{wheel}_wheel" for wheel in block.WHEELS} < dressed


def test_the_drawing_has_the_published_outline_within_a_tenth() -> None:
    """Tractor on loaded tyres with its linkage, and plough (Fu et al., Table 1)."""
    low, high = drawn_box(MODELS / "taishan_1404a" / "taishan_1404a.xml")
    length_m, width_m, _ = high - low
    height_m = high[2] + 0.8375
    np.testing.assert_allclose([length_m, width_m, height_m], [5.0, 2.51, 3.115], rtol=0.1)
    low, high = drawn_box(MODELS / "plough_1lf435" / "plough_1lf435.xml")
    np.testing.assert_allclose(high - low, [4.0, 1.6, 1.85], rtol=0.1)


def drawn_box(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the box about the visual geoms, in the frame of the model's root body."""
    model = mujoco.MjModel.from_xml_path(str(path))
    state = mujoco.MjData(model)
    mujoco.mj_forward(model, state)
    points = [extremes(model, state, g) - state.xpos[1] for g in geoms(model, VISUAL)]
    corners = np.concatenate(points)
    return corners.min(axis=0), corners.max(axis=0)


def extremes(model: Any, state: Any, g: int) -> np.ndarray:
    """Points of a geom among which are its outermost along the world's axes. Shape (n, 3)."""
    turn, size, kinds = state.geom_xmat[g].reshape(3, 3), model.geom_size[g], mujoco.mjtGeom
    if model.geom_type[g] == kinds.mjGEOM_MESH:
        mesh = model.geom_dataid[g]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        return np.asarray(model.mesh_vert[first : first + count] @ turn.T + state.geom_xpos[g])
    axis = turn[:, 2]
    half = {
        kinds.mjGEOM_BOX: np.abs(turn) @ size,
        kinds.mjGEOM_CAPSULE: np.abs(axis) * size[1] + size[0],
        kinds.mjGEOM_CYLINDER: np.abs(axis) * size[1]
        + size[0] * np.sqrt(np.maximum(1.0 - axis**2, 0.0)),
    }[kinds(int(model.geom_type[g]))]
    return np.asarray(state.geom_xpos[g] + np.array([[-1.0], [1.0]]) * half)


# --- the numbers the models promise ---------------------------------------------------------


@pytest.fixture(scope="module")
def tractor() -> tuple[Any, Any]:
    spec, _ = joined(files.machine("taishan_1404a"), files.implement("plough_1lf435"))
    model = spec.compile()
    state = mujoco.MjData(model)
    mujoco.mj_forward(model, state)
    return model, state


def centre_of_mass(model: Any, state: Any, *, of_plough: bool) -> tuple[float, np.ndarray]:
    """Mass and centre of mass of the plough, or of all else."""
    belongs = [model.body(b).name.startswith("plough.") == of_plough for b in range(model.nbody)]
    mass = model.body_mass * belongs
    return float(mass.sum()), mass @ state.xipos / mass.sum()


def test_masses_are_the_published_ones(tractor: tuple[Any, Any]) -> None:
    assert centre_of_mass(*tractor, of_plough=False)[0] == pytest.approx(5260.0, abs=0.01)
    assert centre_of_mass(*tractor, of_plough=True)[0] == pytest.approx(1470.0, abs=0.01)


def test_the_site_cg_is_the_centre_of_mass_without_plough(tractor: tuple[Any, Any]) -> None:
    model, state = tractor
    _, centre = centre_of_mass(model, state, of_plough=False)
    assert np.linalg.norm(centre - state.site_xpos[model.site("cg").id]) < 0.01


def test_wheelbase_and_tracks(tractor: tuple[Any, Any]) -> None:
    model, state = tractor
    fl, fr, rl, rr = (state.xpos[model.body(f"{w}_wheel").id] for w in block.WHEELS)
    np.testing.assert_allclose((fl - rl)[0], 2.55, atol=1e-9)
    np.testing.assert_allclose((fr - rr)[0], 2.55, atol=1e-9)
    np.testing.assert_allclose([(fl - fr)[1], (rl - rr)[1]], 1.80, atol=1e-9)


def test_shares_cut_side_by_side(tractor: tuple[Any, Any]) -> None:
    """Four furrows of 0.35 m: 1.40 m, about the tractor's middle."""
    model, _ = tractor
    shares = np.array([model.site(f"plough.share_{i}").pos for i in (1, 2, 3, 4)])
    np.testing.assert_allclose(np.diff(shares[:, 1]), -0.35, atol=1e-9)
    np.testing.assert_allclose(shares[:, 1].mean(), 0.0, atol=1e-9)


# --- axle loads in the loader ---------------------------------------------------------------


@pytest.fixture(scope="module", params=[0.15, 0.25])
def machine(request: pytest.FixtureRequest) -> Machine:
    return build(replace(CM_25, plough=Plough(depth_m=request.param), field=Field()))


def at_rest(machine: Machine, lift_rad: float, seconds: float) -> Any:
    """State with the brakes on after a while; its slots describe the state itself."""
    model = machine.model
    state = mujoco.MjData(model)
    state.qpos[:] = machine.start_qpos
    for control, value in (("brake", 1.0), ("clutch_pedal", 1.0), ("lift", lift_rad)):
        state.ctrl[model.actuator(control).id] = value
    mujoco.mj_step(model, state, round(seconds / model.opt.timestep))
    mujoco.mj_forward(model, state)
    return state


def loads_n(state: Any, wheels: tuple[str, ...]) -> float:
    first = [block.WHEELS.index(w) * WheelSlot.SIZE + WheelSlot.LOAD_N for w in wheels]
    return float(state.userdata[first].sum())


def machine_slot(state: Any, slot: MachineSlot) -> float:
    return float(state.userdata[block.MACHINE_SLOTS + slot])


def hub_x(machine: Machine, state: Any, wheels: tuple[str, ...]) -> float:
    return float(np.mean([state.xpos[machine.model.body(f"{w}_wheel").id, 0] for w in wheels]))


def weight_moment_nm(machine: Machine, state: Any, about_x_m: float) -> tuple[float, float]:
    """Weight of tractor and plough, and its moment about a line across."""
    weight, moment = 0.0, 0.0
    for of_plough in (False, True):
        mass, centre = centre_of_mass(machine.model, state, of_plough=of_plough)
        weight += 9.81 * mass
        moment += 9.81 * mass * (centre[0] - about_x_m)
    return weight, moment


def test_axle_loads_with_the_plough_raised(machine: Machine) -> None:
    state = at_rest(machine, RAISED_RAD, 2.0)
    front_x, rear_x = hub_x(machine, state, FRONT), hub_x(machine, state, REAR)
    weight_n, moment_nm = weight_moment_nm(machine, state, rear_x)
    front_n = moment_nm / (front_x - rear_x)
    assert machine_slot(state, MachineSlot.DEPTH_WHEEL_N) == 0.0
    assert loads_n(state, FRONT) == pytest.approx(front_n, rel=0.01)
    assert loads_n(state, REAR) == pytest.approx(weight_n - front_n, rel=0.01)
    assert front_n > 0.0


def test_axle_loads_with_the_plough_standing_in_the_ground(machine: Machine) -> None:
    state = at_rest(machine, machine.work_rad, 12.0)
    model = machine.model
    front_x, rear_x = hub_x(machine, state, FRONT), hub_x(machine, state, REAR)
    weight_n, moment_nm = weight_moment_nm(machine, state, rear_x)
    wheel_n = machine_slot(state, MachineSlot.DEPTH_WHEEL_N)
    wheel_x = state.xpos[model.body("plough.depth_wheel").id, 0]
    soil_n = wheel_n - machine_slot(state, MachineSlot.DRAFT_Z_N)  # downward, at the shares
    shares_x = [state.site_xpos[model.site(f"plough.share_{i}").id, 0] for i in (1, 2, 3, 4)]
    moment_nm += soil_n * (np.mean(shares_x) - rear_x) - wheel_n * (wheel_x - rear_x)
    front_n = moment_nm / (front_x - rear_x)
    assert wheel_n > 1000.0
    assert machine_slot(state, MachineSlot.DEPTH_M) > 0.1
    assert loads_n(state, FRONT) == pytest.approx(front_n, rel=0.01)
    assert loads_n(state, REAR) == pytest.approx(weight_n + soil_n - wheel_n - front_n, rel=0.01)


# --- papers ---------------------------------------------------------------------------------


@pytest.mark.parametrize("folder", **named(FOLDERS))
def test_a_model_tells_where_its_numbers_come_from(folder: Path) -> None:
    readme = (folder / "README.md").read_text(encoding="utf-8")
    assert "MuJoCo" in readme
    assert any(grade in readme for grade in GRADES)
    assert (folder / "CHANGELOG.md").read_text(encoding="utf-8").startswith("# Changelog")


@pytest.mark.parametrize("folder", **named(FOLDERS))
def test_every_numeric_has_its_row_with_a_grade(folder: Path) -> None:
    readme = (folder / "README.md").read_text(encoding="utf-8")
    rows = {m[1]: m[0] for m in re.finditer(r"^\| `([\w.]+)` \|.*$", readme, flags=re.M)}
    for path in folder.glob("*.xml"):
        for name, number in re.findall(
            r'<numeric name="([\w.]+)" data="([^"]+)"', path.read_text(encoding="utf-8")
        ):
            assert name in rows, f"{name} is not in {folder.name}/README.md"
            cells = [cell.strip() for cell in rows[name].strip("|").split("|")]
            assert float(cells[1]) == float(number), f"{name}: the README says {cells[1]}"
            assert any(grade in rows[name] for grade in GRADES), f"{name} has no grade"
