from __future__ import annotations

import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from synthetic_run import MJCF, synthetic_run, truth_table

from twin import viz
from twin.streams import Streams
from twin.viz import paths
from twin.viz.shapes import Shapes, body_poses

MODEL = mujoco.MjModel.from_xml_string(MJCF)
RUN = synthetic_run(duration_s=8.0)


def rerun(*args: str) -> str:
    program = shutil.which("rerun", path=str(Path(sys.executable).parent)) or shutil.which("rerun")
    if program is None:
        pytest.skip("the rerun program is not on the path")
    done = subprocess.run([program, "rrd", *args], capture_output=True, text=True, check=True)
    return done.stdout + done.stderr


def test_a_recording_is_whole_and_holds_what_is_shown(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    viz.record(RUN, path, model=MODEL)
    assert "verified without error" in rerun("verify", str(path))
    told = rerun("print", str(path))
    for entity in (
        f"{paths.TRACTOR}/tractor",
        f"{paths.TRACTOR}/rear_left", paths.PATH, paths.GROUND, paths.FURROW,
        f"{paths.SLIP}/truth", f"{paths.SLIP}/ekf4", f"{paths.SLIP}/ekf4/upper",
        f"{paths.SPEED}/truth",
        paths.DRAFT, paths.DEPTH,
    ):  # fmt: skip
        assert f"/{entity}" in told
    assert path.stat().st_size < 2_000_000


def test_a_log_is_recorded_on_a_map(tmp_path: Path) -> None:
    path = tmp_path / "log.rrd"
    setup = replace(RUN.setup, origin=(45.35, 11.95, 10.0))
    viz.log(path, streams=RUN.streams, setup=setup, estimates=RUN.estimates)
    assert "verified without error" in rerun("verify", str(path))
    assert f"/{paths.MAP}" in rerun("print", str(path))


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
    assert "verified without error" in rerun("verify", str(tmp_path / "log.rrd"))
