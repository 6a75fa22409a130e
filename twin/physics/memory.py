"""Reading MuJoCo's structs from compiled code: fields by byte offset."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic


def _load(context: Any, builder: Any, base: Any, offset: Any, kind: Any) -> Any:
    at = builder.add(builder.ptrtoint(base, ir.IntType(64)), offset)
    return builder.load(builder.inttoptr(at, kind.as_pointer()))


@intrinsic
def doubles(typing_context: Any, base: Any, offset: Any) -> Any:
    """The `double*` stored `offset` bytes into the struct at `base`."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _load(context, builder, args[0], args[1], ir.DoubleType().as_pointer())

    return types.CPointer(types.float64)(types.voidptr, types.intp), codegen


@intrinsic
def floats(typing_context: Any, base: Any, offset: Any) -> Any:
    """The `float*` stored `offset` bytes into the struct at `base`."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _load(context, builder, args[0], args[1], ir.FloatType().as_pointer())

    return types.CPointer(types.float32)(types.voidptr, types.intp), codegen


@intrinsic
def ints(typing_context: Any, base: Any, offset: Any) -> Any:
    """The `int*` stored `offset` bytes into the struct at `base`."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _load(context, builder, args[0], args[1], ir.IntType(32).as_pointer())

    return types.CPointer(types.int32)(types.voidptr, types.intp), codegen


@intrinsic
def size(typing_context: Any, base: Any, offset: Any) -> Any:
    """The 64-bit count (mjtSize) stored `offset` bytes into the struct at `base`."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _load(context, builder, args[0], args[1], ir.IntType(64))

    return types.int64(types.voidptr, types.intp), codegen


@intrinsic
def double(typing_context: Any, base: Any, offset: Any) -> Any:
    """The double stored `offset` bytes into the struct at `base`."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _load(context, builder, args[0], args[1], ir.DoubleType())

    return types.float64(types.voidptr, types.intp), codegen
