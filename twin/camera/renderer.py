"""What draws the ground, whichever way."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from twin.camera.pinhole import Pinhole, View


class Renderer(Protocol):
    """Draws what a camera sees of the ground of one seed, without the camera's own errors."""

    @property
    def lens(self) -> Pinhole:
        """The camera."""

    def radiance(self, view: View) -> NDArray[np.float32]:
        """Brightness 0..255 of every pixel, averaged over the exposure. Shape (height, width).

        Raises:
            OutOfRange: the camera sees something that is not drawn.
        """
