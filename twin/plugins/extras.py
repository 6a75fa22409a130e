"""Packages that only some users need: messages for an absent package and a damaged file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

from twin.errors import BadInput


def needed(module: str, extra: str, what: str, package: str) -> Any:
    """An optional module. Raises BadInput that says what to install.

    Args:
        module: its name.
        extra: the extra of this distribution that brings it.
        what: what needs it, in words.
        package: what holds it.
    """
    try:
        return import_module(module)
    except ImportError:
        raise BadInput(f"{what} need {package}: pip install '.[{extra}]' in a checkout") from None


@contextmanager
def refused_if_damaged(what: str) -> Iterator[None]:
    """A library at work on a file: whatever it raises is BadInput, `not WHAT that can be read`."""
    try:
        yield
    except BadInput:
        raise
    except Exception as error:  # a damaged file fails anywhere in it
        raise BadInput(f"not {what} that can be read ({type(error).__name__}: {error})") from None
