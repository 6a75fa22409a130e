from dataclasses import replace

import numpy as np
import pytest

from tests.sensors.trajectories import collect, drive, pieces, same
from twin.camera.frames import SavedFrames, save
from twin.camera.pinhole import rotation
from twin.errors import BadInput, OutOfRange
from twin.sensors import camera
from twin.sensors.camera import Camera, body_from_camera, drawn, film, stream
from twin.streams import Streams, check, concatenate
from twin.trajectory.trajectory import Trajectory

SMALL = Camera(width_px=160, height_px=100)
TRUE = replace(SMALL, mount_yaw_sd_rad=0.0, mount_tilt_sd_rad=0.0)


def raised(trajectory, up_m=0.2):
    columns = dict(trajectory.columns)
    columns["position_w"] = columns["position_w"] + [0.0, 0.0, up_m]
    return Trajectory(trajectory.epoch_ns, columns)


def test_chunks_change_no_bit():
    drive_all = raised(drive(2.0, yaw_rate_radps=0.2))
    whole = collect(camera, SMALL, [drive_all])
    assert same(whole, collect(camera, SMALL, pieces(drive_all, 37)))


def test_thirty_frames_a_second_off_the_physics_grid():
    table = collect(camera, SMALL, [raised(drive(2.0, speed_mps=1.5, yaw_rad=0.0))])
    np.testing.assert_array_equal(table["frame"], np.arange(61))
    np.testing.assert_allclose(table["epoch_ns"] * 1e-9, np.arange(61) / 30, atol=1e-9)
    np.testing.assert_allclose(table["position_w"][:, 0], 1.5 * np.arange(61) / 30, atol=1e-8)
    assert np.all(table["arrival_ns"] > table["epoch_ns"])


def test_the_stream_holds_no_pose_and_the_same_frames_whenever_they_are_asked_for():
    streams = stream(SMALL, 1, raised(drive(0.5)))
    check(streams)
    assert set(streams["camera"]) == {"epoch_ns", "arrival_ns", "frame"}
    last = streams.frames[15]
    assert last.shape == (100, 160)
    assert last.dtype == np.uint8
    streams.frames[0]
    np.testing.assert_array_equal(streams.frames[15], last)
    np.testing.assert_array_equal(stream(SMALL, 1, raised(drive(0.5))).frames[15], last)
    assert np.any(stream(SMALL, 2, raised(drive(0.5))).frames[15] != last)


def test_lost_frames_leave_gaps_in_the_numbers():
    lossy = replace(SMALL, loss_chance=0.3)
    numbers = collect(camera, lossy, [raised(drive(10.0))])["frame"]
    assert 0.6 * 301 < len(numbers) < 0.8 * 301
    assert np.all(np.diff(numbers) >= 1)


def view_of(config, trajectory, row):
    table = collect(camera, config, [trajectory])
    return drawn(config, 1, film(config, 1), table).shot(row).view


def test_the_camera_hangs_where_the_body_carries_it():
    spin, speed = 0.4, 1.5
    seen = view_of(TRUE, raised(drive(1.0, speed, spin, yaw_rad=0.0)), 0)
    np.testing.assert_allclose(seen.position_m, [0.4, 0.0, 0.5], atol=1e-12)
    np.testing.assert_allclose(seen.velocity_mps, [speed, spin * 0.4, 0.0], atol=1e-9)
    np.testing.assert_allclose(seen.spin_radps, [0, 0, spin], atol=1e-12)
    np.testing.assert_allclose(seen.ground_from_camera[:, 2], [0, 0, -1], atol=1e-12)


def test_on_a_slope_it_looks_square_at_the_ground():
    roll = np.radians(18.0)
    slope = rotation(np.array([roll, 0, 0]))
    level = drive(0.2, yaw_rad=0.0, roll_rad=roll)
    columns = dict(level.columns)
    columns["position_w"] = columns["position_w"] + slope @ [0.0, 0.0, 0.2]
    columns["ground_normal_w"] = np.tile(slope[:, 2], (len(level), 1))
    seen = view_of(TRUE, Trajectory(level.epoch_ns, columns), 0)
    assert seen.position_m[2] == pytest.approx(0.5)
    np.testing.assert_allclose(seen.ground_from_camera[:, 2], [0, 0, -1], atol=1e-12)


def test_the_mounting_is_drawn_once_per_seed_and_told_to_nobody():
    drawn_yaw = [
        np.arctan2(m[0, 0], -m[1, 0]) for m in (body_from_camera(SMALL, s) for s in range(400))
    ]
    assert np.std(drawn_yaw) == pytest.approx(SMALL.mount_yaw_sd_rad, rel=0.15)
    np.testing.assert_array_equal(body_from_camera(SMALL, 7), body_from_camera(SMALL, 7))
    assert camera.setup(SMALL) == camera.setup(TRUE)


def test_frames_are_saved_and_read_again(tmp_path):
    streams = stream(SMALL, 1, raised(drive(0.1)))
    paths = save(streams.frames, tmp_path / "frames")
    again = SavedFrames(tmp_path / "frames")
    assert len(paths) == len(again) == 4
    assert list(again) == [0, 1, 2, 3]
    np.testing.assert_array_equal(again[3], streams.frames[3])
    with pytest.raises(BadInput, match="no such directory"):
        SavedFrames(tmp_path / "none")
    paths[0].write_bytes(b"nonsense")
    with pytest.raises(BadInput, match="is not a picture"):
        again[0]


def test_parts_of_a_stream_carry_their_frames():
    one, other = (stream(SMALL, 1, raised(drive(0.1))) for _ in range(2))
    part = one.samples(0, 2)
    assert part.frames is one.frames
    assert concatenate([part, one.samples(2, 4)]).frames is one.frames
    later = Streams(other.tables, {9: other.frames[0]})
    assert set(concatenate([one, later]).frames) == {0, 1, 2, 3, 9}


def test_bad_settings_are_named():
    with pytest.raises(OutOfRange, match=r"camera\.field_of_view_deg = 120 is outside"):
        Camera(field_of_view_deg=120.0)
    with pytest.raises(OutOfRange, match=r"camera\.exposure_s = 0\.05 is outside"):
        Camera(exposure_s=0.05)
