"""What of a log cannot be used: left out and counted, up to a limit beyond which it is refused."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput

SHARE = 0.01
"""Bad rows that a log may have, of all its rows."""
ALWAYS = 3
"""Bad rows that every log may have, however short it is."""


@dataclass(frozen=True)
class Loss:
    """Rows of one table, or samples of one signal, that cannot be used for one reason."""

    table: str
    """What the rows are of; the rows of one table count once, whatever is wrong with them."""
    rows: NDArray[np.int64]
    """Their numbers, from 1."""
    of: int
    """How many rows the table has."""
    says: str
    """What is wrong with the first."""
    checked: bool = False
    """Whether a checksum found them, or a clock that was set: then any number may be lost, unless
    the reading is strict."""


@dataclass(frozen=True)
class Limits:
    """Limits on the number of bad rows."""

    share: float = SHARE
    strict: bool = False
    """Refuse a log with a single bad row."""


def judged(losses: Iterable[Loss], limits: Limits) -> list[str]:
    """One note for each loss. Raises BadInput if a table has too many bad rows."""
    found = [loss for loss in losses if len(loss.rows)]
    if found and limits.strict:
        raise BadInput(found[0].says)
    for table in dict.fromkeys(loss.table for loss in found):
        own = [loss for loss in found if loss.table == table and not loss.checked]
        if not own:
            continue
        bad, of = len(np.unique(np.concatenate([loss.rows for loss in own]))), own[0].of
        if bad > max(ALWAYS, limits.share * of):
            most = max(own, key=lambda loss: len(loss.rows))
            raise BadInput(f"{most.says}; {bad} of {of} rows are bad, {limits.share:.0%} may be")
    return [f"{_counted(loss)} left out: {loss.says}" for loss in found]


def _counted(loss: Loss) -> str:
    return f"{len(loss.rows)} of {loss.of} rows"
