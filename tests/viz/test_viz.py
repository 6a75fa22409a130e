from __future__ import annotations

import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.recordings import broken
from tests.synthetic_run import MJCF, synthetic_run, truth_table
from twin import viz
from twin.streams import Streams
from twin.terrain.grid import GridMap
from twin.trajectory.end import End, Outcome
from twin.viz import Ground, paths
from twin.viz.blueprint import kind
from twin.viz.bodies import Bodies, bodies
from twin.viz.events import drive_events, events
from twin.viz.furrows import Pass, worked_by
from twin.viz.ground import land, slices, worked
from twin.viz.shapes import Shapes, body_poses

MODEL = mujoco.MjModel.from_xml_string(MJCF)
RUN = synthetic_run(duration_s=8.0)
FOUR = Bodies(
    ahead_m=(-1.7, -2.55, -3.4, -4.25), left_m=(-0.4, -0.05, 0.3, 0.65), width_m=0.35, side=-1,
    wall_m=0.54, open_m=0.5,
)  # fmt: skip


def rerun(*args: str) -> str:
    program = shutil.which("rerun", path=str(Path(sys.executable).parent)) or shutil.which("rerun")
    if program is None:
        pytest.skip("the rerun program is not on the path")
    done = subprocess.run([program, "rrd", *args], capture_output=True, text=True, check=True)
    return done.stdout + done.stderr


