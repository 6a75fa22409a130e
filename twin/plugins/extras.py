"""Packages that only some users need: an absent one says how it is installed."""

from __future__ import annotations

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
        raise BadInput(f"{what} need {package}: pip install 'tractor-twin[{extra}]'") from None
