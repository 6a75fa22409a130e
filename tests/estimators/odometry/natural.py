"""Pairs of pictures over natural textures, moved by known amounts: cubic splines, exact places."""

import functools
from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import map_coordinates, spline_filter

TEXTURES = ("gravel", "grass", "brick")
SHAPE = (240, 320)
CENTRE = np.array([(SHAPE[1] - 1) / 2, (SHAPE[0] - 1) / 2])
ROWS, COLUMNS = np.mgrid[0 : SHAPE[0], 0 : SHAPE[1]].astype(float)


@functools.cache
def texture(name):
    skimage_data = pytest.importorskip("skimage.data")
    cv2 = pytest.importorskip("cv2")
    path = Path(skimage_data.__file__).parent / f"{name}.png"
    return spline_filter(cv2.imread(str(path), cv2.IMREAD_GRAYSCALE).astype(float), 3)


def picture(name, place, turn_rad, scale, blur_px, rng):
    """What a camera over `place` sees; blur is the mean along the vector `blur_px`."""
    parts = max(1, int(np.ceil(np.linalg.norm(blur_px))))
    cos, sin = scale * np.cos(turn_rad), scale * np.sin(turn_rad)
    u, v = COLUMNS - CENTRE[0], ROWS - CENTRE[1]
    seen = np.zeros(SHAPE)
    for along in (np.arange(parts) + 0.5) / parts - 0.5:
        x, y = place + along * np.asarray(blur_px)
        at = [y + sin * u + cos * v, x + cos * u - sin * v]
        seen += map_coordinates(texture(name), at, order=3, prefilter=False) / parts
    return np.clip(np.rint(seen + rng.normal(0, 1.5, SHAPE)), 0, 255).astype(np.uint8)


def pair(name, move_px, turn_deg, scale, blur_px, rng):
    """Two frames, the true displacement [px] and the turn [rad], in a random direction."""
    direction = rng.uniform(0, 2 * np.pi)
    unit = np.array([np.cos(direction), np.sin(direction)])
    turn = np.radians(turn_deg) * rng.choice([-1, 1])
    zoom = 1 + scale * rng.choice([-1, 1])
    start = np.array([255.5, 255.5]) - unit * move_px / 2
    first = picture(name, start, 0.0, 1.0, blur_px * unit, rng)
    second = picture(name, start + move_px * unit, turn, zoom, blur_px * unit, rng)
    return first, second, move_px * unit, turn
