"""A user's own force law of an implement, beside ASABE D497: which one acts stands in the block.

A law is a pure function

    law(implement, soil, tool, depth_m, speed_mps, drift_rad) -> draft_n, vertical_n, side_n

of one body or tool: its number, its depth, its speed, and the angle from its own direction to its
motion, positive towards the land. `implement` and `soil` are parts of the parameter block
(`twin.physics.block.Plough`, `Soil`), the soil as it is at the tool's place. The draft acts against
the motion, the vertical force down, the side force towards the land; none of them is negative.
It is compiled and found as a soil law is, see `twin.physics.laws`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

import numba
import numpy as np
from numba import carray
from numba.core.ccallback import CFunc

from twin.compute.compiled import key, law
from twin.errors import BadInput
from twin.physics import memory
from twin.physics.block import Plough, Soil
from twin.physics.law_table import (
    IMPLEMENT_SIGNATURE,
    IMPLEMENT_TABLE,
    MOST_LAWS,
    call_implement,
    frozen,
    implement_table_pointer,
)
from twin.physics.shapes import Array
from twin.plugins.failing import WRITES
from twin.plugins.lookup import attribute, words

D497 = 0.0
"""The number of ASABE D497 in the parameter block."""
PLOUGH_SIZE, SOIL_SIZE = int(Plough.SIZE), int(Soil.SIZE)
Three: TypeAlias = tuple[float, float, float]
Law: TypeAlias = Callable[[Array, Array, float, float, float, float], Three]


@law
def implement_forces(
    plough: Array, soil: Array, tool: float, depth_m: float, speed_mps: float, drift_rad: float
) -> tuple[float, float, float]:
    """Draft of one tool by the user's law, its vertical and its side force over the draft.

    NaN where this process does not know the law.
    """
    number = plough[Plough.LAW]
    table = memory.table(implement_table_pointer(), MOST_LAWS, 2)
    for i in range(MOST_LAWS):
        if table[i, 0] == number and table[i, 1] != 0:
            draft, vertical, side = call_implement(
                table[i, 1], plough.ctypes.data, soil.ctypes.data, tool, depth_m, speed_mps,
                drift_rad,
            )  # fmt: skip
            if draft > 0.0:
                return draft, vertical / draft, side / draft
            return draft, 0.0, 0.0
    return math.nan, math.nan, math.nan


def implement_law_number(name: str) -> float:
    """The number of a law for the parameter block; a `module:function` is compiled first.

    Raises:
        BadInput: it cannot be imported, or cannot be compiled to a law.
    """
    return D497 if name == "d497" else _register(attribute("implement law", name), name)


_KNOWN: dict[int, tuple[Law, CFunc]] = {}
"""Number -> the law as it was given and as it was compiled; the table holds only addresses."""


def _register(function: Law, name: str) -> float:
    from twin.physics.laws import source_of

    number = int(key(Path(__file__), source_of(function, name, "implement law"), name)[:12], 16)
    rows = np.flatnonzero((IMPLEMENT_TABLE[:, 0] == number) | (IMPLEMENT_TABLE[:, 1] == 0))
    if not rows.size:
        raise BadInput(f"implement law '{name}': this process knows {MOST_LAWS} laws already")
    known = _KNOWN.get(number)
    if known is None or known[0] is not function:
        compiled = _compile(function, name)
        _KNOWN[number] = function, compiled
        IMPLEMENT_TABLE[rows[0], 0], IMPLEMENT_TABLE[rows[0], 1] = number, compiled.address or 0
    return float(number)


def _compile(function: Law, name: str) -> CFunc:
    """The law as a C function; not cached on disk, so that it cannot be stale."""
    try:
        pure = function
        if not hasattr(function, "py_func"):
            pure = numba.njit(error_model="numpy")(function)

        def entry(
            plough: Array, soil: Array, tool: float, depth: float, speed: float, drift: float,
            out: Array,
        ) -> None:  # fmt: skip
            out[0], out[1], out[2] = pure(
                frozen(carray(plough, PLOUGH_SIZE)), frozen(carray(soil, SOIL_SIZE)),
                tool, depth, speed, drift,
            )  # fmt: skip

        return numba.cfunc(IMPLEMENT_SIGNATURE)(entry)
    except Exception as error:  # whatever numba says of a user's function
        text = words(error)
        said = [n for n in text.splitlines() if n and not n.startswith("Failed in nopython")]
        reason = said[0] if said else type(error).__name__
        if WRITES.search(text):
            reason = "it writes to the implement or the soil, which are the model's"
        raise BadInput(f"implement law '{name}' cannot be compiled: {reason}") from None
