"""The ignition off and on again: gaps, counters and biases that restart, a clock that jumps.

    off             no sample arrives
    on + 2 s        the units have started: counters count from zero, the IMU has a new turn-on
                    bias, and the computer's clock is off by up to half a second
    on + 5 s        the receiver has a fix (single, float, then fixed, as after a blocked sky); it
                    sets the clock, which jumps once

The computer stamps all samples except those of the GNSS receiver. The simulated machine is not
switched off, so the scenario should stop it for that time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput, check_range
from twin.sensors.fix import Outage
from twin.sensors.noise import Array, generator
from twin.sensors.own import State
from twin.streams import COLUMNS, Table

START_S = 2.0
"""Time from switching on to the first sample of a unit [s]; assumed."""
FIX_S = 5.0
"""Time from switching on to the receiver's first fix, a hot start [s]; assumed."""
CLOCK_S = 0.5
"""Greatest error of the computer's clock after switching on [s]: the hardware clock stores whole
seconds, and Linux adds half a second (drivers/rtc/class.c, rtc_hctosys)."""

Pairs = tuple[tuple[float, float], ...]
Held = Mapping[str, State]
"""State of a stream from chunk to chunk: counts at a restart, the last arrival."""


@dataclass(frozen=True, kw_only=True)
class Restart:
    """One time without ignition, with its random errors."""

    off_ns: int
    on_ns: int
    clock_ns: int
    """How far the computer's clock is ahead until the receiver sets it."""
    imu: Array
    """Change of the IMU's turn-on bias from the run's start, gyroscopes first, in units of the
    data-sheet sd. (6,)."""

    @property
    def set_ns(self) -> int:
        """Time at which the receiver has a fix and sets the clock."""
        return self.on_ns + round(FIX_S * 1e9)

    def ready_ns(self, stream: str) -> int:
        """Time from which the unit of a stream measures again."""
        return self.set_ns if stream == "gnss" else self.on_ns + round(START_S * 1e9)


def check(off_s: Pairs) -> None:
    """Check times without ignition, pairs of start and duration [s].

    Raises:
        OutOfRange: a start or a duration is out of range.
        BadInput: one begins before the receiver has its fix after the one before.
    """
    ready_s = 0.0
    for start_s, duration_s in off_s:
        check_range("sensors.ignition_off_s start", start_s, 0.0, 1e6)
        check_range("sensors.ignition_off_s duration", duration_s, 0.01, 1e6)
        if start_s < ready_s:
            raise BadInput(
                f"sensors.ignition_off_s: {start_s:g} s is before the receiver is back from the"
                f" last one at {ready_s:g} s; a later one would do"
            )
        ready_s = start_s + duration_s + FIX_S


def outages(off_s: Pairs, others: Sequence[Outage]) -> tuple[Outage, ...]:
    """The outages `others` with those that the ignition causes, in order of their start."""
    own = [Outage(start_s=t, duration_s=d + FIX_S, kind="block") for t, d in off_s]
    return tuple(sorted((*others, *own), key=lambda outage: outage.start_s))


def restarts(off_s: Pairs, seed: int, start_ns: int) -> tuple[Restart, ...]:
    """The times without ignition `off_s` (start, duration) with errors drawn from the seed."""
    first = generator(seed, "imu", "turn-on").standard_normal(6)
    found = []
    for k, (at_s, duration_s) in enumerate(off_s):
        off_ns = start_ns + round(at_s * 1e9)
        clock_s = generator(seed, "ignition", f"clock {k}").uniform(-CLOCK_S, CLOCK_S)
        found.append(
            Restart(
                off_ns=off_ns,
                on_ns=off_ns + round(duration_s * 1e9),
                clock_ns=round(clock_s * 1e9),
                imu=generator(seed, "ignition", f"turn-on {k}").standard_normal(6) - first,
            )
        )
    return tuple(found)


def switched(
    plan: Sequence[Restart], stream: str, table: Table, imu_sd: Array, held: Held
) -> tuple[Table, Held]:
    """Apply the ignition to a stream's samples; return the samples and the new state.

    Samples without ignition are removed; counters, IMU bias and stamps change after it.

    Args:
        plan: times without ignition, in order.
        stream: name of the stream.
        table: the stream's samples in a chunk, with their true stamps.
        imu_sd: data-sheet sd of the IMU's turn-on bias, gyroscopes first, (6,).
        held: state of this stream after the last chunk.
    """
    after, out = dict(held), dict(table)
    epoch_ns = table["epoch_ns"]
    kept = np.ones(len(epoch_ns), bool)
    shift_ns = np.zeros(len(epoch_ns), np.int64)
    for k, restart in enumerate(plan):
        kept &= (table["arrival_ns"] < restart.off_ns) | (epoch_ns >= restart.ready_ns(stream))
        until = plan[k + 1].off_ns if k + 1 < len(plan) else np.iinfo(np.int64).max
        since = (epoch_ns >= restart.on_ns) & (epoch_ns < until)
        if stream == "imu":
            out |= {
                name: np.where(since, out[name] + sd * drawn, out[name])
                for name, sd, drawn in zip(COLUMNS["imu"], imu_sd, restart.imu, strict=True)
            }
        for name in (c for c in table if c.startswith("ticks_")):
            if since.any():
                base = after.setdefault(f"{name} {k}", int(table[name][np.argmax(since)]))
                out[name] = np.where(since, table[name] - base, out[name])
        if stream != "gnss":
            shift_ns += np.where(since & (epoch_ns < restart.set_ns), restart.clock_ns, 0)
    out["epoch_ns"], arrival_ns = epoch_ns + shift_ns, table["arrival_ns"] + shift_ns
    out = {name: column[kept] for name, column in out.items()}
    out["arrival_ns"], after["arrival_ns"] = _in_order(arrival_ns[kept], after.get("arrival_ns", 0))
    return out, after


def _in_order(arrival_ns: NDArray[np.int64], last_ns: int) -> tuple[NDArray[np.int64], int]:
    """Arrivals of a stream that never overtake each other, also where the clock is set back."""
    ordered = np.maximum.accumulate(np.concatenate([[last_ns], arrival_ns]))
    return ordered[1:], int(ordered[-1])
