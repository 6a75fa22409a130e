"""Run estimators on streams; failures and malformed tables are errors that say where."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from twin.errors import BadInput, TwinError, UnknownName
from twin.plugins.failing import failing
from twin.plugins.percent import percent_note
from twin.streams import ESTIMATES, Setup, Streams, Table

QUANTITIES = tuple(c for c in ESTIMATES if c not in ("epoch_ns", "flags"))
"""Quantities that an estimate may have."""


State: TypeAlias = Any
"""Whatever an estimator keeps from one chunk to the next."""


class Estimator(Protocol):
    """Interface of an estimator: `init` gives a state; `run` gives a new state and estimates."""

    def init(self, setup: Setup) -> State:
        """State before the first sample."""

    def run(self, state: State, chunk: Streams) -> tuple[State, Table]:
        """New state, and the table of estimates of the chunk.

        Args:
            state: result of `init`, or of `run` on the previous chunk.
            chunk: next part of the streams.
        """


@dataclass(frozen=True)
class Estimated:
    """Tables of several estimators, and a note on each estimator that failed."""

    tables: dict[str, Table]
    failed: dict[str, str]
    """Estimator -> why it failed."""
    notes: tuple[str, ...] = ()
    """What a reader should know of them: the failures, and a slip that looks like percent."""


def all_estimates(
    estimators: Mapping[str, Estimator],
    setup: Setup,
    streams: Streams,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Estimated:
    """Estimates of every estimator over whole streams; a failed one gives NaN and a note.

    Args:
        estimators: name -> estimator.
        setup: set-up of the sensors, an argument of each estimator.
        streams: measurements, an argument of each estimator.
        progress: called as progress(done, total) with numbers of estimators.
    """
    tables: dict[str, Table] = {}
    failed: dict[str, str] = {}
    notes: list[str | None] = []
    for done, (name, estimator) in enumerate(estimators.items()):
        progress(done, len(estimators))
        try:
            tables[name] = estimates(name, estimator, setup, streams)
            notes.append(percent_note(f"slip of '{name}'", tables[name], streams))
        except TwinError as error:
            tables[name] = _unknown(streams)
            failed[name] = str(error)
            notes.append(failed[name])
    return Estimated(tables, failed, tuple(note for note in notes if note is not None))


def _unknown(streams: Streams) -> Table:
    """Estimates that say nothing, at the epochs of the longest stream."""
    epochs = [table["epoch_ns"] for table in streams.tables.values()]
    epoch_ns = max(epochs, key=len, default=np.empty(0, np.int64))
    return {"epoch_ns": epoch_ns, "slip": np.full(len(epoch_ns), np.nan)}


def estimates(name: str, estimator: Estimator, setup: Setup, streams: Streams) -> Table:
    """Table of estimates of one estimator over whole streams; `epoch_ns` [ns] has type int64.

    Args:
        name: name of the estimator in the messages of errors.
        estimator: with `init(setup) -> state` and `run(state, chunk) -> (state, table)`.
        setup: set-up of the sensors.
        streams: measurements; a column that the estimator adds does not reach other estimators.

    Raises:
        BadInput: the estimator fails, `run` does not return a pair, or the table is not valid
            (`twin.streams.ESTIMATES`): a column is unknown, missing, not numeric, or has another
            length than `epoch_ns`.
    """
    own = Streams(streams.tables, streams.frames)  # a column that it adds is not seen by others
    with failing(f"estimator '{name}'", estimator):
        given: object = estimator.run(estimator.init(setup), own)
    if not (isinstance(given, tuple) and len(given) == 2 and isinstance(given[1], Mapping)):
        kind = type(given).__name__
        raise BadInput(f"estimator '{name}': run gives {kind}, not (state, table of estimates)")
    try:
        return _checked(given[1])
    except TwinError as error:
        raise BadInput(f"estimator '{name}': {error}") from None


def _checked(given: Mapping[str, ArrayLike]) -> Table:
    """A table as the contract wants it. Raises BadInput or UnknownName that names the column."""
    for column in given:
        if column not in ESTIMATES:
            raise UnknownName("column of estimates", str(column), ESTIMATES)
    if "epoch_ns" not in given:
        raise BadInput("its estimates have no column epoch_ns")
    if not any(quantity in given for quantity in QUANTITIES):
        raise BadInput(f"its estimates have epoch_ns alone; add one of {', '.join(QUANTITIES)}")
    table = {column: np.asarray(values) for column, values in given.items()}
    table["epoch_ns"] = _stamps(table["epoch_ns"])
    count = table["epoch_ns"].shape
    for column, values in table.items():
        if values.shape != count:
            raise BadInput(
                f"{column} has shape {values.shape}, epoch_ns {count}; "
                "every column needs one value for each epoch"
            )
        if values.dtype.kind not in "biuf":
            raise BadInput(f"{column} holds {values.dtype} values, not numbers")
    return table


def _stamps(epoch_ns: NDArray[np.generic]) -> NDArray[np.int64]:
    """Whole nanoseconds as int64; an empty list counts, seconds do not."""
    if epoch_ns.dtype.kind not in "iuf":
        raise BadInput(f"epoch_ns holds {epoch_ns.dtype} values, not nanoseconds")
    whole = np.asarray(epoch_ns).astype(np.float64)
    odd = ~np.isfinite(whole) | (whole != np.round(whole))
    if odd.any():
        raise BadInput(f"epoch_ns has {whole[odd][0]:g}; it counts whole nanoseconds, not seconds")
    return epoch_ns.astype(np.int64)
