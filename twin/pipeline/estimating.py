"""What an estimator makes of streams; failures and malformed tables as errors that say where."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from twin.errors import BadInput, TwinError
from twin.plugins.lookup import line, where
from twin.streams import Setup, Streams, Table


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
