"""Users' laws, compiled and entered in a table of function addresses.

Soil laws and implement laws share this code; each kind has its own table. A law is compiled once
in a process and identified by a number: a hash of its module's text, its name and the text of the
module that defines the interface. MuJoCo's passive-force callback reads the tables.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba.core.ccallback import CFunc
from numpy.typing import NDArray

from twin.compute.compiled import key
from twin.errors import BadInput
from twin.physics.law_table import MOST_LAWS
from twin.plugins.failing import WRITES
from twin.plugins.lookup import plain_message

Function = Callable[..., Any]
"""A law: a function as `twin.physics.laws` or `twin.physics.implement_laws` describes it."""


@dataclass(frozen=True)
class LawKind:
    """One kind of law, soil or implement: its name in messages, its table, how it is compiled."""

    name: str
    table: NDArray[np.int64]
    """Number and address of each law that this process knows. Shape (MOST_LAWS, 2)."""
    as_c: Callable[[Function], CFunc]
    """Compiles a law that numba knows to a C function."""
    read_only: str
    """Message for a law that writes to its arguments: why it must not, and what to do."""
    file: Path
    """The module that defines the interface: the number covers its text."""
    known: dict[int, tuple[Function, CFunc]] = field(default_factory=dict)
    """Number -> the law as given and as compiled; the table holds only addresses."""

    def register(self, function: Function, name: str) -> float:
        """Compile a law, enter it in the table and return its number, a hash of its source.

        Args:
            function: plain Python, or compiled by numba already.
            name: the law's name in messages.

        Raises:
            BadInput: the law is in no file, cannot be compiled, or the table is full.
        """
        number = int(key(self.file, self._source(function, name), name)[:12], 16)
        known = self.known.get(number)
        if known is None or known[0] is not function:  # loaded anew, perhaps with what it imports
            compiled = self._compile(function, name)
            self.enter(number, compiled, name)
            self.known[number] = function, compiled
        return float(number)

    def enter(self, number: int, compiled: CFunc, name: str) -> None:
        """Enter a compiled law in the table; it replaces a law with the same number.

        Raises:
            BadInput: the table is full.
        """
        same = np.flatnonzero((self.table[:, 0] == number) & (self.table[:, 1] != 0))
        rows = same if same.size else np.flatnonzero(self.table[:, 1] == 0)
        if not rows.size:
            raise BadInput(f"{self.name} '{name}': this process knows {MOST_LAWS} laws already")
        self.table[rows[0], 0], self.table[rows[0], 1] = number, compiled.address or 0

    def _source(self, function: Function, name: str) -> str:
        """Text of a law's file."""
        try:
            module = inspect.getmodule(getattr(function, "py_func", function))
            return inspect.getsource(module)  # type: ignore[arg-type]  # None is a TypeError too
        except (OSError, TypeError):
            raise BadInput(f"{self.name} '{name}' is no function of a module in a file") from None

    def _compile(self, function: Function, name: str) -> CFunc:
        """The law as a C function; not cached on disk, so that it cannot be stale."""
        try:
            pure = function
            if not hasattr(function, "py_func"):
                pure = numba.njit(error_model="numpy")(function)
            return self.as_c(pure)
        except Exception as error:  # whatever numba says of a user's function
            text = plain_message(error)
            said = [n for n in text.splitlines() if n and not n.startswith("Failed in nopython")]
            reason = said[0] if said else type(error).__name__
            if WRITES.search(text):
                reason = self.read_only
            raise BadInput(f"{self.name} '{name}' cannot be compiled: {reason}") from None
