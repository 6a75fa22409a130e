"""Tables as rerun takes them: time columns, thinned rows, positions and axes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from twin.streams import Table
from twin.viz.paths import SIM_TIME, STEP

Array = NDArray[Any]

LARGE_M = 2.55
"""Wheelbase of the tractor that lines, cells and distances are meant for [m]."""
LONGEST_S = 3600.0
"""Of a longer drive the rates are lowered, so that a recording stays as large as one of an hour
[s]."""
STEP_S = 0.002
"""`step` counts physics steps [s]."""


def times(table: Mapping[str, Array]) -> list[rr.TimeColumn]:
    """Both timelines of a table's rows."""
    time_s = np.asarray(table["epoch_ns"], np.float64) * 1e-9
    steps = np.round(time_s / STEP_S).astype(np.int64)
    return [rr.TimeColumn(SIM_TIME, duration=time_s), rr.TimeColumn(STEP, sequence=steps)]


def set_time(recording: rr.RecordingStream, epoch_ns: int) -> None:
    """What is logged next is of this time."""
    time_s = float(epoch_ns) * 1e-9
    recording.set_time(SIM_TIME, duration=time_s)
    recording.set_time(STEP, sequence=round(time_s / STEP_S))


def every(table: Table, rate_hz: float) -> Table:
    """At most `rate_hz` rows a second, in all no more than in an hour; the last one included."""
    epoch_ns = table["epoch_ns"]
    n = len(epoch_ns)
    span_s = float(epoch_ns[-1] - epoch_ns[0]) * 1e-9 if n > 1 else 0.0
    rate_hz *= min(1.0, LONGEST_S / span_s) if span_s > 0.0 else 1.0
    stride = max(1, round((n - 1) / (span_s * rate_hz))) if span_s > 0.0 else 1
    rows = np.arange(0, n, stride)
    rows = rows if n == 0 or rows[-1] == n - 1 else np.append(rows, n - 1)
    return {name: column[rows] for name, column in table.items()}


def position_w(truth: Table) -> Array:
    """Rear-axle centre in the world [m]. Shape (n, 3)."""
    return np.stack([truth["east_m"], truth["north_m"], truth["up_m"]], axis=1)  # (n, 3)


def axes_w(truth: Table) -> tuple[Array, Array, Array]:
    """Body axes forward, left, up in the world. Shape (n, 3) each."""
    w, x, y, z = (truth[c] for c in ("qw", "qx", "qy", "qz"))
    forward = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], 1)
    left = np.stack([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)], 1)
    return forward, left, np.cross(forward, left)


def rgba(colour: str) -> list[int]:
    """`#rrggbb` or `#rrggbbaa` as numbers."""
    return list(bytes.fromhex(colour.removeprefix("#")))
