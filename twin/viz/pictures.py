"""The camera's frames, and over each the way that odometry saw the ground go."""

from __future__ import annotations

from typing import Any

import numpy as np
import rerun as rr

from twin.streams import Frames, Streams
from twin.viz.paths import CAMERA, ORANGE
from twin.viz.tools import set_time

WIDTH_PX, QUALITY = 480, 80
ARROW_PX_PER_MPS = 120.0


def log_frames(recording: rr.RecordingStream, streams: Streams, frames: Frames) -> None:
    """Each frame that was kept, small, with the velocity found between it and the one before."""
    import cv2  # slow to import, and few runs have a camera

    camera = streams["camera"]
    rows = {int(number): row for row, number in enumerate(camera["frame"])}
    for number in frames:
        row = rows.get(number)
        if row is None:
            continue
        set_time(recording, int(camera["epoch_ns"][row]))
        image = frames[number]
        height_px = round(WIDTH_PX * image.shape[0] / image.shape[1])
        small = cv2.resize(image, (WIDTH_PX, height_px), interpolation=cv2.INTER_AREA)
        _, packed = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
        recording.log(
            f"{CAMERA}/frame", rr.EncodedImage(contents=packed.tobytes(), media_type="image/jpeg")
        )
        told: dict[str, Any] = {n: float(camera[n][row]) for n in ("v_x_mps", "v_y_mps")}
        if np.isfinite(list(told.values())).all():
            origin = [0.5 * WIDTH_PX, 0.5 * height_px]
            vector = [-ARROW_PX_PER_MPS * told["v_y_mps"], -ARROW_PX_PER_MPS * told["v_x_mps"]]
            label = f"{told['v_x_mps']:.2f} m/s ahead, {told['v_y_mps']:+.3f} m/s left"
            arrow = rr.Arrows2D(
                origins=[origin], vectors=[vector], colors=[ORANGE], radii=[2.0], labels=[label]
            )
            recording.log(f"{CAMERA}/frame/odometry", arrow)
        else:
            recording.log(f"{CAMERA}/frame/odometry", rr.Clear(recursive=False))
    recording.reset_time()
