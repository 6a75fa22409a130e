"""What holds for every estimator, whatever it does inside.

A check takes an estimator and raises AssertionError with a sentence that says what was found.
"""

from __future__ import annotations

import copy
import dataclasses
import itertools
import pickle
from collections.abc import Iterable
from functools import cache

import numpy as np

from twin.pipeline.estimating import Estimator
from twin.streams import ESTIMATES, Setup, Streams, Table, concatenate
from twin.testing import drives
from twin.testing.drives import Array, Drive, seconds

SETUP = drives.setup()
DRIVE = Drive(duration_s=6.0, gnss_delay_s=0.07, pitch=lambda t: 0.01 * np.sin(9 * t))
STEADY = Drive(duration_s=8.0, speed=lambda t: 1.6 + 0.0 * t, slip=lambda t: 0.12 + 0.0 * t)
"""What every model can explain: constant speed and slip, without pitch or delay."""


SENSORS = ("gnss", "imu", "wheels")
SETTLED_S = 2.0
"""Time after which an estimate has to be right [s]."""
RIGHT = 0.06
"""Median error of slip that no estimator needs, after two seconds [-]."""
LEAST_COVERAGE, SEEDS = 0.5, 5
"""Share of errors within two reported standard deviations, over this many drives; 0.954 is due, and
far less is a filter that is sure of what it does not know."""


@cache
def sample_streams(seed: int = 1) -> Streams:
    """Six seconds of gnss, imu and wheels with noise, the slip around 0.12."""
    return drives.streams(DRIVE, SETUP, seed)


def run(
    estimator: Estimator, chunks: Iterable[Streams], setup: Setup = SETUP
) -> tuple[Table, list[object]]:
    """The table of all estimates over chunks, and the states before and between them."""
    states: list[object] = [estimator.init(setup)]
    tables: list[Table] = []
    for chunk in chunks:
        state, table = estimator.run(states[-1], chunk)
        states.append(state)
        tables.append(table)
    return {k: np.concatenate([t[k] for t in tables]) for k in tables[0]}, states


def bits(table: Table) -> dict[str, bytes]:
    """The columns of a table as bytes: equal only where every bit is."""
    return {name: column.tobytes() for name, column in table.items()}


def check_columns(estimator: Estimator) -> None:
    """Estimates have known columns of equal length, and epochs that increase."""
    table, _ = run(estimator, [sample_streams()])
    unknown = set(table) - set(ESTIMATES)
    assert not unknown, f"columns {sorted(unknown)} are unknown; there are: {', '.join(ESTIMATES)}"
    missing = {"epoch_ns", "slip"} - set(table)
    assert not missing, f"columns {sorted(missing)} are missing"
    lengths = {name: len(column) for name, column in table.items()}
    assert len(set(lengths.values())) == 1, f"columns have different lengths: {lengths}"
    assert len(table["slip"]) > 50, f"six seconds of samples gave {len(table['slip'])} estimates"
    assert np.all(np.diff(table["epoch_ns"]) > 0), "epoch_ns does not increase from row to row"


def check_chunks(estimator: Estimator) -> None:
    """How the input is cut into chunks changes no bit."""
    if offline(estimator):
        return
    streams = sample_streams()
    whole, _ = run(estimator, [streams])
    for size in (1, 7, 1000):
        parts, _ = run(estimator, streams.chunks(size))
        _same(parts, whole, f"in chunks of {size} samples the estimates differ from one chunk's")


def check_causal(estimator: Estimator) -> None:
    """What comes later changes nothing that was said before."""
    if offline(estimator):
        return
    streams = sample_streams()
    whole, _ = run(estimator, [streams])
    for cut in (1, 100, 333, 500):
        head, _ = run(estimator, [streams.samples(0, cut)])
        before = {k: v[: len(head["epoch_ns"])] for k, v in whole.items()}
        _same(head, before, f"without what follows sample {cut} the estimates before it differ")


def check_deterministic(estimator: Estimator) -> None:
    """The same input gives the same bits again."""
    first, second = (run(estimator, [sample_streams()])[0] for _ in range(2))
    _same(first, second, "a second run over the same input differs")


def check_states(estimator: Estimator) -> None:
    """A state that was kept is not changed by going on from it, and survives pickling."""
    streams = sample_streams()
    half = len(streams) // 2
    _, states = run(estimator, [streams.samples(0, half)])
    before = pickle.dumps(states[-1])
    chunk = streams.samples(half, len(streams))
    _, on = estimator.run(states[-1], chunk)
    assert pickle.dumps(states[-1]) == before, "run changes the state that it is given"
    _, again = estimator.run(pickle.loads(before), chunk)  # our own bytes of a moment ago
    _same(again, on, "going on from a pickled state differs")


def check_input_unchanged(estimator: Estimator) -> None:
    """The input is not changed, and need not be writeable."""
    streams = sample_streams()
    frozen = {s: {k: v.copy() for k, v in t.items()} for s, t in streams.tables.items()}
    kept = copy.deepcopy(frozen)
    for column in (c for table in frozen.values() for c in table.values()):
        column.flags.writeable = False
    try:
        table, _ = run(estimator, [Streams(frozen)])
    except ValueError as error:
        if "read-only" not in str(error):
            raise
        raise AssertionError(f"it writes into its input ({error}); take a .copy()") from error
    assert all(bits(kept[s]) == bits(frozen[s]) for s in kept), "it changes its input"
    _same(table, run(estimator, [streams])[0], "read-only input gives other estimates")


