"""A camera that looks down: when it takes frames, from where, and when they arrive.

The ground it sees is a plane through the world's origin with the normal `ground_normal_w` of the
trajectory; without that column it is level.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import atan2, radians
from typing import TYPE_CHECKING, Annotated

import numpy as np
from numpy.random import Generator

from twin.camera.pinhole import CAMERA_DOWN, Array, Pinhole, View, focal_px, rotation
from twin.compute.quaternion import matrix
from twin.errors import OutOfRange, UnknownName, check_range
from twin.sensors.checks import Range, check_fields
from twin.sensors.noise import generator
from twin.sensors.sampling import Reader, arrivals, read, reader
from twin.streams import CameraSetup, Streams, Table

if TYPE_CHECKING:  # the renderer is heavy, and only there where a camera is fitted
    from twin.camera.frames import DrawnFrames, Film
    from twin.camera.renderer import Renderer
    from twin.trajectory.trajectory import Trajectory

NORMAL = "ground_normal_w"
POSE = ("position_w", "world_from_body", "velocity_w", "gyro_b")
"""Trajectory columns from which a frame is rendered; not part of the stream."""
SHOWN, HALVED = "shown", "halved"
"""Columns that camera faults change, not part of the stream: number of the frame whose image is
shown (DARK for a black one), and 1 where the image has half the resolution."""
DARK = -1
CONTRACT = ("epoch_ns", "arrival_ns", "frame")
ODOMETRY = ("phase-ecc", "orb-similarity", "orb-printed", "none")
"""Methods by which the camera's computer turns frames into velocities."""


@dataclass(frozen=True, kw_only=True)
class Camera:
    """A camera that looks down: data sheet and tape measure, then the true errors."""

    rate_hz: Annotated[float, Range(1, 500)] = 30.0
    """Frames per second, Hz."""
    width_px: Annotated[int, Range(32, 4096)] = 1280
    """Size of the sensor across the direction of travel, px."""
    height_px: Annotated[int, Range(32, 4096)] = 800
    """Size of the sensor along the direction of travel, px."""
    binning: Annotated[int, Range(1, 16)] = 1
    """Side of the squares of pixels that are averaged, px; a frame is width_px / binning wide."""
    field_of_view_deg: Annotated[float, Range(5, 90)] = 53.0
    """Horizontal field of view, deg; 28 to 53 through the lens's zoom."""
    position_m: tuple[float, float, float] = (0.4, 0.0, 0.3)
    """Optical centre, body axes, from the rear-axle centre, m."""
    height_m: Annotated[float, Range(0.05, 5)] = 0.5
    """Optical centre above level ground, m."""
    exposure_s: Annotated[float, Range(0, 0.1)] = 0.002
    """Time the shutter is open, s; 1 m/s then blurs a frame by 5 px."""
    gain: Annotated[float, Range(0, 100)] = 1.0
    """Amplification."""
    full_well_e: Annotated[float, Range(100, 1e6)] = 10_000.0
    """Electrons of a pixel at full scale; 5000 to 15000 in small industrial sensors."""
    read_noise_e: Annotated[float, Range(0, 1000)] = 8.0
    """Noise of reading a pixel, electrons; CMOS 2 to 15."""
    vignetting: Annotated[float, Range(0, 1)] = 1.0
    """Share of the cos^4 fall-off towards the corners."""
    latency_s: Annotated[float, Range(0, 1)] = 0.025
    """Time from the middle of the exposure to arrival, s; read-out and transfer over USB."""
    latency_jitter_s: Annotated[float, Range(0, 0.1)] = 0.002
    """Random part of the latency: this times |N(0, 1)|, s."""
    loss_chance: Annotated[float, Range(0, 1)] = 0.0
    """Share of the frames that are lost in transfer; the stream skips their numbers."""
    mount_yaw_sd_rad: Annotated[float, Range(0, 0.2)] = radians(1.0)
    """sd of the mounting's random yaw error, constant over a run, rad."""
    mount_tilt_sd_rad: Annotated[float, Range(0, 0.1)] = radians(0.3)
    """sd of the mounting's random roll and pitch errors, constant over a run, rad."""
    odometry: str = "phase-ecc"
    """Method that turns frames into velocities: phase-ecc, orb-similarity or orb-printed; with none
    the estimators get the frames themselves."""
    processing_s: Annotated[float, Range(0, 1)] = 0.015
    """Time from a frame's arrival to the arrival of its velocity, s."""

    def __post_init__(self) -> None:
        check_fields("camera", self)
        if self.odometry not in ODOMETRY:
            raise UnknownName("odometry", self.odometry, ODOMETRY)
        shortest_px = min(self.width_px, self.height_px) // self.binning
        if shortest_px < 32:
            smaller = min(self.width_px, self.height_px) // 32
            raise OutOfRange(
                "camera.binning", self.binning, f"1 to {smaller}, for 32 pixels to stay"
            )
        check_range("camera.exposure_s", self.exposure_s, 0.0, 1.0 / self.rate_hz)

    @property
    def lens(self) -> Pinhole:
        """The camera as a pinhole model, in pixels of its frames (after binning)."""
        width, height = self.width_px // self.binning, self.height_px // self.binning
        focal = focal_px(width, radians(self.field_of_view_deg))
        return Pinhole(width_px=width, height_px=height, focal_px=focal)


@dataclass(frozen=True, kw_only=True)
class CameraState:
    """State of the camera between chunks."""

    seed: int
    film: Film
    reader: Reader
    arrival_ns: int
    frame: int
    """Number of the next frame."""
    latency: Generator
    loss: Generator


