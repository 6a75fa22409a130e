"""Colours of truth and estimates, the same in the report and in the recording.

Okabe & Ito (2008), Color Universal Design: told apart with every kind of colour vision.
"""

from __future__ import annotations

from collections.abc import Iterable

TRUTH_COLOUR = "#000000"
SEA = "#009E73"
_ESTIMATORS = ("#D55E00", "#0072B2", "#CC79A7", "#E69F00", "#56B4E9", "#009E73")


def colours(names: Iterable[str]) -> dict[str, str]:
    """Name -> colour `#rrggbb`, in order of appearance."""
    return {name: _ESTIMATORS[i % len(_ESTIMATORS)] for i, name in enumerate(names)}
