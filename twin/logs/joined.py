"""Files of one drive on one clock: that of the first that holds a speed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from twin.errors import BadInput
from twin.logs.clocks import AGREE_SD, Speed, offset
from twin.logs.column_map import ColumnMap
from twin.logs.quantity_columns import Remarks, si_values
from twin.logs.sections import Columns, holder

_SPEEDS = (
    ("wheels", "driven_speed"), ("gnss", "speed"), ("wheels", "speed_rl"), ("wheels", "speed_rr"),
    ("gnss", "v_forward"), ("gnss", "v_east"),
)  # fmt: skip


def shift(files: list[Columns], columns_of: ColumnMap, remarks: Remarks) -> None:
    """Set what each file's clock is ahead of the first's, as the map says or the speeds show."""
    given = columns_of.reading.offset_s
    _check(given, files)
    reference = next((f for f in files if _speed(f, files, columns_of) is not None), files[0])
    for file in files:
        stated = given.get(file.file, given.get(file.file.rpartition(".")[0]))
        if stated is not None:
            file.shift_ns = round(stated * 1e9)
            remarks.notes.append(f"{file.file}: its clock is {stated:+.3f} s ahead, as given")
        elif file is not reference:
            _find(file, reference, files, columns_of, remarks)


def _check(given: Mapping[str, float], files: list[Columns]) -> None:
    names = [f.file for f in files]
    for name in given:
        if name not in names and name not in [n.rpartition(".")[0] for n in names]:
            raise BadInput(f"offset_s names {name!r}; the files are {', '.join(names)}")


def _find(
    file: Columns, reference: Columns, files: list[Columns], columns_of: ColumnMap, remarks: Remarks
) -> None:
    ours, theirs = (_speed(f, files, columns_of) for f in (file, reference))
    if ours is None or theirs is None:
        remarks.notes.append(
            f"{file.file}: without a speed its clock is taken to be that of {reference.file};"
            " offset_s in [log] says otherwise"
        )
        return
    try:
        found = offset(theirs, ours)
    except BadInput as error:
        if not _overlap(theirs, ours):
            raise
        remarks.notes.append(f"{file.file}: clock taken as it is: {error}")
        return
    said = f"{found.offset_s:+.3f} s (sd {found.sd_s:.3f} s) ahead of that of {reference.file}"
    if abs(found.offset_s) > AGREE_SD * found.sd_s:
        file.shift_ns = round(found.offset_s * 1e9)
        remarks.notes.append(f"{file.file}: its clock is {said}, found from the speeds; taken off")
    else:
        remarks.notes.append(f"{file.file}: its clock is {said}: none is taken off")


def _overlap(a: Speed, b: Speed) -> bool:
    """Whether two files share time as their clocks stand."""
    start, stop = max(a.epoch_ns[0], b.epoch_ns[0]), min(a.epoch_ns[-1], b.epoch_ns[-1])
    shorter = min(np.ptp(a.epoch_ns), np.ptp(b.epoch_ns))
    return bool(stop - start > 0.5 * shorter)


def _speed(file: Columns, files: list[Columns], columns_of: ColumnMap) -> Speed | None:
    """A speed that a file holds, if the map names one of it."""
    for section, key in _SPEEDS:
        source = columns_of.columns.get(section, {}).get(key)
        if source is None:
            continue
        where, name = holder(source.column, files, f"{section}.{key}")
        if where is not file:
            continue
        timed = file.timed(name, section)
        mps = si_values(section, key, source, timed.signal, timed.at, columns_of, Remarks())
        if key == "v_east" and "v_north" in columns_of.columns[section]:
            north = columns_of.columns[section]["v_north"]
            other = file.timed(holder(north.column, files, "gnss.v_north")[1], section)
            if len(other.epoch_ns) == len(mps):
                more = other.signal, other.at, columns_of, Remarks()
                mps = np.hypot(mps, si_values(section, "v_north", north, *more))
        return Speed(epoch_ns=timed.epoch_ns, mps=mps)
    return None
