"""Compile the loops over pixels with numba, cached under a name that carries every source here."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import ParamSpec, TypeVar

import numba

P = ParamSpec("P")
R = TypeVar("R")


def pixel_loop(function: Callable[P, R]) -> Callable[P, R]:
    """The function compiled at its first call (numba.njit, without the GIL), kept on disk.

    numba's own cache does not see an edit of a function in another file that was inlined.
    """
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = cache_folder()
    try:
        loop: Callable[P, R] = numba.njit(cache=True, nogil=True, error_model="numpy")(function)
    finally:
        numba.config.CACHE_DIR = before
    return loop


@cache
def cache_folder() -> str:
    """The folder for these sources; a temporary one where the user's cache is not writable."""
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(source.name.encode() + source.read_bytes())
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "tractor-twin"
    folder = base / f"camera-{digest.hexdigest()[:16]}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return str(folder)
    except OSError:
        return tempfile.mkdtemp(prefix="tractor-twin-camera-")
