"""Compile laws with numba, and keep the machine code where a stale copy cannot be found.

numba's own cache looks at the file of the function it compiled, not at the functions that one
calls, nor at constants taken from elsewhere. So the cache folder's name carries everything the
machine code depends on: the versions of mujoco and numba, the struct offsets, and the text of
every law.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import mujoco
import numba

from twin.physics import layout

Law = TypeVar("Law", bound=Callable[..., Any])

SOURCES = Path(__file__).parent


def cache_key(*extra: str) -> str:
    """Name of the cache folder: a hash of versions, offsets, and the source text of all laws."""
    digest = hashlib.sha256()
    digest.update(f"{mujoco.__version__} {numba.__version__}".encode())
    for name in ("mjModel", "mjData"):
        for field in (f[0] for f in layout.struct(name)._fields_):
            digest.update(f"{name}.{field}={layout.offset(name, field)};".encode())
    for source in sorted(SOURCES.glob("*.py")):
        digest.update(source.name.encode() + source.read_bytes())
    for text in extra:
        digest.update(text.encode())
    return digest.hexdigest()[:16]


@cache
def cache_folder() -> str:
    """The folder for this key, made if need be.

    A temporary one where the user's is not writable.
    """
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "tractor-twin"
    folder = base / cache_key()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return str(folder)
    except OSError:
        return tempfile.mkdtemp(prefix="tractor-twin-")


def law(function: Law) -> Law:
    """Compile a pure function of numbers and arrays (numba.njit), cached by content.

    A function from elsewhere is not cached, because the key does not cover its source.
    """
    ours = SOURCES in Path(function.__code__.co_filename).parents
    compiled: Law = _with_cache_folder(
        lambda: numba.njit(cache=ours, error_model="numpy")(function)
    )
    return compiled


def c_callback(signature: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function to a C callback (numba.cfunc), cached by content."""
    return lambda function: _with_cache_folder(
        lambda: numba.cfunc(signature, cache=True, error_model="numpy")(function)
    )


def _with_cache_folder(build: Callable[[], Any]) -> Any:
    """Run `build` with numba's cache folder set to ours, and put it back."""
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = cache_folder()
    try:
        return build()
    finally:
        numba.config.CACHE_DIR = before
