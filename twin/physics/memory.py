"""Reading MuJoCo's structs from compiled code: fields by byte offset."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

from llvmlite import ir
from numba import types
from numba.core.base import BaseContext
from numba.core.typing.context import BaseContext as TypingContext
from numba.core.typing.templates import Signature
from numba.extending import intrinsic

Intrinsic: TypeAlias = tuple[Signature, Callable[..., ir.Value]]
"""What numba takes of an intrinsic: its signature, and what generates its code."""


def _load(builder: ir.IRBuilder, base: ir.Value, offset: ir.Value, kind: ir.Type) -> ir.Value:
    at = builder.add(builder.ptrtoint(base, ir.IntType(64)), offset)
    return builder.load(builder.inttoptr(at, kind.as_pointer()))


@intrinsic
def doubles(typing_context: TypingContext, base: types.Type, offset: types.Type) -> Intrinsic:
    """The `double*` stored `offset` bytes into the struct at `base`."""

    def codegen(
        context: BaseContext, builder: ir.IRBuilder, signature: Signature, args: Sequence[ir.Value]
    ) -> ir.Value:
        return _load(builder, args[0], args[1], ir.DoubleType().as_pointer())

    return types.CPointer(types.float64)(types.voidptr, types.intp), codegen


@intrinsic
def floats(typing_context: TypingContext, base: types.Type, offset: types.Type) -> Intrinsic:
    """The `float*` stored `offset` bytes into the struct at `base`."""

    def codegen(
        context: BaseContext, builder: ir.IRBuilder, signature: Signature, args: Sequence[ir.Value]
    ) -> ir.Value:
        return _load(builder, args[0], args[1], ir.FloatType().as_pointer())

    return types.CPointer(types.float32)(types.voidptr, types.intp), codegen


@intrinsic
def ints(typing_context: TypingContext, base: types.Type, offset: types.Type) -> Intrinsic:
    """The `int*` stored `offset` bytes into the struct at `base`."""

    def codegen(
        context: BaseContext, builder: ir.IRBuilder, signature: Signature, args: Sequence[ir.Value]
    ) -> ir.Value:
        return _load(builder, args[0], args[1], ir.IntType(32).as_pointer())

    return types.CPointer(types.int32)(types.voidptr, types.intp), codegen


@intrinsic
def size(typing_context: TypingContext, base: types.Type, offset: types.Type) -> Intrinsic:
    """The 64-bit count (mjtSize) stored `offset` bytes into the struct at `base`."""

    def codegen(
        context: BaseContext, builder: ir.IRBuilder, signature: Signature, args: Sequence[ir.Value]
    ) -> ir.Value:
        return _load(builder, args[0], args[1], ir.IntType(64))

    return types.int64(types.voidptr, types.intp), codegen


@intrinsic
def double(typing_context: TypingContext, base: types.Type, offset: types.Type) -> Intrinsic:
    """The double stored `offset` bytes into the struct at `base`."""

    def codegen(
        context: BaseContext, builder: ir.IRBuilder, signature: Signature, args: Sequence[ir.Value]
    ) -> ir.Value:
        return _load(builder, args[0], args[1], ir.DoubleType())

    return types.float64(types.voidptr, types.intp), codegen
