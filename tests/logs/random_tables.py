"""Random tables as people have them, made of a drive with known slip, and what became of each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from made_drive import MAP, as_text, drive

from twin.errors import BadInput
from twin.logs import Log, read
from twin.pipeline.estimating import all_estimates
from twin.pipeline.log import slip_warnings
from twin.pipeline.public import by_name

LOUD = (
    "disagree", "median slip", "is its unit", "apart at the median", "no ground speed",
    "no wheel speed", "no slip while driving", "are no velocity",
)  # fmt: skip
"""Parts of notes that say aloud that slip may be wrong or absent."""
TOLERANCE = 0.03


@dataclass
class Made:
    """A table on its way to a file."""

    rng: np.random.Generator
    columns: dict[str, np.ndarray]
    truth: np.ndarray
    text_of: dict[str, object] = field(default_factory=dict)
    map_text: str = MAP
    faults: list[str] = field(default_factory=list)
    delimiter: str = ","
    decimal: str = "."
    encoding: str = "utf-8"
    after: Callable[[bytes, np.random.Generator], bytes] = lambda content, rng: content


def made(seed: int) -> Made:
    """A drive with a random slip, and one to three faults."""
    rng = np.random.default_rng(seed)
    columns = drive(rng.choice([60.0, 120.0]), rng.choice([1.0, 5.0, 10.0]), seed)
    slip = rng.uniform(-0.02, 0.2) + 0.02 * np.sin(columns["t"] / 7.0)
    columns["wheel"] = columns["wheel"] * (1.0 - 0.08) / (1.0 - slip)
    del columns["yaw"]
    table = Made(rng=rng, columns=columns, truth=slip)
    chosen = rng.choice(list(FAULTS), rng.integers(1, 4), replace=False)
    for name in sorted(chosen, key=lambda fault: fault == "absent"):
        table.faults.append(str(name))
        FAULTS[name](table)
    return table


def _some(table: Made, share: float) -> np.ndarray:
    return table.rng.random(len(table.columns["t"])) < share


def _column(table: Made) -> str:
    return str(table.rng.choice(["lat", "lon", "v", "course", "wheel"]))


def _holes(table: Made) -> None:
    name = _column(table)
    table.columns[name] = np.where(
        _some(table, table.rng.uniform(0, 0.4)), np.nan, table.columns[name]
    )


def _codes(table: Made) -> None:
    name = str(table.rng.choice(["v", "wheel", "course"]))
    code = {"v": [65.535, -1.0, 9999.0], "wheel": [255.996, 999.9], "course": [360.0, 511.992]}
    value = table.rng.choice(code[name])
    table.columns[name] = np.where(_some(table, 0.1), value, table.columns[name])


def _spikes(table: Made) -> None:
    name = _column(table)
    rows = table.rng.integers(0, len(table.columns["t"]), table.rng.integers(1, 4))
    table.columns[name] = table.columns[name].copy()
    if name in ("lat", "lon"):
        table.columns[name][rows] += table.rng.choice([-1, 1]) * 10 ** table.rng.uniform(-3, 1)
    else:
        table.columns[name][rows] *= 10 ** table.rng.uniform(0.7, 3)  # beyond a spinning wheel


def _swapped_rows(table: Made) -> None:
    at = int(table.rng.integers(0, len(table.columns["t"]) - 1))
    for name in table.columns:
        column = table.columns[name].copy()
        column[[at, at + 1]] = column[[at + 1, at]]
        table.columns[name] = column
    table.truth = table.truth.copy()
    table.truth[[at, at + 1]] = table.truth[[at + 1, at]]


def _swapped_columns(table: Made) -> None:
    a, b = table.rng.choice(["lat", "lon", "v", "course", "wheel"], 2, replace=False)
    table.columns[a], table.columns[b] = table.columns[b], table.columns[a]


def _wrong_unit(table: Made) -> None:
    choices = [
        ('"v", unit = "m/s"', '"v", unit = "km/h"'), ('"v", unit = "m/s"', '"v", unit = "kn"'),
        ('"v", unit = "m/s"', '"v", unit = "mph"'),
        ('"wheel", unit = "km/h"', '"wheel", unit = "m/s"'),
        ('"wheel", unit = "km/h"', '"wheel", unit = "mph"'),
        ('"wheel", unit = "km/h"', '"wheel", unit = "kn"'), ('"t", unit = "s"', '"t", unit = "ms"'),
        ('"t", unit = "s"', '"t", unit = "min"'),
        ('"course", unit = "deg"', '"course", unit = "rad"'),
        ('"lat", unit = "deg"', '"lat", unit = "rad"'),
    ]  # fmt: skip
    old, new = choices[table.rng.integers(len(choices))]
    table.map_text = table.map_text.replace(old, new)


def _decimal_comma(table: Made) -> None:
    table.decimal, table.delimiter = ",", str(table.rng.choice([";", "\t", "|"]))


def _encoding(table: Made) -> None:
    table.encoding = str(table.rng.choice(["utf-8-sig", "utf-16", "cp1252", "utf-16-le"]))


def _cut(table: Made) -> None:
    table.after = lambda content, rng: content[: len(content) - int(rng.integers(1, 60))]


def _nuls(table: Made) -> None:
    table.after = lambda content, rng: content + b"\0" * int(rng.integers(1, 3000))


def _noise(table: Made) -> None:
    def noisy(content: bytes, rng: np.random.Generator) -> bytes:
        at = int(rng.integers(60, len(content)))
        return content[:at] + rng.bytes(int(rng.integers(1, 12))) + content[at:]

    table.after = noisy


def _repeated(table: Made) -> None:
    at = int(table.rng.integers(0, len(table.columns["t"])))
    for name, column in table.columns.items():
        table.columns[name] = np.insert(column, at, column[at])
    table.truth = np.insert(table.truth, at, table.truth[at])


def _gap(table: Made) -> None:
    start = int(table.rng.integers(0, len(table.columns["t"]) // 2))
    stop = start + int(table.rng.integers(1, len(table.columns["t"]) // 3))
    for name, column in table.columns.items():
        table.columns[name] = np.delete(column, slice(start, stop))
    table.truth = np.delete(table.truth, slice(start, stop))


def _carried(table: Made) -> None:
    if table.columns["t"][1] > 0.5:
        return  # the ratio of the newest speeds is as old as they are
    held = np.arange(len(table.columns["t"])) // 5 * 5
    for name in ("lat", "lon", "v", "course"):
        table.columns[name] = table.columns[name][held]


def _cut_off(table: Made) -> None:
    wheel = table.columns["wheel"]
    table.columns["wheel"] = np.where(wheel < 5.0, 0.0, wheel)


def _absent(table: Made) -> None:
    del table.columns[_column(table)]


FAULTS: dict[str, Callable[[Made], None]] = {
    "holes": _holes, "codes": _codes, "spikes": _spikes, "swapped rows": _swapped_rows,
    "swapped columns": _swapped_columns, "wrong unit": _wrong_unit, "decimal comma": _decimal_comma,
    "encoding": _encoding, "cut": _cut, "nuls": _nuls, "noise": _noise, "repeated": _repeated,
    "gap": _gap, "carried": _carried, "cut off": _cut_off, "absent": _absent,
}  # fmt: skip


def _fresh(log: Log, epoch_ns: np.ndarray) -> np.ndarray:
    """Where the newest ground speed is no older than 1.5 s: the ratio's sd knows no age."""
    gnss = log.streams["gnss"]
    times = gnss["epoch_ns"][np.isfinite(gnss["v_east_mps"])]
    last = np.searchsorted(times, epoch_ns, side="right") - 1
    return (last >= 0) & (epoch_ns - times[np.maximum(last, 0)] <= 1.5e9)


