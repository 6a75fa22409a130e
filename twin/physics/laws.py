"""The soil laws behind one interface: which one acts stands in the parameter block.

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

import inspect
import math
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numba
import numpy as np
from numba import carray
from numba.core.ccallback import CFunc

from twin.compute.compiled import c_callback, inlined_law, key
from twin.errors import BadInput
from twin.physics import memory
from twin.physics.bekker import bekker
from twin.physics.block import Soil, Wheel
from twin.physics.brixius import brixius
from twin.physics.law_table import MOST_LAWS, SIGNATURE, TABLE, call, frozen, table_pointer
from twin.physics.memory import Pointer
from twin.physics.shapes import Array, Forces
from twin.plugins.failing import WRITES
from twin.plugins.lookup import attribute, words
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
        _enter(int(BEKKER), _compiled_bekker(), name)
    if name in LAWS:
        return float(LAWS.index(name))
    return register(attribute("soil law", name), name)


def register(function: Callable[..., Forces], name: str) -> float:
    """Compile a user's law and enter it in the table; its number, the same for the same source.

    Args:
        function: plain Python, or compiled by numba already.
        name: what messages call it.
    """
    number = int(key(Path(__file__), source_of(function, name, "soil law"), name)[:12], 16)
    known = _KNOWN.get(number)
    if known is None or known[0] is not function:  # loaded anew, perhaps with what it imports
        compiled = _compile(function, name)
        _enter(number, compiled, name)
        _KNOWN[number] = function, compiled
    return float(number)


def _enter(number: int, compiled: CFunc, name: str) -> None:
    """Enter a law in the table, in the place of one with its number."""
    known = np.flatnonzero((TABLE[:, 0] == number) & (TABLE[:, 1] != 0))
    rows = known if known.size else np.flatnonzero(TABLE[:, 1] == 0)
    if not rows.size:
        raise BadInput(f"soil law '{name}': this process knows {MOST_LAWS} laws already")
    TABLE[rows[0], 0], TABLE[rows[0], 1] = number, compiled.address or 0


@cache
def _compiled_bekker() -> CFunc:
    return c_callback(SIGNATURE)(_bekker)


def _bekker(
    soil: Pointer, wheel: Pointer, load: float, slip: float, side: float, out: Array
) -> None:
    out[0], out[1], out[2], out[3], out[4] = bekker(
        memory.row(soil, SOIL_SIZE), memory.row(wheel, WHEEL_SIZE), load, slip, side
    )


_KNOWN: dict[int, tuple[Callable[..., Forces], CFunc]] = {}
"""Number -> the law as it was given and as it was compiled; the table holds only addresses."""


def _compile(function: Callable[..., Forces], name: str) -> CFunc:
    """The law as a C function; not cached on disk, so that it cannot be stale."""
    try:
        pure = function
        if not hasattr(function, "py_func"):
            pure = numba.njit(error_model="numpy")(function)

        def entry(
            soil: Array, wheel: Array, load: float, slip: float, side: float, out: Array
        ) -> None:
            out[0], out[1], out[2], out[3], out[4] = pure(
                frozen(carray(soil, SOIL_SIZE)), frozen(carray(wheel, WHEEL_SIZE)), load, slip, side
            )

        return numba.cfunc(SIGNATURE)(entry)
    except Exception as error:  # whatever numba says of a user's function
        text = words(error)
        said = [n for n in text.splitlines() if n and not n.startswith("Failed in nopython")]
        reason = said[0] if said else type(error).__name__
        if WRITES.search(text):
            reason = "it writes to the soil or the wheel, which are the model's; x = soil.copy()"
        raise BadInput(f"soil law '{name}' cannot be compiled: {reason}") from None


def source_of(function: Callable[..., object], name: str, kind: str) -> str:
    """Text of the file a law stands in. Raises BadInput for what stands in none."""
    try:
        module = inspect.getmodule(getattr(function, "py_func", function))
        return inspect.getsource(module)  # type: ignore[arg-type]  # None is a TypeError too
    except (OSError, TypeError):
        raise BadInput(f"{kind} '{name}' is no function of a module in a file") from None
