"""A user's own force law of an implement, beside ASABE D497: the block says which one acts.

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
from numba import carray
from numba.core.ccallback import CFunc

from twin.compute.compiled import law
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
from twin.physics.own_laws import LawKind
from twin.physics.shapes import Array
from twin.plugins.lookup import attribute

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
    return D497 if name == "d497" else OWN.register(attribute(OWN.name, name), name)


def _as_c(pure: Law) -> CFunc:
    def entry(
        plough: Array, soil: Array, tool: float, depth: float, speed: float, drift: float,
        out: Array,
    ) -> None:  # fmt: skip
        out[0], out[1], out[2] = pure(
            frozen(carray(plough, PLOUGH_SIZE)), frozen(carray(soil, SOIL_SIZE)),
            tool, depth, speed, drift,
        )  # fmt: skip

    return numba.cfunc(IMPLEMENT_SIGNATURE)(entry)


OWN = LawKind(
    name="implement law",
    table=IMPLEMENT_TABLE,
    as_c=_as_c,
    read_only="it writes to the implement or the soil, which are the model's",
    file=Path(__file__),
)
"""Laws of implements that users wrote."""