def init(config: Camera, seed: int, start_ns: int) -> CameraState:
    """State of the camera at the start of a run."""
    return CameraState(
        seed=seed,
        film=film(config, seed),
        reader=reader(start_ns, config.rate_hz),
        arrival_ns=start_ns,
        frame=0,
        latency=generator(seed, "camera", "latency"),
        loss=generator(seed, "camera", "loss"),
    )


def sample(config: Camera, state: CameraState, chunk: Trajectory) -> tuple[CameraState, Table]:
    """Frames of the chunk: stamps, numbers and true poses (`POSE`), without images.

    The epoch is the middle of the exposure. `drawn` renders images from the poses, `stream_table`
    keeps the columns that an estimator may see.
    """
    names = (*POSE, NORMAL) if NORMAL in chunk.columns else POSE
    position, epoch_ns, at = read(state.reader, chunk, names)
    count = len(epoch_ns)
    scatter = np.abs(state.latency.standard_normal(count))
    kept = state.loss.random(count) >= config.loss_chance
    delay_s = config.latency_s + config.latency_jitter_s * scatter
    last_ns, arrival_ns = arrivals(state.arrival_ns, epoch_ns, delay_s)
    numbers = np.arange(state.frame, state.frame + count, dtype=np.int64)
    table: Table = {"epoch_ns": epoch_ns, "arrival_ns": arrival_ns, "frame": numbers, **at}
    table |= {SHOWN: numbers, HALVED: np.zeros(count, np.int8)}
    after = replace(state, reader=position, arrival_ns=last_ns, frame=state.frame + count)
    return after, {name: column[kept] for name, column in table.items()}


def stream_table(table: Table) -> Table:
    """The columns of the stream, without the true poses."""
    return {name: table[name] for name in CONTRACT}


def film(config: Camera, seed: int, drawn_by: Renderer | None = None) -> Film:
    """Film (renderer and noise model) of the camera for one run.

    `seed` sets the texture of the ground and the noise; `drawn_by` is a renderer to use, None for
    a new one.
    """
    from twin.camera.frames import Film
    from twin.camera.image import Sensitivity

    pixel = Sensitivity(
        exposure_s=config.exposure_s,
        gain=config.gain,
        full_well_e=config.full_well_e * config.binning**2,
        read_noise_e=config.read_noise_e * config.binning,
        vignetting=config.vignetting,
    )
    lens, height_m = config.lens, config.height_m
    return Film(lens=lens, pixel=pixel, seed=seed, height_m=height_m, drawn_by=drawn_by)


def drawn(config: Camera, seed: int, film: Film, table: Table) -> DrawnFrames:
    """Images of the frames of a table that `sample` returned; each is rendered on access.

    Args:
        config: the camera.
        seed: the run's seed, which sets the random mounting error.
        film: renderer and noise model, made by `film` with the same seed.
        table: frames with their true poses.
    """
    from twin.camera.frames import DrawnFrames, Shot

    mounted = body_from_camera(config, seed)
    names = [name for name in (*POSE, NORMAL) if name in table]
    shots = {
        int(number): Shot(
            view=_view(config, mounted, {name: table[name][row] for name in names}),
            number=int(table[SHOWN][row]),
            dark=bool(table[SHOWN][row] == DARK),
            halved=bool(table[HALVED][row]),
        )
        for row, number in enumerate(table["frame"])
    }
    return DrawnFrames(film, shots)


def body_from_camera(config: Camera, seed: int) -> Array:
    """Matrix that rotates camera axes to body axes, with the true mounting error. Shape (3, 3).

    The nominal mounting is turned by a random roll, pitch and yaw, which the seed sets.
    """
    roll, pitch, yaw = generator(seed, "camera", "mounting").standard_normal(3)
    tilt = config.mount_tilt_sd_rad
    turned = rotation(np.array([tilt * roll, tilt * pitch, config.mount_yaw_sd_rad * yaw]))
    mounted: Array = turned @ CAMERA_DOWN
    return mounted


def ground_from_world(normal_w: Array) -> Array:
    """Matrix of the shortest rotation that takes `normal_w` to z. Shape (3, 3)."""
    axis = np.cross(normal_w, [0.0, 0.0, 1.0])
    sine = float(np.linalg.norm(axis))
    if sine < 1e-12:
        return np.eye(3)
    return rotation(axis * (atan2(sine, normal_w[2]) / sine))


def _view(config: Camera, mounted: Array, at: Table) -> View:
    turn = ground_from_world(at[NORMAL]) if NORMAL in at else np.eye(3)
    world_from_body = matrix(at["world_from_body"])
    arm_w = world_from_body @ np.array(config.position_m)
    spin_w = world_from_body @ at["gyro_b"]
    return View(
        position_m=turn @ (at["position_w"] + arm_w),
        ground_from_camera=turn @ world_from_body @ mounted,
        velocity_mps=turn @ (at["velocity_w"] + np.cross(spin_w, arm_w)),
        spin_radps=turn @ spin_w,
        exposure_s=config.exposure_s,
    )


def frames(config: Camera, state: CameraState, table: Table) -> DrawnFrames:
    """Images of the frames of a table that `sample` returned, by the film in `state`."""
    return drawn(config, state.seed, state.film, table)


def stream(config: Camera, seed: int, trajectory: Trajectory) -> Streams:
    """The camera's stream of a whole trajectory; each image is rendered on access."""
    state, table = sample(config, init(config, seed, int(trajectory.epoch_ns[0])), trajectory)
    return Streams({"camera": stream_table(table)}, frames(config, state, table))


def setup(config: Camera) -> CameraSetup:
    """Set-up of the camera for estimators: nominal values, no true errors."""
    return CameraSetup(
        rate_hz=config.rate_hz,
        width_px=config.lens.width_px,
        height_px=config.lens.height_px,
        focal_px=config.lens.focal_px,
        lever_arm_m=config.position_m,
        height_m=config.height_m,
    )
