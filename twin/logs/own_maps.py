"""One map from what a user says and what files say of themselves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from twin.logs.column_map import ColumnMap, Source, column_map_from
from twin.logs.signals import Found


def completed(given: ColumnMap | None, found: Mapping[str, Found]) -> ColumnMap:
    """The user's map, and for every section it does not name, that of the first file that has one.

    Args:
        given: the user's map.
        found: file name -> what is in it.
    """
    columns_of = given or ColumnMap()
    for name, each in found.items():
        if each.own_map:
            own = column_map_from(each.own_map)
            columns_of = replace(
                columns_of,
                time=columns_of.time or own.time,
                columns={
                    **{s: _of(name, found, c) for s, c in own.columns.items()},
                    **columns_of.columns,
                },
                setup={**own.setup, **columns_of.setup},
            )
    return columns_of


def _of(name: str, found: Mapping[str, Found], sources: Mapping[str, Source]) -> dict[str, Source]:
    """Sources that say which file they are of, where there are several."""
    if len(found) == 1:
        return dict(sources)
    return {k: replace(s, column=f"{name}:{s.column}") for k, s in sources.items()}
