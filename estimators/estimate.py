"""What all filters here have in common: carry the state through a chunk, write the estimates."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators import signals
from estimators.kalman import Record, slip_and_sd
from estimators.layout import OUT_OF_ORDER, STALE_S
from estimators.wheel_speed import driven_mean, mean_variance
from twin.compute.compiled import compiled, inlined
from twin.streams import ESTIMATES, Setup, Streams, Table

ROW = np.dtype(
    [(n, "i8" if n in ("epoch_ns", "flags") else "f8") for n in ESTIMATES],
    align=True,
)
"""One estimate as compiled code writes it."""

_UNKNOWN = np.array([tuple(0 if ROW[n].kind == "i" else np.nan for n in ESTIMATES)], ROW)

SLOW_MPS = 0.05
"""Below this speed an angle of slip means nothing and is NaN."""

Loop = Callable[[Any, Any, Any, Any, Any], int]
"""loop(signals, nominal, tuning, memory, rows) -> how many rows it wrote."""


@dataclass(frozen=True)
class State:
    """State of a filter between chunks; a plain value."""

    reader: signals.Reader
    tuning: NDArray[Any]
    """One record: the filter's constants."""
    memory: NDArray[Any]
    """One record: what the filter carries."""


def unknown(count: int) -> NDArray[Any]:
    """Records of ROW with unknown values. Shape (count,)."""
    return np.repeat(_UNKNOWN, count)


def begin(setup: Setup, tuning: NDArray[Any], memory: NDArray[Any]) -> State:
    """The state before the first sample."""
    return State(signals.start(setup), tuning, memory)


@inlined
def each_sample(
    take: Any, samples: Any, nominal: Record, tuning: Record, memory: Record, rows: Any
) -> int:
    """Give every sample that is in order to `take`; how many rows were written.

    Args:
        take: compiled, take(signal, nominal, tuning, memory, row) -> whether it wrote the row.
        samples: records of `layout.SIGNALS`, in order of arrival.
        nominal, tuning, memory: what the set-up says, the filter's constants, and what it carries.
        rows: records of ROW to write, as many as samples.
    """
    count = 0
    for i in range(len(samples)):
        memory.flags |= samples[i].flags
        if samples[i].flags & OUT_OF_ORDER:
            continue
        if take(samples[i], nominal, tuning, memory, rows[count]):
            count += 1
    return count


@compiled
def too_old(signal: Record, memory: Record) -> bool:
    """Whether a sample is over STALE_S behind the filter's time; flags it as out of order."""
    if (memory.time_ns - signal.epoch_ns) * 1e-9 > STALE_S:
        memory.flags |= OUT_OF_ORDER
        return True
    return False


def advance(loop: Loop, state: State, chunk: Streams) -> tuple[State, Table]:
    """Run a compiled loop over a chunk: the state after it, and the table of its estimates."""
    reader, samples = signals.read(state.reader, chunk)
    memory = state.memory.copy()
    rows = unknown(len(samples))
    count = loop(samples, reader.nominal[0], state.tuning[0], memory[0], rows) if len(rows) else 0
    return (
        State(reader, state.tuning, memory),
        {name: np.ascontiguousarray(rows[name][:count]) for name in ESTIMATES},
    )


@compiled
def write(
    row: Record,
    signal: Record,
    nominal: Record,
    ground: float,
    ground_var: float,
    wheels: NDArray[np.float64],
    wheel_sd: NDArray[np.float64],
) -> None:
    """Write an estimate from a ground speed and one theoretical speed per wheel.

    The wheels' errors are taken as independent of each other, unless all are one number, and of the
    ground speed's.

    Args:
        row: record of ROW to fill; `epoch_ns` and `flags` are the caller's.
        signal: record of `layout.SIGNALS`.
        nominal: record of `layout.NOMINAL`.
        ground: speed of the rear-axle centre [m/s].
        ground_var: its variance [m2/s2].
        wheels: theoretical speeds [m/s], (4,), NaN where unknown.
        wheel_sd: their standard deviations [m/s], (4,).
    """
    mean_var = mean_variance(wheel_sd, nominal, 1.0, signal.one_driven_speed)
    write_axle(row, signal, nominal, ground, ground_var, driven_mean(wheels, nominal), mean_var)
    across = signal.yaw_rate_radps * 0.5 * nominal.track_rear_m
    row.slip_rl = slip_and_sd(wheels[2], ground - across, 0.0, 0.0, 0.0)[0]
    row.slip_rr = slip_and_sd(wheels[3], ground + across, 0.0, 0.0, 0.0)[0]


@compiled
def write_axle(
    row: Record,
    signal: Record,
    nominal: Record,
    ground: float,
    ground_var: float,
    wheel: float,
    wheel_var: float,
) -> None:
    """Write an estimate from a ground speed and the driven wheels' mean speed.

    sideslip at the rear = atan2(v_y, v_x); at the centre of gravity v_y + x_cg r takes v_y's place.
    sd of the angle = sd(v_y) / |v_x|. The sideslip amounts are those at the last GNSS sample.
    """
    row.speed_mps, row.wheel_speed_mps = ground, wheel
    row.slip, row.slip_sd = slip_and_sd(wheel, ground, wheel_var, ground_var, 0.0)
    v_y = signal.v_y_held_mps
    v_y_cg = v_y + nominal.cg_x_m * signal.yaw_rate_radps
    row.v_y_mps = v_y_cg
    row.sideslip_m, row.sideslip_rear_m = signal.sideslip_m, signal.sideslip_rear_m
    row.sideslip_sd_m = signal.sideslip_sd_m
    if abs(ground) >= SLOW_MPS:
        row.sideslip_rear_rad = math.atan2(v_y, ground)
        row.sideslip_rad = math.atan2(v_y_cg, ground)
        row.sideslip_sd_rad = signal.v_y_held_sd_mps / abs(ground)
