"""A camera in a run: frames become velocities on board, before what an estimator sees."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("cv2")

from twin import sensors
from twin.camera.frames import SavedFrames
from twin.errors import OutOfRange, UnknownName
from twin.pipeline.named import load
from twin.pipeline.run import run
from twin.scenario import Course
from twin.sensors import Camera
from twin.simulation import calibration
from twin.simulation.build import build
from twin.streams import Setup, check

NAMED = load("scenario", "slope-9-dry")
SMALL = replace(NAMED.sensors.camera, binning=8)
SHORT = replace(
    NAMED,
    course=replace(NAMED.course, length_m=1.2, calibration_m=0.0),
    sensors=replace(NAMED.sensors, camera=SMALL),
)


def camera_run(scenario=SHORT, **more):
    return run(scenario, estimators={}, **more)


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    folder = tmp_path_factory.mktemp("frames")
    return camera_run(frames=folder), folder


def test_estimators_are_given_velocities_and_no_frames(short):
    result, _ = short
    camera = result.streams["camera"]
    check(result.streams)
    assert result.streams.frames is None
    assert not camera.keys() & {"position_w", "world_from_body", "velocity_w", "ground_normal_w"}
    assert Setup.from_json(result.setup.to_json()) == result.setup
    assert result.setup.camera.width_px == 160
    used = camera["used"]
    assert not used[0]
    assert used[1:].all()
    mounting = 5 * SMALL.mount_yaw_sd_rad  # five sd
    truth_y = np.interp(
        camera["epoch_ns"][used],
        result.truth["epoch_ns"],
        result.truth["v_y_rear_mps"] + 0.98 * result.truth["yaw_rate_radps"],
    )
    assert np.abs(camera["v_x_mps"][used] - 0.98).max() < 0.03
    assert np.abs(camera["v_y_mps"][used] - truth_y).max() < mounting


def test_frames_are_saved_on_request_and_are_the_seeds(short, tmp_path):
    result, folder = short
    saved = SavedFrames(folder)
    assert list(saved) == list(result.streams["camera"]["frame"])
    assert saved[3].shape == (100, 160)
    raw = replace(SHORT, sensors=replace(SHORT.sensors, camera=replace(SMALL, odometry="none")))
    frames = camera_run(raw).streams.frames
    np.testing.assert_array_equal(frames[3], saved[3])


def test_on_board_velocities_do_not_depend_on_how_the_run_was_cut(short, monkeypatch):
    result, _ = short
    simulate = calibration.simulate
    monkeypatch.setattr(
        calibration,
        "simulate",
        lambda machine, set_levers=None: simulate(machine, 7, set_levers),
    )
    again = camera_run().streams["camera"]
    for name, column in result.streams["camera"].items():
        np.testing.assert_array_equal(column, again[name], err_msg=name)


def test_the_calibration_goes_before_the_run_and_its_pauses_show_nothing():
    course = replace(SHORT.course, calibration_m=5.0)
    blind = replace(SHORT.sensors, camera=None)
    result = camera_run(replace(SHORT, course=course, sensors=blind))
    start_ns = int(result.truth["epoch_ns"][0])
    machine = build(replace(SHORT, course=course))
    recording, _ = calibration.run_chunks(machine)
    assert recording.start_ns == start_ns
    assert len(recording.pauses_ns) == 2
    assert recording.pauses_ns[1][1] == start_ns
    for table in result.streams.tables.values():
        for first_ns, end_ns in recording.pauses_ns:
            epoch_ns = table["epoch_ns"]
            assert not np.any((epoch_ns >= first_ns + 20e6) & (epoch_ns < end_ns - 20e6))
    gnss, (out, back) = result.streams["gnss"], (p[0] for p in recording.pauses_ns)
    ahead = (gnss["epoch_ns"] < out, (gnss["epoch_ns"] > out) & (gnss["epoch_ns"] < back))
    east = [gnss["v_east_mps"][rows].mean() for rows in ahead]
    assert east[0] == pytest.approx(0.98, abs=0.03)
    assert east[1] == pytest.approx(-0.98, abs=0.03)
    for wheel in ("fl", "rr"):
        assert np.all(np.diff(result.streams["wheels"][f"ticks_{wheel}"]) >= 0)
    imu = result.streams["imu"]
    before = imu["epoch_ns"] < start_ns
    late = imu["accel_y_mps2"][~before][:5]
    np.testing.assert_allclose(late, 9.81 * np.sin(np.radians(9.0)), atol=0.5)
    assert np.abs(imu["accel_y_mps2"][before]).max() < 0.6


def test_faults_count_from_the_run():
    masked = load("scenario", "slope-9-dry-masked").sensors
    moved = sensors.faults_from(masked, 53.0)
    assert moved.gnss.outages[0].start_s == masked.gnss.outages[0].start_s + 53.0
    assert sensors.faults_from(masked, 0.0) is masked


def test_bad_settings_are_named():
    with pytest.raises(UnknownName, match="orb"):
        Camera(odometry="sift")
    with pytest.raises(OutOfRange, match=r"camera\.binning = 16 .* 1 to 6"):
        Camera(width_px=320, height_px=200, binning=16)
    with pytest.raises(OutOfRange, match="calibration_m"):
        Course(calibration_m=1.0)
