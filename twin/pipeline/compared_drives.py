"""Two folders read as drives that can be compared: what of them, and whose slip."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.io import run_folder
from twin.io.run_folder import Record
from twin.logs.activity import STANDING_MPS, WORKING, Activity, activity
from twin.logs.timeline import timeline
from twin.pipeline.drive import shown_estimator
from twin.scores.log_table import protocol_spans_ns
from twin.scores.scores import at
from twin.streams import Array, Table

TRUTH = "truth"
"""What the slip of a simulation is called that is no estimate."""
FROM_TRUTH = {
    "draft_pin_n": "draft_n", "axle_torque_nm": "axle_torque_nm", "engine_radps": "engine_radps",
    "fuel_lph": "fuel_lph", "speed_mps": "speed_mps", "depth_m": "depth_m", "true_slip": "slip",
}  # fmt: skip
"""Column of a timeline -> column of the truth that replaces it where no sensor measured it."""


@dataclass(frozen=True, kw_only=True)
class Drive:
    """One of the two drives, as a table with one row for each second."""

    folder: Path
    record: Record
    rows: Table
    """Of `twin.logs.timeline.timeline`; what no sensor measured is the truth's."""
    done: Activity
    from_truth: tuple[str, ...] = ()
    """Columns of `rows` that are the truth's."""
    chosen: NDArray[np.bool_]
    """The rows that are compared. Shape (n,)."""

    @property
    def kind(self) -> str:
        """Recorded or simulated."""
        return "recorded" if self.record.scenario is None else "simulated"

    def values(self, column: str) -> Array:
        """Finite values of a column in the rows that are compared."""
        if column not in self.rows:
            return np.empty(0)
        values = self.rows[column][self.chosen]
        return np.asarray(values[np.isfinite(values)], np.float64)


def read(folder: Path) -> Record:
    """Record of a run or of a log, read from its folder.

    Raises:
        BadInput: the folder is missing, is no folder of a run or a log, or has no measurements.
    """
    if not folder.exists():
        raise BadInput(f"{folder} does not exist; name the folder of a run or of a log")
    if not (folder / run_folder.SCORES).is_file():
        raise BadInput(
            f"{folder} is not the folder of a run or of a log: it has no {run_folder.SCORES}; "
            "twin run or twin estimate writes one"
        )
    record = run_folder.read(folder)
    if not record.streams.tables and not record.truth:
        raise BadInput(f"{folder} holds no measurements")
    return record


def slips(a: Record, b: Record) -> tuple[str, str]:
    """Source of the slip of each drive: the name of an estimator, or TRUTH.

    Both drives use the first estimator that gives a slip in both. Without such an estimator, each
    drive uses its true slip if known, else its own first estimator with a slip, else "".
    """
    own = [_giving(record) for record in (a, b)]
    common = [name for name in own[0] if name in own[1]]
    if common:
        return common[0], common[0]
    first, second = (
        TRUTH if _has_truth(record) else (names or [""])[0]
        for record, names in zip((a, b), own, strict=True)
    )
    return first, second


def _giving(record: Record) -> list[str]:
    return [n for n, t in record.estimates.items() if shown_estimator({n: t}) is not None]


def _has_truth(record: Record) -> bool:
    return bool(record.truth) and "slip" in (record.truth or {})


def drive_of(folder: Path, record: Record, slip_of: str) -> Drive:
    """Drive of a folder, as a table with one row for each second.

    Args:
        folder: run folder, for the message of an error.
        record: content of the folder.
        slip_of: name of the estimator that gives the slip, or TRUTH for the true slip.

    Raises:
        BadInput: the folder has no measurements.
    """
    truth = record.truth or {}
    estimate = truth if slip_of == TRUTH else record.estimates.get(slip_of)
    rows = timeline(record.streams, estimate)
    if not len(rows["epoch_ns"]):
        raise BadInput(f"{folder} holds no measurements")
    known = (
        {} if not truth else {c: n for c, n in FROM_TRUTH.items() if c not in rows and n in truth}
    )
    rows |= {column: at(truth, name, rows["epoch_ns"]) for column, name in known.items()}
    done = activity(rows, protocol_spans_ns(record.scores or {}))
    return Drive(
        folder=folder, record=record, rows=rows, done=done, from_truth=tuple(known),
        chosen=np.ones(len(rows["epoch_ns"]), np.bool_),
    )  # fmt: skip


def of_the_same(a: Drive, b: Drive) -> tuple[Drive, Drive, str]:
    """Both drives with the rows to compare, and a description of these rows.

    The rows are those at work. If one drive has no work, the rows are those with motion.
    """
    if all(drive.done[WORKING].any() for drive in (a, b)):
        first, second = (replace(drive, chosen=drive.done[WORKING]) for drive in (a, b))
        return first, second, "at work"
    first, second = (replace(drive, chosen=_driving(drive)) for drive in (a, b))
    return first, second, "while driving, as one of them does not work"


def _driving(drive: Drive) -> NDArray[np.bool_]:
    speed = drive.rows.get("speed_mps", drive.rows.get("wheel_speed_mps"))
    if speed is None:
        return drive.chosen
    return np.asarray(np.abs(speed) > STANDING_MPS)
