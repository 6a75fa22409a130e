"""Estimates as CSV, for a spreadsheet or another program: units in the names, one kind of time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from twin.io.atomic import written_when_complete
from twin.io.run_folder import stack
from twin.streams import Array, Table

if TYPE_CHECKING:
    import pyarrow as pa

DATED_NS = 631_152_000_000_000_000
"""Stamps from 1990-01-01 on are dates; smaller ones count from the start of something."""
RATIOS = ("slip", "slip_sd", "slip_rl", "slip_rr")
"""Pure numbers, which are written in percent."""
_UNITS_NS = (("s", 10**9), ("ms", 10**6), ("us", 10**3), ("ns", 1))


def write(estimates: Mapping[str, Table], path: Path) -> str:
    """Write the estimates of all estimators below each other; how their time is written.

    Columns: `time_utc` (ISO 8601) where stamps are dates, else `time_s` (seconds of the clock of
    the log or run); `estimator`; then what is estimated. Slip is in percent (`slip_percent`).
    Unknown values are empty.

    Args:
        estimates: estimator -> its table.
        path: the file, which appears when complete.

    Raises:
        BadInput: the file cannot be written.
    """
    import pyarrow as pa
    from pyarrow import csv

    long = stack(estimates)
    time_name, times, told = _times(long["epoch_ns"])
    columns = {time_name: pa.array(times), "estimator": pa.array(long["estimator"])}
    for name, values in long.items():
        if name not in ("estimator", "epoch_ns"):
            columns |= _column(name, values)
    with written_when_complete(path) as partial:
        options = csv.WriteOptions(quoting_style="needed")
        csv.write_csv(pa.table(columns), partial, options)
    return told


def _column(name: str, values: Array) -> dict[str, pa.Array]:
    """Named with its unit, unknown values as nulls."""
    import pyarrow as pa

    if name in RATIOS:
        return {f"{name}_percent": pa.array(100.0 * values, from_pandas=True)}
    if name == "flags":
        known = np.isfinite(values)
        return {name: pa.array(np.where(known, values, 0).astype(np.int64), mask=~known)}
    return {name: pa.array(np.asarray(values, np.float64), from_pandas=True)}


def _times(epoch_ns: NDArray[np.int64]) -> tuple[str, Array, str]:
    """Name, values and meaning of the column of time."""
    if len(epoch_ns) and int(epoch_ns.min()) >= DATED_NS:
        unit = next(unit for unit, ns in _UNITS_NS if not np.any(epoch_ns % ns))
        stamps = epoch_ns.astype("datetime64[ns]").astype(f"datetime64[{unit}]").astype(np.str_)
        return "time_utc", np.char.add(stamps, "Z"), "time_utc is ISO 8601"
    return "time_s", epoch_ns * 1e-9, "time_s is in seconds of the log's own clock"
