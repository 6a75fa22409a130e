"""Compile the loops over samples once, and again whenever any estimator's source changes.

numba's own cache looks only at the file of the function it compiles: after an edit of a function in
another file, which was inlined, the old law would go on running. So the cache directory is named by
what the machine code depends on: numba's version and every source of this package.
"""

from __future__ import annotations

import functools
import hashlib
import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import ParamSpec, TypeVar

import numba

P = ParamSpec("P")
R = TypeVar("R")


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """The function as `numba.njit` compiles it at its first call, kept between processes."""
    return _njit(function, forceinline=False)


def inlined(function: Callable[P, R]) -> Callable[P, R]:
    """`compiled`, and always inlined: for what takes a compiled function as an argument.

    An argument that is a function is an address of this process, and its caller could not be kept
    between processes; inlined, the address vanishes.
    """
    return _njit(function, forceinline=True)


def _njit(function: Callable[P, R], forceinline: bool) -> Callable[P, R]:
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(cache_folder())
    try:
        compiled_function: Callable[P, R] = numba.njit(
            cache=True, nogil=True, forceinline=forceinline
        )(function)
    finally:
        numba.config.CACHE_DIR = before
    return compiled_function


@functools.cache
def cache_folder() -> Path:
    """Where the machine code is kept; a temporary folder if the user's cache cannot be written."""
    name = f"estimators-{source_key(Path(__file__).parent)}"
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    folder = Path(base) / "tractor-twin" / name
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError:
        return Path(tempfile.mkdtemp(prefix=f"tractor-twin-{name}-"))


def source_key(package: Path) -> str:
    """Twelve hex digits that change with numba, Python or any .py file under the folder."""
    digest = hashlib.sha256(f"{numba.__version__} {sys.version}".encode())
    for source in sorted(package.rglob("*.py")):
        digest.update(str(source.relative_to(package)).encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()[:12]
