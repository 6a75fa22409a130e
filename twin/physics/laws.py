"""The soil laws behind one interface: the parameter block says which one acts.

A law is a pure function

    law(soil, wheel, load_n, slip, side_slip)
        -> shear_x_n, shear_y_n, resistance_n, rolling_moment_n, sinkage_m

as `twin.physics.brixius.brixius` and `twin.physics.bekker.bekker` are. Brixius' is a part of the
callback. Any other is compiled when a machine that needs it is built, and kept by this process in a
table of function addresses. A user's own law is found there by the number its source text gives it.
A model that is loaded where its law is not known, or is known in another form, gets no forces but
NaN.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numba
from numba import carray
from numba.core.ccallback import CFunc

from twin.compute.compiled import c_callback, inlined_law
from twin.physics import memory
from twin.physics.bekker import bekker
from twin.physics.block import Soil, Wheel
from twin.physics.brixius import brixius
from twin.physics.law_table import MOST_LAWS, SIGNATURE, TABLE, call, frozen, table_pointer
from twin.physics.memory import Pointer
from twin.physics.own_laws import LawKind
from twin.physics.shapes import Array, Forces
from twin.plugins.lookup import attribute
from twin.scenario.soils import LAWS

BRIXIUS, BEKKER = float(LAWS.index("brixius")), float(LAWS.index("bekker"))
SOIL_SIZE, WHEEL_SIZE = int(Soil.SIZE), int(Wheel.SIZE)


@inlined_law
def soil_forces(
    soil: Array, wheel: Array, load_n: float, slip: float, side_slip: float
) -> tuple[float, float, float, float, float]:
    """What the soil's own law says; see the module for the interface."""
    number = soil[Soil.LAW]
    if number == BRIXIUS:
        return brixius(soil, wheel, load_n, slip, side_slip)
    table = memory.table(table_pointer(), MOST_LAWS, 2)
    for i in range(MOST_LAWS):
        if table[i, 0] == number and table[i, 1] != 0:
            at = table[i, 1]
            return call(at, soil.ctypes.data, wheel.ctypes.data, load_n, slip, side_slip)
    return math.nan, math.nan, math.nan, math.nan, math.nan


def law_number(name: str) -> float:
    """The number of a soil law for the parameter block; any but Brixius' is compiled first.

    Raises:
        BadInput: it cannot be imported, or cannot be compiled to a law.
    """
    if name == "bekker":
        OWN.enter(int(BEKKER), _compiled_bekker(), name)
    if name in LAWS:
        return float(LAWS.index(name))
    return OWN.register(attribute(OWN.name, name), name)


@cache
def _compiled_bekker() -> CFunc:
    return c_callback(SIGNATURE)(_bekker)


def _bekker(
    soil: Pointer, wheel: Pointer, load: float, slip: float, side: float, out: Array
) -> None:
    out[0], out[1], out[2], out[3], out[4] = bekker(
        memory.row(soil, SOIL_SIZE), memory.row(wheel, WHEEL_SIZE), load, slip, side
    )


def _as_c(pure: Callable[..., Forces]) -> CFunc:
    def entry(soil: Array, wheel: Array, load: float, slip: float, side: float, out: Array) -> None:
        out[0], out[1], out[2], out[3], out[4] = pure(
            frozen(carray(soil, SOIL_SIZE)), frozen(carray(wheel, WHEEL_SIZE)), load, slip, side
        )

    return numba.cfunc(SIGNATURE)(entry)


OWN = LawKind(
    name="soil law",
    table=TABLE,
    as_c=_as_c,
    read_only="it writes to the soil or the wheel, which are the model's; x = soil.copy()",
    file=Path(__file__),
)
"""Soil laws that users wrote."""
