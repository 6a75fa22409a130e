"""MuJoCo without its warnings on the terminal."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache

import mujoco
from numba import types

from twin.compute.compiled import c_callback


@contextmanager
def quiet() -> Iterator[None]:
    """Keep MuJoCo's warnings off stderr and out of its log file; their counters still rise."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(_silence())
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


@cache
def _silence() -> Callable[[bytes], None]:
    """A C function that does nothing, and needs no Python lock from a Batch's threads."""
    address = c_callback(types.void(types.voidptr))(_nothing).address
    return ctypes.CFUNCTYPE(None, ctypes.c_void_p)(address)


def _nothing(text: bytes) -> None:
    pass
