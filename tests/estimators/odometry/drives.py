"""Odometry over a rendered drive at constant speed and yaw rate."""

from dataclasses import replace

import numpy as np

from estimators.odometry import odometry
from estimators.odometry.lens import Lens
from tests.sensors.trajectories import drive
from twin.sensors import camera
from twin.sensors.camera import Camera
from twin.trajectory.trajectory import Trajectory

CAMERA = replace(Camera(), mount_yaw_sd_rad=0.0, mount_tilt_sd_rad=0.0)
LENS = Lens.of(camera.setup(CAMERA))


def rendered(duration_s, speed_mps, spin_radps=0.0, config=CAMERA, seed=1):
    """The camera's stream, 0.5 m above the ground."""
    path = drive(duration_s, speed_mps, spin_radps)
    columns = dict(path.columns)
    columns["position_w"] = columns["position_w"] + [0.0, 0.0, 0.2]
    return camera.stream(config, seed, Trajectory(path.epoch_ns, columns))


def motions(streams, spin_radps=0.0, method="phase-ecc", replaced=None, gyros=True):
    """The motion of each frame; `replaced` puts other frames in some frames' place."""
    state, found, last_ns = odometry.begin(LENS, method), [], None
    for epoch_ns, number in zip(
        streams["camera"]["epoch_ns"], streams["camera"]["frame"], strict=True
    ):
        frame = streams.frames[int(number)]
        if replaced and int(number) in replaced:
            frame = replaced[int(number)]
        step_s = 0.0 if last_ns is None else (epoch_ns - last_ns) * 1e-9
        turn = np.array([0.0, 0.0, spin_radps * step_s]) if gyros else None
        state, motion = odometry.step(state, frame, int(epoch_ns), turn)
        found.append(motion)
        last_ns = epoch_ns
    return found
