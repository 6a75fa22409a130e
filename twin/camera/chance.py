"""Random numbers as a function of place: 32-bit hashes, so that nothing has to be stored."""

from __future__ import annotations

import zlib

import numpy as np
from numpy.random import SeedSequence
from numpy.typing import NDArray

from twin.compute.compiled import array_law

_X, _Y = np.uint32(0x8DA6B343), np.uint32(0xD8163841)
_A, _B = np.uint32(0x7FEB352D), np.uint32(0x846CA68B)


def keys(seed: int, term: str, number: int, count: int) -> NDArray[np.uint32]:
    """Independent 32-bit keys of one random term, shape (count,); `number` is e.g. a frame's."""
    spawn_key = (zlib.crc32(b"camera"), zlib.crc32(term.encode()), number)
    return SeedSequence(seed, spawn_key=spawn_key).generate_state(count).astype(np.uint32)


@array_law
def mixed(h: np.uint32) -> np.uint32:
    """Every bit of the result depends on every bit of h (Wellons' lowbias32, 2018)."""
    h = np.uint32(h ^ (h >> np.uint32(16)))
    h = np.uint32(h * _A)
    h = np.uint32(h ^ (h >> np.uint32(15)))
    h = np.uint32(h * _B)
    return np.uint32(h ^ (h >> np.uint32(16)))


@array_law
def node(key: np.uint32, ix: int, iy: int) -> np.uint32:
    """Hash of a lattice node; repeats only after 2^32 nodes along an axis."""
    hx = mixed(np.uint32(np.uint32(np.uint32(ix) * _X) ^ key))
    return mixed(np.uint32(hx ^ np.uint32(np.uint32(iy) * _Y)))


@array_law
def uniform(h: np.uint32) -> np.float32:
    """A hash as a number in [0, 1)."""
    return np.float32(np.float32(h >> np.uint32(8)) * np.float32(1.0 / 16777216.0))
