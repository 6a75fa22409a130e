"""Frames into velocities on board: each frame is drawn, tracked and dropped before the next.

Memory is that of two frames, however long the run: one is tracked while a thread draws the next.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from concurrent.futures import Executor, Future
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twin.camera.frames import save
from twin.plugins.lookup import attribute
from twin.streams import COLUMNS, Frames, Setup, Streams, Table

ODOMETRY = "estimators.odometry.streams:"
"""The module with init(setup, method) -> state and run(state, chunk) -> (state, table)."""

Image = NDArray[np.uint8]


@dataclass(frozen=True, kw_only=True)
class Tracker:
    """Odometry on board, and where it stands."""

    state: object
    processing_ns: int
    """From a frame's arrival to its velocity's."""
    folder: Path | None = None
    """Where every frame is saved as PNG; None for nowhere."""

    def track(self, chunk: Streams, pool: Executor) -> tuple[Tracker, Streams]:
        """Put the velocities of a chunk's frames in the frames' place.

        Args:
            chunk: with the samples of camera and gyros that have arrived since the last.
            pool: draws the next frame meanwhile.
        """
        camera = chunk["camera"]
        seen = {name: chunk[name] for name in ("camera", "imu") if name in chunk}
        ahead = Ahead(chunk.frames or {}, pool, self.folder)
        state, told = attribute("odometry", ODOMETRY).run(self.state, Streams(seen, ahead))
        table: Table = {
            "epoch_ns": told["epoch_ns"],
            "arrival_ns": camera["arrival_ns"] + self.processing_ns,
            "frame": camera["frame"],
            **{name: told[name] for name in COLUMNS["camera"] if name in told},
        }
        return replace(self, state=state), Streams({**chunk.tables, "camera": table})


def tracker(
    setup: Setup, method: str, processing_s: float, folder: Path | None = None
) -> Tracker | None:
    """Odometry by a method's name before its first frame; None for none or without a camera."""
    if setup.camera is None or method == "none":
        return None
    state = attribute("odometry", ODOMETRY).init(setup, method)
    return Tracker(state=state, processing_ns=round(processing_s * 1e9), folder=folder)


class Ahead(Mapping[int, Image]):
    """Frames that are asked for one after another, each drawn while the one before is used."""

    def __init__(self, frames: Frames, pool: Executor, folder: Path | None = None) -> None:
        self._frames, self._pool, self._folder = frames, pool, folder
        self._next = dict(zip(frames, [*frames][1:], strict=False))
        self._drawing: dict[int, Future[Image]] = {}

    def __getitem__(self, number: int) -> Image:
        drawing = self._drawing.pop(number, None)
        image = self._frames[number] if drawing is None else drawing.result()
        after = self._next.get(number)
        if after is not None and after not in self._drawing:
            self._drawing[after] = self._pool.submit(self._frames.__getitem__, after)
        if self._folder is not None:
            save({number: image}, self._folder)
        return image

    def __iter__(self) -> Iterator[int]:
        return iter(self._frames)

    def __len__(self) -> int:
        return len(self._frames)