def outcome(seed: int, folder: Path) -> str:
    """`refused`, `right`, `noted`, or what is wrong with the reading of a random table."""
    table = made(seed)
    content = as_text(table.columns, table.delimiter, table.decimal).encode(table.encoding)
    path, map_path = folder / "log.csv", folder / "map.toml"
    path.write_bytes(table.after(content, table.rng))
    map_path.write_text(table.map_text)
    try:
        log = read(path, map_path)
    except BadInput as error:
        sound = str(error).isprintable() and len(str(error)) <= 400
        return "refused" if sound else f"{table.faults}: a message that is no line: {error}"
    done = all_estimates(by_name(["ratio"]), log.setup, log.streams).tables
    notes = [*log.notes, *slip_warnings(log, done)]
    if any(part in note for note in notes for part in LOUD):
        return "noted"
    found = done["ratio"]
    truth = dict(zip(np.round(table.columns["t"] * 1e9).astype(int).tolist(), table.truth,
                     strict=True))  # fmt: skip
    true = np.array([truth.get(t, np.nan) for t in found["epoch_ns"].tolist()])
    error = np.abs(found["slip"] - true) - 3.0 * found["slip_sd"]
    known = error[np.isfinite(error) & _fresh(log, found["epoch_ns"])]
    if not len(known):
        return f"{table.faults}: nothing is said, and not why: {notes}"
    wrong = float(np.mean(known > TOLERANCE))
    if wrong > 0.1 or (known > 0.3).any():
        return f"{table.faults}: {wrong:.0%} wrong slip, up to {known.max():.2f}, {notes}"
    return "right"
