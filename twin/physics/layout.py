"""Where MuJoCo keeps the fields of mjModel and mjData: byte offsets from its own introspection."""

from __future__ import annotations

import ctypes
from functools import cache

from mujoco.introspect import ast_nodes, structs

_PRIMITIVE: dict[str, type] = {
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
    """Byte offset of a field in the MuJoCo struct `name`; `path` is dotted, as "opt.timestep"."""
    kind = struct(name)
    total = 0
    for part in path.split("."):
        total += getattr(kind, part).offset
        kind = _field(kind, part)
    return total


def _field(kind: type[ctypes.Structure], name: str) -> type[ctypes.Structure]:
    found: type[ctypes.Structure] = {n: of for n, of, *_ in kind._fields_}[name]  # type: ignore[assignment]
    return found


def _ctype(node: ast_nodes.Type) -> type:
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
