"""From what the lens lets through to the bytes of a frame: exposure, vignetting and noise."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.camera.chance import keys, mixed
from twin.camera.pinhole import Pinhole
from twin.compute.compiled import array_law

DAYLIGHT_S = 0.002
"""Exposure that makes a frame's bytes equal the ground's brightness, at gain 1 [s]; assumed,
an overcast day at f/4."""
_PIXEL = np.uint32(0x9E3779B1)


@dataclass(frozen=True, kw_only=True)
class Sensitivity:
    """The image sensor: from light to pixels."""

    exposure_s: float = DAYLIGHT_S
    """Time the shutter is open [s]; a global shutter."""
    gain: float = 1.0
    """Amplification after the photo-electrons are counted."""
    full_well_e: float = 10_000.0
    """Electrons of a pixel that reads 255 at gain 1; small industrial sensors hold 5000-15000."""
    read_noise_e: float = 8.0
    """sd of reading a pixel [electrons]; CMOS 2-15."""
    vignetting: float = 1.0
    """Share of the cos^4 law in the fall-off of light towards the corners."""


def develop(
    radiance: NDArray[np.float32], lens: Pinhole, pixel: Sensitivity, seed: int, frame: int
) -> NDArray[np.uint8]:
    """The bytes of a frame.

        E = radiance t / t_daylight (1 - a + a cos^4 theta)         [at gain 1, 255 = full well]
        B = gain (E + n),   var n = E 255 / full_well + (read 255 / full_well)^2

    rounded and cut off at 0 and 255. The noise is a function of seed, frame number and pixel.

    Args:
        radiance: brightness 0..255, shape (height, width).
        lens: for the angle theta off the optical axis.
        pixel: the image sensor.
        seed: of the noise.
        frame: number of the frame, which keys it.
    """
    image = np.empty(radiance.shape, np.uint8)
    per_electron = 255.0 / pixel.full_well_e
    exposure = pixel.exposure_s / DAYLIGHT_S
    read = pixel.read_noise_e * per_electron
    key = keys(seed, "noise", frame, 1)
    numbers = (exposure, pixel.gain, per_electron, read * read, pixel.vignetting, lens.focal_px)
    _develop(radiance, np.array(numbers, np.float32), key[0], image)
    return image


@array_law
def _develop(
    radiance: NDArray[np.float32],
    numbers: NDArray[np.float32],
    key: np.uint32,
    image: NDArray[np.uint8],
) -> None:
    height, width = image.shape
    exposure, gain, shot, read, share, focal = numbers
    one, half = np.float32(1.0), np.float32(0.5)
    per_area = one / (focal * focal)
    centre_u, centre_v = half * np.float32(width - 1), half * np.float32(height - 1)
    # four bytes, each uniform on 0..255, have mean 510 and variance 4 (256^2 - 1) / 12
    to_unit = np.float32(1.0 / math.sqrt((256.0 * 256.0 - 1.0) / 3.0))
    for v in range(height):
        row_key = mixed(np.uint32(key + np.uint32(v)))
        dv = np.float32(v) - centre_v
        for u in range(width):
            h = mixed(np.uint32(row_key ^ np.uint32(np.uint32(u) * _PIXEL)))
            pair = np.uint32(
                (h & np.uint32(0x00FF00FF)) + ((h >> np.uint32(8)) & np.uint32(0x00FF00FF))
            )
            total = np.int32((pair & np.uint32(0xFFFF)) + (pair >> np.uint32(16)))
            normal = (np.float32(total) - np.float32(510.0)) * to_unit
            du = np.float32(u) - centre_u
            cos2 = one / (one + (du * du + dv * dv) * per_area)
            light = radiance[v, u] * exposure * (one - share + share * cos2 * cos2)
            noise = np.float32(math.sqrt(light * shot + read)) * normal
            value = gain * (light + noise) + half
            image[v, u] = np.uint8(min(max(value, np.float32(0.0)), np.float32(255.0)))