def check_absent_sensors(estimator: Estimator) -> None:
    """Any sensor may be absent; without wheels no slip is known."""
    streams = sample_streams()
    for n in range(len(SENSORS) + 1):
        for present in itertools.combinations(SENSORS, n):
            untold = dataclasses.replace(
                SETUP,
                gnss=SETUP.gnss if "gnss" in present else None,
                imu=SETUP.imu if "imu" in present else None,
            )
            for setup in (SETUP, untold):
                seen = Streams({s: streams[s] for s in present})
                table, _ = run(estimator, [seen], setup)
                known = int(np.isfinite(table["slip"]).sum())
                if "wheels" in present:
                    assert len(table["slip"]) > 50, f"with {present} it gives no estimates"
                else:
                    assert not known, f"with {present} it gives {known} slips, without wheels"


def check_absent_columns(estimator: Estimator) -> None:
    """Any column but the times may be absent."""
    streams = sample_streams()
    for sensor, table in streams.tables.items():
        for column in sorted(table.keys() - {"epoch_ns", "arrival_ns"}):
            rest = {k: v for k, v in table.items() if k != column}
            run(estimator, [Streams({**streams.tables, sensor: rest})])


def check_nan(estimator: Estimator) -> None:
    """NaN is a measurement that was not made: with a fifth missing the slip is still right.

    Over seven patterns of holes: a search over four seconds may lose its way in one.
    """
    medians = []
    for seed in range(7):
        table, _ = run(estimator, [_with_holes(seed)])
        assert not np.isinf(table["slip"]).any(), "a slip is infinite"
        error = _errors(table)
        share = float(np.isfinite(error).mean())
        assert share > 0.5, f"with a fifth of all values missing it knows {share:.0%} of the slips"
        medians.append(np.nanmedian(np.abs(error)))
    found = float(np.median(medians))
    assert found < RIGHT, f"with a fifth of all values missing slip is off by {found:.3f}"


def check_gap(estimator: Estimator) -> None:
    """Twenty seconds without a sample; two seconds after it slip is right again."""
    later = {
        s: {
            k: np.where(t["epoch_ns"] > 3_000_000_000, v + 20_000_000_000, v)
            if k in ("epoch_ns", "arrival_ns")
            else v
            for k, v in t.items()
        }
        for s, t in sample_streams().tables.items()
    }
    table, _ = run(estimator, [Streams(later)])
    t = seconds(table["epoch_ns"])
    after = t > 24.0
    assert after.sum() > 15, f"after a gap of 20 s it gives {after.sum()} estimates"
    found = float(np.nanmedian(np.abs(table["slip"] - DRIVE.slip(t - 20.0))[after]))
    assert found < RIGHT, f"two seconds after a gap of 20 s slip is off by {found:.3f}"


def check_time_backwards(estimator: Estimator) -> None:
    """Old samples that arrive anew change no estimate, only the flags of one or two."""
    streams = sample_streams()
    old = {
        s: {
            k: (np.full_like(v, 4_000_000_000) if k == "arrival_ns" else v)[10:20]
            for k, v in t.items()
        }
        for s, t in streams.tables.items()
    }
    arrivals = np.concatenate([t["arrival_ns"] for t in streams.tables.values()])
    at = int(np.searchsorted(np.sort(arrivals), 4_000_000_000, side="right"))
    head, tail = streams.samples(0, at), streams.samples(at, len(streams))
    clean, _ = run(estimator, [head, tail])
    disturbed, _ = run(estimator, [concatenate([head, Streams(old)]), tail])
    for table in (clean, disturbed):
        table.pop("flags", None)
    _same(disturbed, clean, "samples that arrive a second time change the estimates")


def check_honest(estimator: Estimator) -> None:
    """At constant speed and slip the reported sd, if any, is of the size of the error."""
    inside = []
    for seed in range(SEEDS):
        table, _ = run(estimator, [drives.streams(STEADY, SETUP, seed)])
        if "slip_sd" not in table:
            return
        sd = table["slip_sd"][seconds(table["epoch_ns"]) > SETTLED_S]
        known = sd[np.isfinite(sd)]
        assert np.all(known > 0.0), f"a standard deviation of slip is {known.min():g}"
        error = _errors(table, STEADY)
        both = np.isfinite(error) & np.isfinite(sd)
        inside.append(np.abs(error[both]) < 2.0 * sd[both])
    share = float(np.concatenate(inside).mean())
    found = f"{share:.0%} of its errors are within two of its sd, 95 % is due"
    assert share > LEAST_COVERAGE, found


def offline(estimator: Estimator) -> bool:
    """Whether it is marked as one that needs the whole log."""
    return bool(getattr(estimator, "offline", False))


def _same(found: Table, due: Table, what: str) -> None:
    differing = [k for k, b in bits(due).items() if k not in found or found[k].tobytes() != b]
    assert not differing, f"{what}: {', '.join(differing)}"


def _errors(table: Table, drive: Drive = DRIVE) -> Array:
    t = seconds(table["epoch_ns"])
    error: Array = (table["slip"] - drive.slip(t))[t > SETTLED_S]
    return error


def _with_holes(seed: int) -> Streams:
    """The streams with a fifth of every column's values missing."""
    rng = np.random.default_rng(seed)
    tables: dict[str, Table] = {}
    for sensor, table in sample_streams().tables.items():
        tables[sensor] = dict(table)
        for column in sorted(table.keys() - {"epoch_ns", "arrival_ns"}):
            values = table[column].astype(float)
            values[rng.random(len(values)) < 0.2] = np.nan
            tables[sensor][column] = values
    return Streams(tables)
