"""Import an object by `module:Name`; the module may be in the working directory."""

from __future__ import annotations

import importlib
import os
import re
import sys
import traceback
from pathlib import Path
from typing import Any, TypeAlias

from twin.errors import BadInput, UnknownName

Thing: TypeAlias = Any
"""Any object of a user's module."""
COLOUR = re.compile(r"\x1b\[[0-9;]*m")


def attribute(kind: str, spec: str) -> Thing:
    """The object `module:Name`; `module:` alone means the module itself.

    The working directory is added to the end of the import path, so nothing in it shadows an
    installed package.

    Args:
        kind: what messages call it.
        spec: module and name, dots allowed in both.

    Raises:
        BadInput: the module cannot be imported, or lacks the attribute.
    """
    module, _, path = spec.partition(":")
    found = imported = _module(kind, spec, module)
    for part in path.split(".") if path else ():
        if not hasattr(found, part):
            public = [n for n in dir(found) if not n.startswith("_")]
            missing = UnknownName(f"attribute of {imported.__name__}", part, public)
            raise BadInput(f"{kind} '{spec}': {missing}") from None
        found = getattr(found, part)
    return found


def instance(kind: str, spec: str, found: Thing) -> Thing:
    """The object, or an instance if it is a class. Raises BadInput if the constructor fails."""
    if not isinstance(found, type):
        return found
    try:
        return found()
    except Exception as error:  # whatever a user's constructor raises
        raise BadInput(f"{kind} '{spec}' cannot be made: {line(error)}") from None


def _module(kind: str, spec: str, module: str) -> Thing:
    if os.getcwd() not in sys.path:
        sys.path.append(os.getcwd())
    importlib.invalidate_caches()
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name and (module == error.name or module.startswith(error.name + ".")):
            raise BadInput(f"{kind} '{spec}': there is no module '{error.name}'") from None
        raise BadInput(f"{kind} '{spec}': {module} cannot be imported: {error}") from None
    except Exception as error:  # whatever a user's module raises while it is imported
        raise BadInput(f"{kind} '{spec}': {module} cannot be imported: {line(error)}") from None


def where(error: BaseException, thing: object) -> str:
    """` (mine.py, line 12)`: the deepest line in a thing's own file, or the deepest of all."""
    frames = traceback.extract_tb(error.__traceback__)
    module = sys.modules.get(type(thing).__module__)
    own = [f for f in frames if f.filename == getattr(module, "__file__", None)]
    frame = (own or list(frames))[-1]
    return f" ({Path(frame.filename).name}, line {frame.lineno})"


def line(error: BaseException) -> str:
    """An error in one line: its type and the first line of its message."""
    first = (plain_message(error).splitlines() or [""])[0]
    return f"{type(error).__name__}: {first}" if first else type(error).__name__


def plain_message(error: BaseException) -> str:
    """The message of an error, without terminal colour codes (numba adds them with colorama)."""
    return COLOUR.sub("", str(error))
