"""A run as a folder, complete or not there at all.

    scenario.json (null for a log)  streams/setup.json  streams/<sensor>.parquet  [truth.parquet]
    estimates.parquet (one row per estimator and time)  scores.json  [report.html  run.rrd]

Files in brackets may be absent; truth is absent for a log without a reference. All files are
written into a hidden folder beside the target, which is renamed when it is complete. Nothing is
ever unpickled.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from twin.errors import BadInput, TwinError
from twin.io.atomic import renamed_when_complete
from twin.io.plain import Plain, from_plain, to_plain
from twin.streams import COLUMNS, Array, Setup, Streams, Table, check

SCENARIO, SCORES, TRUTH, ESTIMATES = (
    "scenario.json", "scores.json", "truth.parquet", "estimates.parquet",
)  # fmt: skip
STREAMS, SETUP, REPORT, RECORDING = "streams", "setup.json", "report.html", "run.rrd"


class RunLike(Protocol):
    """What can be written: a simulated run, or the estimates of a log (no scenario)."""

    @property
    def scenario(self) -> Plain:
        """The scenario dataclass, or None for a log."""

    @property
    def setup(self) -> Setup:
        """Set-up that the estimators were given."""

    @property
    def streams(self) -> Streams:
        """Streams that the estimators were given."""

    @property
    def truth(self) -> Table | None:
        """Truth of a simulation, reference of a log, or None."""

    @property
    def estimates(self) -> Mapping[str, Table]:
        """Estimator name -> its estimates."""

    @property
    def wall_s(self) -> float:
        """Time the run took [s]."""


@dataclass(frozen=True, kw_only=True)
class Record:
    """A run as read from its folder, or the estimates of a log."""

    setup: Setup
    streams: Streams
    estimates: Mapping[str, Table]
    scenario: Plain = None
    """The scenario dataclass (or plain values when no type was given to `read`); None for a log."""
    truth: Table | None = None
    wall_s: float = 0.0
    scores: Mapping[str, Plain] | None = None


Picture = Callable[[RunLike, Mapping[str, Plain], Path], None]
"""Writes one more file of the folder from the run and its scores."""


def default_directory(name: str, seed: int) -> Path:
    """runs/<name>-seed<N> below the working directory; what is no part of a name becomes -."""
    plain = re.sub(r"[^\w.+-]", "-", name)
    return Path("runs") / f"{plain}-seed{seed}"


def refuse_foreign(directory: Path) -> None:
    """Raise BadInput if the target exists and is not a run folder (it would be replaced)."""
    ours = directory.is_dir() and any((directory / f).exists() for f in (SCENARIO, SCORES))
    empty = directory.is_dir() and not any(directory.iterdir())
    if directory.exists() and not (ours or empty):
        raise BadInput(f"{directory} exists and is not a run folder; choose another --out")


def write(
    run: RunLike,
    scores: Mapping[str, Plain],
    directory: Path,
    *,
    pictures: Mapping[str, Picture] | None = None,
) -> Path:
    """Write a run folder; it appears under its name only when complete.

    Args:
        run: the run.
        scores: what goes into scores.json.
        directory: its final name; an earlier run folder there is replaced.
        pictures: file name -> function that writes it (report, recording).

    Returns:
        The directory.

    Raises:
        BadInput: the name is taken by something else, or cannot be written.
    """
    refuse_foreign(directory)
    with renamed_when_complete(directory) as partial:
        _write_all(run, scores, partial)
        for name, picture in (pictures or {}).items():
            picture(run, scores, partial / name)
    return directory


class Evidence(Protocol):
    """What a failed simulation leaves behind, as `twin.simulation.guard.Evidence` does."""

    @property
    def scenario(self) -> Plain:
        """What was run."""

    def write(self, directory: Path) -> None:
        """Write it all into a directory."""


def write_failed(evidence: Evidence) -> Path:
    """Write what repeats a failed run as runs/failed-<name>-seed<N>; returns the folder.

    Raises:
        BadInput: the name is taken by something else.
    """
    scenario = evidence.scenario
    directory = default_directory(f"failed-{scenario.name}", scenario.seed)
    refuse_foreign(directory)
    with renamed_when_complete(directory) as partial:
        evidence.write(partial)
    return directory


def _write_all(run: RunLike, scores: Mapping[str, Plain], directory: Path) -> None:
    (directory / STREAMS).mkdir()
    (directory / SCENARIO).write_text(_json(to_plain(run.scenario)))
    (directory / SCORES).write_text(_json(scores))
    (directory / STREAMS / SETUP).write_text(run.setup.to_json() + "\n")
    for name, table in run.streams.tables.items():
        if all(np.ndim(column) == 1 for column in table.values()):
            write_parquet(table, directory / STREAMS / f"{name}.parquet")
    if run.truth:
        write_parquet(run.truth, directory / TRUTH)
    write_parquet(stack(run.estimates), directory / ESTIMATES)


def read(directory: Path, scenario_type: type | None = None) -> Record:
    """A run folder as it was written.

    Args:
        directory: the folder.
        scenario_type: dataclass to make of scenario.json; without it the plain values stay.

    Raises:
        BadInput: it is no run folder, or a file in it is missing or damaged; says which.
    """
    if not directory.is_dir():
        raise BadInput(f"{directory} is not a run folder: there is no such directory")
    raw = _read_json(directory / SCENARIO)
    scenario = from_plain(scenario_type, raw) if scenario_type and raw is not None else raw
    setup = _read_setup(directory / STREAMS / SETUP)
    return Record(
        scenario=scenario,
        setup=setup,
        streams=read_streams(directory / STREAMS, setup),
        truth=read_parquet(directory / TRUTH) if (directory / TRUTH).exists() else None,
        estimates=unstack(read_parquet(directory / ESTIMATES)),
        scores=_read_json(directory / SCORES),
    )


def read_streams(directory: Path, setup: Setup) -> Streams:
    """The Parquet tables of a streams folder, the set-up's `extra` among them. Raises BadInput."""
    paths = {name: directory / f"{name}.parquet" for name in (*COLUMNS, *setup.extra)}
    streams = Streams({n: read_parquet(p) for n, p in paths.items() if p.exists()})
    try:
        check(streams, setup.extra)
    except TwinError as error:
        raise BadInput(f"{directory}: {error}") from None
    return streams


