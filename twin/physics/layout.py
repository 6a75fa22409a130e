"""Where MuJoCo keeps the fields of mjModel and mjData: byte offsets from its own introspection."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any, TypeAlias

from mujoco.introspect import ast_nodes, structs

CType: TypeAlias = Any
"""A class of ctypes, made at run time."""

_PRIMITIVE: dict[str, CType] = {
    "int": ctypes.c_int,
    "mjtNum": ctypes.c_double,
    "double": ctypes.c_double,
    "float": ctypes.c_float,
    "size_t": ctypes.c_size_t,
    "uintptr_t": ctypes.c_size_t,
    "mjtByte": ctypes.c_ubyte,
    "char": ctypes.c_char,
    "uint64_t": ctypes.c_uint64,
    "int64_t": ctypes.c_int64,
    "mjtSize": ctypes.c_int64,
    "mjtBool": ctypes.c_bool,
}


@cache
def struct(name: str) -> type[ctypes.Structure]:
    """ctypes structure with the layout of a MuJoCo struct, e.g. "mjData"."""
    fields = [(f.name, _ctype(f.type)) for f in structs.STRUCTS[name].fields]
    return type(name, (ctypes.Structure,), {"_fields_": fields})


def offset(name: str, path: str) -> int:
    """Byte offset of a field, by a dotted path for a nested struct ("opt.timestep")."""
    kind: CType = struct(name)
    total = 0
    for part in path.split("."):
        total += getattr(kind, part).offset
        kind = dict(kind._fields_)[part]
    return total


def _ctype(node: ast_nodes.ValueType | ast_nodes.AnonymousStructDecl) -> CType:
    if isinstance(node, ast_nodes.PointerType):
        return ctypes.c_void_p
    if isinstance(node, ast_nodes.ArrayType):
        kind = _ctype(node.inner_type)
        for extent in reversed(node.extents):
            kind = kind * extent
        return kind
    if isinstance(node, ast_nodes.AnonymousStructDecl):
        fields = [(f.name, _ctype(f.type)) for f in node.fields]
        return type("anonymous", (ctypes.Structure,), {"_fields_": fields})
    name = node.name.rstrip("_")
    if name in structs.STRUCTS:
        return struct(name)
    return _PRIMITIVE.get(node.name, ctypes.c_int)  # what is left are enums
