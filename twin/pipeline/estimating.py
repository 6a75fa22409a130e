"""What an estimator makes of streams; failures and malformed tables as errors that say where."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from twin.errors import BadInput, TwinError
from twin.plugins.lookup import line, where
from twin.streams import Setup, Streams, Table


class Estimator(Protocol):
    """What consumes streams: a state at the start, then a new state and estimates per chunk."""

    def init(self, setup: Setup) -> Any:
        """State before the first sample."""

    def run(self, state: Any, chunk: Streams) -> tuple[Any, Table]:
        """New state, and what is estimated from the chunk."""


@dataclass(frozen=True)
class Estimated:
    """The tables of several estimators, and what became of those that failed."""

    tables: dict[str, Table]
    failed: dict[str, str]
    """Estimator -> why it failed."""


def all_estimates(
    estimators: Mapping[str, Estimator],
    setup: Setup,
    streams: Streams,
    told: Callable[[int, int], None] = lambda done, total: None,
) -> Estimated:
    """Every estimator over whole streams; one that fails gives NaN and a note, the others go on.

    Args:
        estimators: by name.
        setup, streams: what each is told, and what it sees.
        told: told how many of how many are done.
    """
    tables: dict[str, Table] = {}
    failed: dict[str, str] = {}
    for done, (name, estimator) in enumerate(estimators.items()):
        told(done, len(estimators))
        try:
            tables[name] = estimates(name, estimator, setup, streams)
        except TwinError as error:
            tables[name] = _unknown(streams)
            failed[name] = str(error)
    return Estimated(tables, failed)


def _unknown(streams: Streams) -> Table:
    """Estimates that say nothing, at the epochs of the longest stream."""
    epochs = [table["epoch_ns"] for table in streams.tables.values()]
    epoch_ns = max(epochs, key=len, default=np.empty(0, np.int64))
    return {"epoch_ns": epoch_ns, "slip": np.full(len(epoch_ns), np.nan)}


def estimates(name: str, estimator: Any, setup: Setup, streams: Streams) -> Table:
    """The table of an estimator over whole streams, `epoch_ns` as int64.

    Args:
        name: what messages call it.
        estimator: with `init(setup) -> state` and `run(state, chunk) -> (state, table)`.
        setup, streams: what it is told, and what it sees.

    Raises:
        BadInput: it fails, gives no pair, or a column that is not as long as its epochs.
    """
    try:
        given = estimator.run(estimator.init(setup), streams)
    except TwinError:
        raise
    except Exception as error:  # whatever a user's estimator raises
        text = f"estimator '{name}' fails: {line(error)}{where(error, estimator)}"
        raise BadInput(text) from error
    if not (isinstance(given, tuple) and len(given) == 2 and isinstance(given[1], Mapping)):
        kind = type(given).__name__
        raise BadInput(f"estimator '{name}': run gives {kind}, not (state, table of estimates)")
    table = {column: np.asarray(values) for column, values in given[1].items()}
    table["epoch_ns"] = table.get("epoch_ns", np.empty(0)).astype(np.int64)
    count = table["epoch_ns"].shape
    for column, values in table.items():
        if values.shape != count:
            raise BadInput(
                f"estimator '{name}': {column} has shape {values.shape}, epoch_ns {count}; "
                "every column needs one value for each epoch"
            )
    return table
