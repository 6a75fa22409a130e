"""Innovations: each measurement minus the filter's prediction.

A filter notes them in its memory where they are wanted. Its estimates do not change by it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.estimate import State, unknown
from estimators.kalman import Record
from estimators.layout import OUT_OF_ORDER
from estimators.signals import read
from twin.compute.compiled import compiled, inlined
from twin.streams import COLUMNS, Streams, Table

MOST = 8
"""Most innovations of one sample: four wheels, each by a count and an acceleration."""
NOTES = np.dtype(
    [("wanted", "i8"), ("count", "i8"), ("innovation", "f8", MOST), ("variance", "f8", MOST)],
    align=True,
)
"""The innovations of one sample; a field of a filter's memory."""
KEPT = np.dtype(
    [("epoch_ns", "i8"), ("sensor", "i8"), ("innovation", "f8"), ("variance", "f8")], align=True
)
"""One innovation."""

Noting = Callable[[Any, Any, Any, Any, Any, Any], int]
"""noting(signals, nominal, tuning, memory, rows, kept) -> how many innovations it kept."""


@compiled
def note(notes: Record, innovation: float, variance: float) -> None:
    """Note an innovation e and its variance S, where they are wanted; a NaN is none."""
    if notes.wanted and notes.count < MOST and math.isfinite(innovation) and variance > 0.0:
        notes.innovation[notes.count] = innovation
        notes.variance[notes.count] = variance
        notes.count += 1


@compiled
def keep(notes: Record, signal: Record, kept: Any, count: int) -> int:
    """Move what was noted of a sample into records of KEPT, from number `count` on."""
    for k in range(notes.count):
        kept[count].epoch_ns, kept[count].sensor = signal.epoch_ns, signal.sensor
        kept[count].innovation, kept[count].variance = notes.innovation[k], notes.variance[k]
        count += 1
    notes.count = 0
    return count


@inlined
def each_innovation(
    take: Any, samples: Any, nominal: Record, tuning: Record, memory: Record, rows: Any, kept: Any
) -> int:
    """As `estimate.each_sample`, but what is kept are the innovations; how many.

    Args:
        take, samples, nominal, tuning, memory: as there.
        rows: room for one record of ROW.
        kept: records of KEPT to write, MOST for each sample.
    """
    count = 0
    for i in range(len(samples)):
        if not samples[i].flags & OUT_OF_ORDER:
            take(samples[i], nominal, tuning, memory, rows[0])
            count = keep(memory.notes, samples[i], kept, count)
    return count


def innovations(noting: Noting, state: State, streams: Streams) -> Table:
    """All innovations of a filter over streams: `epoch_ns`, `sensor`, `innovation`, `variance`.

    Args:
        noting: a compiled loop over samples, with `each_innovation`.
        state: before the first sample.
        streams: what it sees.
    """
    reader, samples = read(state.reader, streams)
    memory, kept = state.memory.copy(), np.zeros(MOST * len(samples), KEPT)
    memory["notes"]["wanted"] = 1
    count = 0
    if len(samples):
        nominal, tuning = reader.nominal[0], state.tuning[0]
        count = noting(samples, nominal, tuning, memory[0], unknown(1), kept)
    return as_table(kept[:count])


def as_table(kept: NDArray[Any]) -> Table:
    """Records of KEPT as columns; the sensor by name."""
    names = np.array([*COLUMNS])
    table = {name: np.ascontiguousarray(kept[name]) for name in KEPT.names or ()}
    return table | {"sensor": names[kept["sensor"]]}
