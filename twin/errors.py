"""Errors a user can cause; the message names the value, how much it was, and what is allowed."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class TwinError(Exception):
    """Base of every error a user can cause; the command line prints it as one line."""


class OutOfRange(TwinError, ValueError):
    """A value outside its allowed range."""

    def __init__(self, name: str, value: object, allowed: str) -> None:
        super().__init__(f"{name} = {value} is outside {allowed}")
        self.name, self.value, self.allowed = name, value, allowed


class UnknownName(TwinError, LookupError):
    """An unknown name; the message gives the nearest known one, or all of them."""

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        known = sorted(known)
        near = difflib.get_close_matches(name, known, n=1)
        hint = f"did you mean '{near[0]}'?" if near else f"there are: {', '.join(known) or 'none'}"
        super().__init__(f"no {kind} is called '{name}'; {hint}")


class BadInput(TwinError, ValueError):
    """A file, a stream or an option that cannot be used."""


class NoSpace(BadInput):
    """A disk, or a user's share of it, that is full: nothing is wrong with the input."""


def check_range(name: str, value: float, low: float, high: float) -> None:
    """Raise OutOfRange unless low <= value <= high (NaN is outside)."""
    if not low <= value <= high:
        raise OutOfRange(name, f"{value:g}", f"[{low:g}, {high:g}]")
