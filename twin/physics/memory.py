"""Reading MuJoCo's structs from compiled code: fields by byte offset."""

from __future__ import annotations

from typing import Any, TypeAlias

from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array

from twin.compute.compiled import Untyped

Pointer: TypeAlias = Any
"""The address of an mjModel or mjData, or of numbers in one: Python has no type for it."""


def _reader(kind: ir.Type, number: types.Type, what: str) -> Untyped:
    """Reader of a value of a kind, at an offset in bytes into a struct."""

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


@intrinsic
def row(typing_context: Untyped, pointer: Untyped, count: Untyped) -> Untyped:
    """The `count` numbers at a pointer as an array: `numba.carray` in less machine code."""
    return _view(pointer.dtype, 1)(pointer, types.intp), _made


@intrinsic
def table(typing_context: Untyped, pointer: Untyped, rows: Untyped, columns: Untyped) -> Untyped:
    """The numbers at a pointer as an array of shape (rows, columns)."""
    return _view(pointer.dtype, 2)(pointer, types.intp, types.intp), _made


def _view(number: types.Type, dimensions: int) -> types.Array:
    return types.Array(number, dimensions, "C")


def _made(context: Untyped, builder: Untyped, signature: Untyped, args: Untyped) -> Pointer:
    kind = signature.return_type
    array = context.make_array(kind)(context, builder)
    at, *shape = args
    size = context.get_constant(types.intp, context.get_abi_sizeof(array.data.type.pointee))
    strides = [size]
    for count in reversed(shape[1:]):
        strides.insert(0, builder.mul(strides[0], count))
    populate_array(
        array, data=builder.bitcast(at, array.data.type), shape=shape, strides=strides,
        itemsize=size, meminfo=None,
    )  # fmt: skip
    return array._getvalue()
