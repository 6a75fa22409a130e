"""What no single frame shows and a whole run adds up: errors far below a pixel, alike in all."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("cv2")

from drives import CAMERA, LENS, motions, rendered

from estimators.odometry import odometry, symmetric
from estimators.odometry.lens import Lens, evened
from estimators.odometry.streams import SLOW_S, Gyros, integrate
from tests.sensors.trajectories import drive
from twin.sensors import camera
from twin.trajectory.trajectory import Trajectory

BINNED = replace(CAMERA, binning=4)
PIXEL_MPS = 0.5 / 320.91 * 30.0
"""Speed of one working pixel per frame."""


def lateral_bias_px(fraction_px):
    """Mean error of 30 frames that move by 21 px and, to the side, by a fraction of one."""
    path = drive(1.0, 0.98, yaw_rad=0.0)
    columns, t = dict(path.columns), path.epoch_ns * 1e-9
    aside = fraction_px * PIXEL_MPS
    columns["position_w"] = columns["position_w"] + np.c_[0 * t, aside * t, 0 * t + 0.2]
    columns["velocity_w"] = columns["velocity_w"] + [0.0, aside, 0.0]
    streams = camera.stream(BINNED, 1, Trajectory(path.epoch_ns, columns))
    state, seen = odometry.begin(Lens.of(camera.setup(BINNED))), []
    for epoch_ns, n in zip(streams["camera"]["epoch_ns"], streams["camera"]["frame"], strict=True):
        state, motion = odometry.step(state, streams.frames[int(n)], int(epoch_ns), np.zeros(3))
        seen.append(motion.velocity_mps[1] / PIXEL_MPS - fraction_px)
    return float(np.mean(seen[1:]))


def test_displacements_are_not_pulled_towards_whole_pixels():
    bias_px = np.array([lateral_bias_px(f) for f in (-0.4, -0.25, 0.0, 0.25, 0.4)])
    assert np.ptp(bias_px) < 1e-3
    assert np.abs(bias_px).max() < 1.5e-3


def test_a_map_and_its_halves_are_one():
    rng = np.random.default_rng(1)
    warp = np.eye(2, 3) + 0.02 * rng.standard_normal((2, 3))
    warp[:, 2] += [3.0, -20.0]
    again = symmetric.whole(symmetric.halves(warp, (200, 320)), (200, 320))
    np.testing.assert_allclose(again, warp, atol=1e-12)


def test_it_is_symmetric():
    frames = rendered(0.1, 0.5, 0.3, BINNED).frames
    one, other = (symmetric.smoothed(evened(frames[n].astype(np.float32))) for n in (0, 1))
    there = symmetric.find(one, other, np.array([[1.0, 0.0, 0.0], [0.0, 1.0, -10.5]]))
    back = symmetric.find(other, one, np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 10.5]]))
    both = [np.vstack([f.previous_from_current, [0, 0, 1]]) for f in (there, back)]
    np.testing.assert_allclose(both[0] @ both[1], np.eye(3), atol=2e-3)
    assert there.correlation == pytest.approx(back.correlation, abs=1e-4)


def test_pictures_that_hardly_overlap_have_no_map():
    picture = symmetric.smoothed(np.zeros((200, 320), np.float32))
    assert symmetric.find(picture, picture, np.eye(2, 3)) is None
    far = np.array([[1.0, 0.0, 310.0], [0.0, 1.0, 0.0]])
    noise = np.random.default_rng(2).standard_normal((200, 320)).astype(np.float32)
    assert symmetric.find(symmetric.smoothed(noise), symmetric.smoothed(noise), far) is None


@pytest.mark.parametrize("seed", [3, 4])
def test_the_picture_tells_how_the_camera_is_tilted(seed):
    config = replace(CAMERA, mount_tilt_sd_rad=np.radians(0.5))
    frames, state = rendered(0.5, 1.0, 0.0, config, seed), odometry.begin(LENS)
    for epoch_ns, n in zip(frames["camera"]["epoch_ns"], frames["camera"]["frame"], strict=True):
        state, _ = odometry.step(state, frames.frames[int(n)], int(epoch_ns), np.zeros(3))
    down = camera.body_from_camera(config, seed).T @ [0.0, 0.0, -1.0]
    np.testing.assert_allclose(state.tilt.normal, down[:2] / down[2], atol=6e-4)


def test_a_tilted_camera_that_turns_is_still_told_where_its_centre_goes():
    config = replace(CAMERA, mount_tilt_sd_rad=np.radians(1.0))
    found = [m for m in motions(rendered(0.8, 1.0, 0.3, config, 5), 0.3) if m.used][5:]
    forward, left = np.mean([m.velocity_mps for m in found], axis=0)
    assert forward == pytest.approx(1.0, rel=2e-3)
    assert left == pytest.approx(0.3 * CAMERA.position_m[0], abs=0.4e-3)


def test_what_rolls_slowly_is_bias():
    gyros = Gyros()
    for k in range(2000):
        gyros = integrate(gyros, 20_000_000 * k, np.array([1e-3, -2e-3, 0.1]))
    np.testing.assert_allclose(gyros.slow_radps, [1e-3, -2e-3], rtol=1e-9)
    quick = gyros
    for k in range(2000, 2005):
        quick = integrate(quick, 20_000_000 * k, np.array([0.1, 0.0, 0.0]))
    assert quick.slow_radps[0] < 0.1 * 0.1 / SLOW_S + 2e-3
    dropped = gyros
    for k in range(2000, 2050):  # by 0.15 rad in a second, to stay so
        dropped = integrate(dropped, 20_000_000 * k, np.array([0.15, 0.0, 0.0]))
    assert SLOW_S * (dropped.slow_radps[0] - 1e-3) < 0.04 * 0.15  # what would be undone of it
