"""Reading MuJoCo's structs from compiled code: fields by byte offset."""

from __future__ import annotations

from typing import Any, TypeAlias

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from twin.compute.compiled import Untyped

Pointer: TypeAlias = Any
"""The address of an mjModel or mjData, or of numbers in one: Python has no type for it."""


def _reader(kind: ir.Type, number: types.Type, what: str) -> Untyped:
    """What reads a value of a kind, stored so many bytes into a struct."""

    @intrinsic
    def read(typing_context: Untyped, base: Untyped, offset: Untyped) -> Untyped:
        def codegen(
            context: Untyped, builder: Untyped, signature: Untyped, args: Untyped
        ) -> Pointer:
            at = builder.add(builder.ptrtoint(args[0], ir.IntType(64)), args[1])
            return builder.load(builder.inttoptr(at, kind.as_pointer()))

        return number(types.voidptr, types.intp), codegen

    read.__doc__ = what
    return read


doubles = _reader(
    ir.DoubleType().as_pointer(),
    types.CPointer(types.float64),
    "The `double*` stored `offset` bytes into the struct at `base`.",
)
floats = _reader(
    ir.FloatType().as_pointer(),
    types.CPointer(types.float32),
    "The `float*` stored `offset` bytes into the struct at `base`.",
)
ints = _reader(
    ir.IntType(32).as_pointer(),
    types.CPointer(types.int32),
    "The `int*` stored `offset` bytes into the struct at `base`.",
)
size = _reader(
    ir.IntType(64),
    types.int64,
    "The 64-bit count (mjtSize) stored `offset` bytes into the struct at `base`.",
)
double = _reader(
    ir.DoubleType(),
    types.float64,
    "The double stored `offset` bytes into the struct at `base`.",
)
