"""numba's types of calls, found once for each function of numba's and types of its arguments.

Compiled code of ours asks for the type of some 8000 calls, nineteen of twenty of which were asked
for before: `a + b` of two floats. numba tries a dozen templates for each, a sixth of compiling.
"""

from __future__ import annotations

from functools import cache
from typing import Any, TypeAlias

from numba.core.types import BaseFunction
from numba.core.typing.context import Context

Untyped: TypeAlias = Any
"""What is numba's own, which has no types."""


class _Remembering(Context):  # type: ignore[misc]  # numba has no types
    """A typing context that is another, but for what it remembers."""

    def __init__(self, other: Context) -> None:
        self.__dict__ = other.__dict__
        self.known_calls: dict[Untyped, Untyped] = {}

    def resolve_function_type(self, func: Untyped, args: Untyped, kws: Untyped) -> Untyped:
        """Signature of a call; only a function of numba's own has the same one every time."""
        known = self._lookup_global(func) or func  # `operator.add` has a type, too
        if not isinstance(known, BaseFunction):
            return super().resolve_function_type(func, args, kws)
        call = known, tuple(args), tuple(sorted(kws.items()))
        if call not in self.known_calls:
            found = super().resolve_function_type(func, args, kws)
            if found is None:
                return None
            self.known_calls[call] = found
        return self.known_calls[call]


@cache
def remembering(context: Context) -> Context:
    """The context, which remembers the signatures of calls."""
    return _Remembering(context)
