"""The users' laws of this process: tables that compiled code reads, and calls by address."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import llvmlite.binding
import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.base import BaseContext
from numba.core.imputils import impl_ret_borrowed
from numba.core.typing.context import BaseContext as TypingContext
from numba.core.typing.templates import Signature
from numba.extending import intrinsic

Intrinsic: TypeAlias = tuple[Signature, Callable[..., ir.Value]]
"""What numba takes of an intrinsic: its signature, and what generates its code."""
MOST_LAWS = 32
TABLE = np.zeros((MOST_LAWS, 2), dtype=np.int64)
"""Number and function address of each soil law; zero beyond the last."""
IMPLEMENT_TABLE = np.zeros((MOST_LAWS, 2), dtype=np.int64)
"""The same of each implement law."""
SYMBOL, IMPLEMENT_SYMBOL = "tractor_twin_laws", "tractor_twin_implement_laws"
llvmlite.binding.add_symbol(SYMBOL, TABLE.ctypes.data)
llvmlite.binding.add_symbol(IMPLEMENT_SYMBOL, IMPLEMENT_TABLE.ctypes.data)
SIGNATURE = types.void(
    types.CPointer(types.float64), types.CPointer(types.float64),
    types.float64, types.float64, types.float64, types.CPointer(types.float64),
)  # fmt: skip
"""C form of a soil law: soil, wheel, load, slip, side slip, and where its five numbers go."""
IMPLEMENT_SIGNATURE = types.void(
    types.CPointer(types.float64), types.CPointer(types.float64),
    types.float64, types.float64, types.float64, types.float64, types.CPointer(types.float64),
)  # fmt: skip
"""C form of an implement law: implement, soil, tool, depth, speed, drift, and its three numbers."""


@intrinsic
def table_pointer(typing_context: TypingContext) -> Intrinsic:
    """Pointer to TABLE, by a symbol that is resolved when machine code is loaded."""
    return types.CPointer(types.int64)(), _pointer_to(SYMBOL)


@intrinsic
def implement_table_pointer(typing_context: TypingContext) -> Intrinsic:
    """Pointer to IMPLEMENT_TABLE, as `table_pointer`."""
    return types.CPointer(types.int64)(), _pointer_to(IMPLEMENT_SYMBOL)


def _pointer_to(symbol: str) -> Callable[..., ir.Value]:
    def codegen(
        context: BaseContext, builder: ir.IRBuilder, signature: Signature, args: Sequence[ir.Value]
    ) -> ir.Value:
        known = builder.module.globals.get(symbol)
        variable = known or ir.GlobalVariable(builder.module, ir.IntType(64), symbol)
        return builder.bitcast(variable, context.get_value_type(signature.return_type))

    return codegen


@intrinsic
def call(
    typing_context: TypingContext,
    address: types.Type,
    soil: types.Type,
    wheel: types.Type,
    load: types.Type,
    slip: types.Type,
    side: types.Type,
) -> Intrinsic:
    """Call the C function of a law by its address; the five numbers it writes, as a tuple."""
    result = types.UniTuple(types.float64, 5)
    numbers = (types.float64,) * 3
    return result(types.int64, types.intp, types.intp, *numbers), _calling(3, 5)


@intrinsic
def call_implement(
    typing_context: TypingContext,
    address: types.Type,
    implement: types.Type,
    soil: types.Type,
    tool: types.Type,
    depth: types.Type,
    speed: types.Type,
    drift: types.Type,
) -> Intrinsic:
    """Call the C function of an implement law; the three numbers it writes, as a tuple."""
    result = types.UniTuple(types.float64, 3)
    numbers = (types.float64,) * 4
    return result(types.int64, types.intp, types.intp, *numbers), _calling(4, 3)


def _calling(numbers: int, results: int) -> Callable[..., ir.Value]:
    """Code that calls f(double *, double *, double..., double *out) by its address."""

    def codegen(
        context: BaseContext, builder: ir.IRBuilder, signature: Signature, args: Sequence[ir.Value]
    ) -> ir.Value:
        double = ir.DoubleType()
        pointer = double.as_pointer()
        kind = ir.FunctionType(
            ir.VoidType(), [pointer, pointer, *[double] * numbers, pointer]
        ).as_pointer()
        out = cgutils.alloca_once(builder, double, results)
        at = [builder.inttoptr(a, pointer) for a in args[1:3]]
        builder.call(builder.inttoptr(args[0], kind), [*at, *args[3:], out])
        values = [builder.load(builder.gep(out, [ir.IntType(32)(i)])) for i in range(results)]
        return context.make_tuple(builder, signature.return_type, values)

    return codegen


@intrinsic
def frozen(typing_context: TypingContext, array: types.Array) -> Intrinsic:
    """The same array, typed so that code that writes to it does not compile."""

    def codegen(
        context: BaseContext, builder: ir.IRBuilder, signature: Signature, args: Sequence[ir.Value]
    ) -> ir.Value:
        return impl_ret_borrowed(context, builder, signature.return_type, args[0])

    return array.copy(readonly=True)(array), codegen
