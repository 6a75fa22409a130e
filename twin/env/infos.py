"""Infos of many tractors: arrays over all, each with a mask of whom it concerns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Infos: TypeAlias = dict[str, Any]


def columns(rows: Sequence[Infos], ids: Sequence[int], mask: NDArray[np.bool_]) -> Infos:
    """Infos of the tractors in the mask as arrays over all, as Gymnasium's `_add_info` fills."""
    infos, concerned = Infos(), mask.copy()
    for name, first in rows[0].items():
        column = np.zeros(len(mask)) if isinstance(first, float) else np.empty(len(mask), object)
        infos[name], infos[f"_{name}"] = column, concerned
    for i, row in zip(ids, rows, strict=True):
        for name, value in row.items():
            infos[name][i] = value
    return infos


def add(infos: Infos, values: Mapping[str, ArrayLike], mask: NDArray[np.bool_]) -> None:
    """Values of the tractors in the mask, 0 for the others, with the mask beside them."""
    (ids,), concerned = mask.nonzero(), mask.copy()
    all_values = np.zeros((len(values), len(mask)))
    for row, (name, value) in zip(all_values, values.items(), strict=True):
        row[ids] = value
        infos[name], infos[f"_{name}"] = row, concerned


def masked(kept: Mapping[str, NDArray[Any]], mask: NDArray[np.bool_]) -> Infos:
    """Copies of arrays over all tractors, each with the mask beside it."""
    infos = Infos()
    for name, values in kept.items():
        infos[name], infos[f"_{name}"] = values.copy(), mask.copy()
    return infos
