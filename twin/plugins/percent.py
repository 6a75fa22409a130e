"""A warning for slip that seems to be in percent. Slip is a ratio; values are never rescaled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.streams import Streams, Table

MOVING_MPS = 0.5
"""Slip is ignored below this speed, as it is then a ratio of two noises [m/s]."""
LARGEST_MEDIAN = 1.0
"""Slip is at most 1 in size by its definition, and so is its median."""


def percent_note(what: str, table: Table, streams: Streams | None = None) -> str | None:
    """A sentence if the median slip of a table is above 1 in size while moving; None if not.

    Args:
        what: what the slip is of, as the sentence says it.
        table: `epoch_ns` and, where it has them, `slip`, `speed_mps` and `wheel_speed_mps`.
        streams: whose GNSS says what is moving, where the table has no speed.
    """
    if "slip" not in table:
        return None
    slip = np.asarray(table["slip"], np.float64)
    known = slip[np.isfinite(slip) & _moving(table, streams)]
    median = float(np.median(known)) if len(known) else 0.0
    if abs(median) <= LARGEST_MEDIAN:
        return None
    return (
        f"{what} has median {median:.3g}: it looks like percent; "
        f"slip is a ratio, {median / 100:.3g}"
    )


def _moving(table: Table, streams: Streams | None) -> NDArray[np.bool_]:
    """Rows in which the machine moves; all rows if no speed is available."""
    for column in ("speed_mps", "wheel_speed_mps"):
        if column in table and np.isfinite(table[column]).any():
            return np.abs(table[column]) > MOVING_MPS
    count = len(table["slip"])
    if streams is None or not len(streams.column("gnss", "v_east_mps")):
        return np.ones(count, np.bool_)
    epoch_ns = streams["gnss"]["epoch_ns"]
    speed = np.hypot(streams.column("gnss", "v_east_mps"), streams.column("gnss", "v_north_mps"))
    seen = np.isfinite(speed)
    if not seen.any():
        return np.ones(count, np.bool_)
    order = np.argsort(epoch_ns[seen], kind="stable")
    return np.interp(table["epoch_ns"], epoch_ns[seen][order], speed[seen][order]) > MOVING_MPS