def stack(estimates: Mapping[str, Table]) -> Table:
    """Estimates of all estimators below each other; a column one does not give is NaN there."""
    names = sorted({c for t in estimates.values() for c in t}, key=_estimate_order)
    lengths = [len(t["epoch_ns"]) for t in estimates.values()]
    long: Table = {"estimator": np.repeat(np.array(list(estimates), dtype=np.str_), lengths)}
    for column in names:
        parts = [t.get(column, np.full(len(t["epoch_ns"]), np.nan)) for t in estimates.values()]
        long[column] = np.concatenate(parts)
    return long


def unstack(long: Table) -> dict[str, Table]:
    """Inverse of `stack`; columns that are all NaN for an estimator are left out."""
    names = long.get("estimator", np.empty(0, np.str_))
    estimates: dict[str, Table] = {}
    for name in dict.fromkeys(names.tolist()):
        rows = names == name
        table = {c: v[rows] for c, v in long.items() if c != "estimator"}
        estimates[name] = {c: v for c, v in table.items() if not _all_nan(v)}
    return estimates


def _estimate_order(column: str) -> tuple[bool, str]:
    return column != "epoch_ns", column


def _all_nan(column: Array) -> bool:
    return column.dtype.kind == "f" and len(column) > 0 and bool(np.isnan(column).all())


def write_parquet(table: Table, path: Path) -> None:
    """One table as Parquet, zstd compressed, types kept."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    arrays = {name: pa.array(np.ascontiguousarray(column)) for name, column in table.items()}
    pq.write_table(pa.table(arrays), path, compression="zstd")


def read_parquet(path: Path) -> Table:
    """One table from Parquet. Raises BadInput for a missing or damaged file."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.ParquetFile(path).read()
    except FileNotFoundError:
        raise BadInput(f"{path} is missing") from None
    except (pa.ArrowException, OSError, ValueError) as error:
        raise BadInput(f"{path} is not a whole Parquet file: {_first_line(error)}") from None
    return {name: _column(table.column(name)) for name in table.column_names}


def _column(column: Plain) -> Array:
    values: Array = column.to_numpy()
    return values.astype(np.str_) if values.dtype == object else values


def _read_setup(path: Path) -> Setup:
    try:
        return Setup.from_json(path.read_text())
    except FileNotFoundError:
        raise BadInput(f"{path} is missing") from None
    except (OSError, UnicodeDecodeError, BadInput) as error:
        raise BadInput(f"{path}: {_first_line(error)}") from None


def _read_json(path: Path) -> Plain:
    try:
        return json.loads(path.read_text())
    except FileNotFoundError:
        raise BadInput(f"{path} is missing") from None
    except (OSError, ValueError) as error:
        raise BadInput(f"{path} is not JSON: {_first_line(error)}") from None


def _json(value: Plain) -> str:
    return json.dumps(value, indent=2, allow_nan=False, default=_number) + "\n"


def _number(value: Plain) -> Plain:
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"{type(value).__name__} is not a JSON value")


def _first_line(error: BaseException) -> str:
    lines: Sequence[str] = str(error).splitlines()
    return lines[0] if lines else type(error).__name__