def test_a_recording_is_whole_and_holds_what_is_shown(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    viz.record(RUN, path, model=MODEL)
    told = rerun("print", str(path))
    for entity in (
        f"{paths.TRACTOR}/tractor",
        f"{paths.TRACTOR}/rear_left", paths.PATH, paths.GROUND, paths.FURROW,
        f"{paths.SLIP}/truth", f"{paths.SLIP}/ekf4", f"{paths.SLIP}/ekf4/upper",
        f"{paths.SPEED}/truth",
        paths.DRAFT, paths.DEPTH, paths.EVENTS, paths.NO_SIDESLIP, paths.GNSS,
        f"{paths.FORCES}/load", f"{paths.FORCES}/thrust", f"{paths.FORCES}/draft",
        f"{paths.SENSED_SPEED}/gnss", f"{paths.SENSED_SPEED}/wheels", f"{paths.FIX}/quality",
    ):  # fmt: skip
        assert f"/{entity}" in told
    assert path.stat().st_size < 2_000_000


def test_a_log_is_recorded_on_a_map(tmp_path: Path) -> None:
    path = tmp_path / "log.rrd"
    setup = replace(RUN.setup, origin=(45.35, 11.95, 10.0))
    viz.log(path, streams=RUN.streams, setup=setup, estimates=RUN.estimates)
    assert f"/{paths.MAP}" in rerun("print", str(path))


@pytest.mark.parametrize("kept", [0, 3, 5000])
def test_what_is_cut_short_is_no_recording(tmp_path: Path, kept: int) -> None:
    viz.log(tmp_path / "log.rrd", streams=Streams({}), setup=RUN.setup, estimates={})
    cut = tmp_path / "run.txt"
    cut.write_bytes((tmp_path / "log.rrd").read_bytes()[:kept])
    assert [line.split(":")[0] for line in broken([cut])] == [str(cut)]


def test_bodies_stand_where_truth_says() -> None:
    truth = truth_table(duration_s=2.0)
    position_w, world_from_body = body_poses(MODEL, truth)
    tractor, rear_left = MODEL.body("tractor").id, MODEL.body("rear_left").id
    np.testing.assert_allclose(position_w[:, tractor, 0], truth["east_m"], atol=1e-12)
    np.testing.assert_allclose(
        position_w[:, rear_left] - position_w[:, tractor], [[0, 0.8, 0]] * 101
    )
    turned_rad = 2.0 * np.arctan2(
        world_from_body[:, rear_left, 2], world_from_body[:, rear_left, 0]
    )
    np.testing.assert_allclose(np.unwrap(turned_rad, period=4 * np.pi), truth["joint_rl_spin_rad"])


def test_only_what_can_be_seen_and_moves_is_drawn() -> None:
    shapes = Shapes.of(MODEL)
    assert set(shapes.bodies.values()) == {
        "tractor", "rear_left", "rear_right", "front_left", "plough",
    }  # fmt: skip
    assert all(MODEL.geom_bodyid[g] == b for b, geoms in shapes.geoms.items() for g in geoms)


def test_a_run_without_a_model_still_shows_its_path(tmp_path: Path) -> None:
    viz.record(RUN, tmp_path / "run.rrd")
    assert f"/{paths.PATH}" in rerun("print", str(tmp_path / "run.rrd"))


def test_a_log_of_which_nothing_was_estimated_is_still_a_recording(tmp_path: Path) -> None:
    viz.log(tmp_path / "log.rrd", streams=Streams({}), setup=RUN.setup, estimates={})
    assert broken([tmp_path / "log.rrd"]) == []


def test_events_tell_what_happened_in_order() -> None:
    truth = truth_table(duration_s=20.0)
    truth["depth_m"][-100:], truth["ploughing"][-100:] = 0.0, False
    quality = np.full(len(RUN.streams["gnss"]["epoch_ns"]), 4)
    quality[30:40] = 5
    gnss = {**RUN.streams["gnss"], "quality": quality}
    driven = End(outcome=Outcome.DRIVEN, time_s=20.0, along_m=30.0, left_m=0.0, measured=30.0)
    found = sorted(events(truth, Streams({"gnss": gnss}), None, driven))
    assert [e.text for e in found] == [
        "GNSS float", "GNSS fixed again", "plough in the ground", "full depth, 25 cm", "plough out",
        "course driven",
    ]  # fmt: skip
    assert [e.level for e in found][:2] == ["WARN", "INFO"]
    assert found[-1].level == "INFO"
    stuck = replace(driven, outcome=Outcome.STUCK, measured=0.9)
    *_, last = sorted(events(truth, Streams({}), None, stuck))
    assert (last.text, last.level) == (str(stuck), "ERROR")


def test_odometry_that_works_from_the_start_is_no_event() -> None:
    epoch_ns = np.arange(4, dtype=np.int64) * 10**9
    for used, told in (([0, 1, 1, 1], 0), ([0, 1, 0, 1], 2), ([0, 0, 1, 1], 2)):
        camera = Streams({"camera": {"epoch_ns": epoch_ns, "used": np.array(used)}})
        found = [e for e in events(truth_table(duration_s=2.0), camera, None) if "way" in e.text]
        assert len(found) == told


def test_a_drive_tells_its_notes_and_where_it_stands() -> None:
    speed = np.repeat([0.0, 2.0, 0.05, 2.0, 0.0], [20, 10, 5, 5, 12])
    gnss = {
        "epoch_ns": np.arange(len(speed), dtype=np.int64) * 10**9,
        "v_east_mps": speed, "v_north_mps": 0.0 * speed, "quality": np.full(len(speed), 4),
    }  # fmt: skip
    told = [(e.epoch_ns // 10**9, e.text) for e in drive_events(Streams({"gnss": gnss}), ["a gap"])]
    assert told == [(0, "a gap"), (0, "stands for 20 s"), (20, "drives"), (40, "stands for 11 s")]


def test_a_rock_is_told_and_ripple_is_not() -> None:
    truth = truth_table(duration_s=20.0)
    rocky = SimpleNamespace(soil=SimpleNamespace(rocks_per_100m2=2.0, rock_kn=15.0))
    assert not [e for e in events(truth, Streams({}), rocky) if "rock" in e.text]
    truth["draft_n"][700:708] += 14000.0
    told = [e for e in events(truth, Streams({}), rocky) if "rock" in e.text]
    assert [(e.epoch_ns, e.level) for e in told] == [(truth["epoch_ns"][700], "WARN")]


def test_the_screen_suits_the_run() -> None:
    truth, gnss = dict(RUN.truth or {}), RUN.streams["gnss"]
    sky = Streams({"gnss": gnss})
    lost = Streams({"gnss": {**gnss, "quality": np.full(len(gnss["epoch_ns"]), 1)}})
    bare = {**truth, "depth_m": np.zeros(len(truth["epoch_ns"]))}
    steep = SimpleNamespace(field=SimpleNamespace(cross_slope_deg=9.0))
    given = [
        (truth, sky, None), (truth, lost, None), (truth, sky, steep), (bare, sky, steep),
        (bare, sky, None),
    ]  # fmt: skip
    suits = ["ploughing", "masked", "ploughing a slope", "slope", "road"]
    assert [kind(*each) for each in given] == suits


def test_the_ground_is_where_its_map_and_its_slope_are() -> None:
    turn = np.array([[1.0, 0.0, 0.0], [0.0, 0.8, -0.6], [0.0, 0.6, 0.8]])
    nodes = np.array([[0.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.0]])
    heights = GridMap(nodes, 1.0, -1.0, -1.0, repeats=False)
    ground = Ground(world_from_ground=turn, maps={"heights": heights})
    points = ground.surface_w(np.array([0.0, 0.0]), np.array([0.0, 1.0]))
    # at the node 3/4 of each way of its own height, at the next one 1/8 of the one and 3/4
    at_node, beside = 0.75 * 0.75 * 0.5, 0.75 * 0.125 * 0.5
    expected = [at_node * turn[:, 2], turn[:, 1] + beside * turn[:, 2]]
    np.testing.assert_allclose(points, expected, atol=1e-12)


def test_each_pass_leaves_its_furrow_for_the_next() -> None:
    there = truth_table(duration_s=20.0)
    back = {name: column.copy() for name, column in there.items()}
    back["epoch_ns"] += 20 * 10**9
    back["east_m"], back["north_m"] = there["east_m"][::-1], there["north_m"] + 1.4
    for table in (there, back):
        table["depth_m"][-50:] = 0.0  # raised before the turn
    both = {name: np.concatenate([there[name], back[name]]) for name in there}
    plough = SimpleNamespace(furrow="right", depth_m=0.25)
    ploughed = SimpleNamespace(plough=plough, course=SimpleNamespace(approach_m=5.0))
    (first, there_m), (second, back_m) = worked(both, ploughed, Ground(bodies=FOUR))
    assert second.wall_m - first.wall_m == pytest.approx(1.4)
    assert first.from_ns == both["epoch_ns"][0]
    assert 18e9 < second.from_ns < 20e9
    assert second.high_m < np.inf
    assert np.all(np.diff(there_m.s_m) > 0.0)
    assert np.all(np.diff(back_m.s_m) < 0.0)


def test_slices_are_thrown_into_the_furrow_and_only_where_it_ploughs() -> None:
    truth = truth_table(duration_s=20.0)
    rows, centre, _, _ = slices(truth, Ground(), FOUR)
    assert np.all(truth["depth_m"][rows] > 0.05)
    assert np.all(truth["epoch_ns"][rows] > 5e9)
    aside = centre[:, :, 1] - truth["north_m"][rows][:, None]
    np.testing.assert_allclose(aside[-1], np.array(FOUR.left_m) - 0.5)  # to the right by a furrow
    assert np.all(aside[:, 0] + 0.5 * FOUR.width_m < -FOUR.wall_m)  # the first into the last furrow


def test_slices_lean_away_from_the_land_and_stand_on_the_sole() -> None:
    truth = truth_table(duration_s=20.0)
    _, centre, half_m, xyzw = slices(truth, Ground(), FOUR)
    turn = Rotation.from_quat(xyzw[-1, 0]).as_matrix()
    up = turn[2, 1] / turn[1, 1]  # of the slice's width, to the left
    assert np.arctan(up) == pytest.approx(-np.arcsin(0.25 / 0.35))  # rises to the right
    lowest = centre[-1, :, 2] - np.abs(turn[2]) @ half_m[-1, 0]
    np.testing.assert_allclose(lowest, -0.25, atol=1e-9)


def test_land_lies_where_the_bodies_will_cut_up_to_the_wall() -> None:
    truth = truth_table(duration_s=20.0)
    rows, centre, half_m, _ = land(truth, RUN.scenario, Ground(), FOUR)
    aside = centre[-1, :, 1] - truth["north_m"][rows[-1]]
    low, high = aside - half_m[-1, :, 1], aside + half_m[-1, :, 1]
    assert low[0] == pytest.approx(-FOUR.wall_m)
    assert high[-1] == pytest.approx(FOUR.left_m[-1] + 0.175)
    np.testing.assert_allclose(low[1:], high[:-1], atol=1e-9)  # one beside the other
    np.testing.assert_allclose(centre[..., 2] + half_m[..., 2], 0.0, atol=1e-12)


def test_behind_the_plough_all_is_turned_but_the_last_furrow() -> None:
    done = Pass(s_m=np.array([0.0, 20.0]), t_m=np.zeros(2))
    t = np.linspace(-2.0, 2.0, 401)
    height, here, open_ = worked_by(done, FOUR, 0.25, np.full_like(t, 5.0), t)
    edges = t[here].min(), t[open_].min(), t[open_].max()
    np.testing.assert_allclose(edges, (-1.125, 0.325, 0.825), atol=0.011)
    assert np.all(height[open_] == -0.25)
    assert np.all(height[here & ~open_] >= 0.0)
    assert np.all(height[~here] == 0.0)
    ahead = worked_by(done, FOUR, 0.25, np.full_like(t, 19.0), t)
    assert not ahead[1].any()  # where no body has been yet
    between = worked_by(done, FOUR, 0.25, np.full_like(t, 17.9), t)
    assert np.ptp(t[between[2]]) == pytest.approx(0.5, abs=0.02)  # behind the first body alone


@pytest.mark.parametrize(("count", "width_m"), [(1, 0.5), (3, 0.4), (5, 0.33)])
def test_slices_are_as_many_and_as_wide_as_the_bodies(count: int, width_m: float) -> None:
    truth = truth_table(duration_s=20.0)
    left_m = np.arange(count) * width_m - 0.4
    own = replace(
        FOUR, ahead_m=tuple(-1.0 - 0.9 * i for i in range(count)), left_m=tuple(left_m),
        width_m=width_m,
    )  # fmt: skip
    _, centre, half_m, _ = slices(truth, Ground(), own)
    aside = centre[:, :, 1] - truth["north_m"][truth["depth_m"] > 0.05][:, None]
    assert centre.shape[1] == half_m.shape[1] == count
    np.testing.assert_allclose(aside[:, 0], -0.4 - 0.5, atol=1e-9)  # thrown by one furrow
    np.testing.assert_allclose(np.diff(aside, axis=1), width_m)


def test_the_bodies_are_those_of_the_model() -> None:
    drawn = bodies(MODEL)
    assert drawn == Bodies(
        ahead_m=(-2.0, -2.9), left_m=(-0.225, 0.225), width_m=0.45, side=-1, wall_m=0.45,
        open_m=0.45,
    )  # fmt: skip
    assert bodies(mujoco.MjModel.from_xml_string("<mujoco/>")) is None
