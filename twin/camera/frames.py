"""Frames, drawn or read when asked for, and saved as PNG."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twin.camera.image import Sensitivity, develop
from twin.camera.pinhole import Pinhole, View
from twin.camera.planar import planar
from twin.camera.renderer import Renderer
from twin.errors import BadInput
from twin.io.atomic import made, write_bytes
from twin.streams import Frames

Image = NDArray[np.uint8]

NAME = "frame_{:08d}.png"


@dataclass(frozen=True, kw_only=True)
class Film:
    """A camera over the ground of a seed: what makes a frame of a view."""

    lens: Pinhole
    pixel: Sensitivity
    seed: int
    height_m: float
    """About how high the camera is, which sets the finest texel [m]."""
    drawn_by: Renderer | None = None
    """None is the planar projection."""

    @cached_property
    def renderer(self) -> Renderer:
        """What draws the frames; made at the first one, as its ground texture takes 64 MB."""
        return self.drawn_by or planar(self.lens, self.seed, self.height_m)

    def frame(self, number: int, view: View) -> Image:
        """The frame of a view, shape (height, width); its noise is keyed by its number."""
        radiance = self.renderer.radiance(view)
        return develop(radiance, self.lens, self.pixel, self.seed, number)

    def dark(self, number: int) -> Image:
        """The frame of a covered lens, shape (height, width): the noise of reading it."""
        nothing = np.zeros((self.lens.height_px, self.lens.width_px), np.float32)
        return develop(nothing, self.lens, self.pixel, self.seed, number)


@dataclass(frozen=True, kw_only=True)
class Shot:
    """What a frame shows."""

    view: View
    number: int
    """Of the frame whose picture it is: its own, unless the camera hangs."""
    dark: bool = False
    """Whether the lens is covered."""
    halved: bool = False
    """Whether it comes at half the resolution."""


class DrawnFrames(Mapping[int, Image]):
    """Frames by number, each drawn anew whenever it is asked for; nothing is kept."""

    def __init__(self, film: Film, shots: Mapping[int, Shot]) -> None:
        self._film, self._shots = film, shots

    def shot(self, number: int) -> Shot:
        """What a frame shows."""
        return self._shots[number]

    def __getitem__(self, number: int) -> Image:
        shot = self._shots[number]
        film = self._film
        image = film.dark(number) if shot.dark else film.frame(shot.number, shot.view)
        return halved(image) if shot.halved else image

    def __iter__(self) -> Iterator[int]:
        return iter(self._shots)

    def __len__(self) -> int:
        return len(self._shots)

    def every(self, count: int) -> DrawnFrames:
        """One frame, by number."""
        shots = {number: shot for number, shot in self._shots.items() if number % count == 0}
        return DrawnFrames(self._film, shots)


def halved(image: Image) -> Image:
    """Means of 2 by 2 pixels; an odd last row or column is left out."""
    height, width = image.shape[0] // 2, image.shape[1] // 2
    fours = image[: 2 * height, : 2 * width].reshape(height, 2, width, 2)
    means: Image = np.rint(fours.mean(axis=(1, 3))).astype(np.uint8)
    return means


class SavedFrames(Mapping[int, Image]):
    """Frames by number, read from the PNG files that `save` wrote."""

    def __init__(self, folder: Path) -> None:
        """Raises BadInput if there is no such folder."""
        if not folder.is_dir():
            raise BadInput(f"{folder} is not a folder of frames: there is no such directory")
        self._paths = {int(p.stem[6:]): p for p in sorted(folder.glob("frame_*.png"))}

    def __getitem__(self, number: int) -> Image:
        import cv2

        path = self._paths[number]
        image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        if image is None:
            raise BadInput(f"{path} is not a picture")
        return np.asarray(image, np.uint8)

    def __iter__(self) -> Iterator[int]:
        return iter(self._paths)

    def __len__(self) -> int:
        return len(self._paths)


def save(frames: Frames, folder: Path) -> list[Path]:
    """Write every frame as PNG, one at a time; the paths. Raises NoSpace or BadInput."""
    import cv2

    paths = []
    with made(folder):
        for number in frames:
            path = folder / NAME.format(number)
            _, png = cv2.imencode(path.suffix, frames[number])
            write_bytes(path, png.tobytes())
            paths.append(path)
    return paths
