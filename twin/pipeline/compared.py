"""Comparison of two drives: two runs, or a log and a simulation of the same job."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from twin.errors import BadInput
from twin.io.plain import Plain
from twin.logs.summary import RPM
from twin.logs.timeline import SECOND_NS
from twin.pipeline.compared_drives import Drive, drive_of, of_the_same, read, slips
from twin.streams import Array

Quantity = tuple[str, str, Callable[[Drive], float | None]]


@dataclass(frozen=True)
class Row:
    """One quantity of drives A and B; the value of a drive is None if unknown."""

    quantity: str
    unit: str
    a: float | None
    b: float | None

    @property
    def difference(self) -> float | None:
        """Value of drive B minus value of drive A, in the unit of the row."""
        return None if self.a is None or self.b is None else self.b - self.a


@dataclass(frozen=True, kw_only=True)
class Compared:
    """Both drives, what of them is compared, and the rows of the table."""

    a: Drive
    b: Drive
    slip_of: tuple[str, str]
    """Whose slip the figures show: an estimator's, or `truth`."""
    where: str
    """Which rows are compared, in words."""
    rows: tuple[Row, ...]
    notes: tuple[str, ...]

    def plain(self) -> dict[str, Plain]:
        """Comparison as plain JSON values, for the option --json."""
        return {
            "schema": 1,
            **{key: _about(drive) for key, drive in (("a", self.a), ("b", self.b))},
            "where": self.where,
            "slip_of": list(self.slip_of),
            "rows": [
                {"quantity": r.quantity, "unit": r.unit, "a": r.a, "b": r.b,
                 "difference": r.difference}
                for r in self.rows
            ],
            "notes": list(self.notes),
        }  # fmt: skip


def compared(first: Path, second: Path) -> Compared:
    """Comparison of the drives in two run folders.

    Raises:
        BadInput: a folder is not the folder of a run or a log, both folders are the same, or the
            drives have no quantity in common.
    """
    if first.resolve() == second.resolve():
        raise BadInput(f"{first} and {second} are the same folder; name two")
    records = [read(folder) for folder in (first, second)]
    slip_of = slips(*records)
    drives = [
        drive_of(folder, record, name)
        for folder, record, name in zip((first, second), records, slip_of, strict=True)
    ]
    a, b, where = of_the_same(*drives)
    rows = tuple(row for row in _rows(a, b) if row.a is not None or row.b is not None)
    shared = [row for row in rows if row.difference is not None and row.quantity not in ALWAYS]
    if not shared:
        raise BadInput(
            f"{first} and {second} have nothing in common to compare: no speed, slip, force or "
            "engine is known in both"
        )
    return Compared(
        a=a, b=b, slip_of=slip_of, where=where, rows=rows, notes=tuple(_notes(a, b, slip_of))
    )


ALWAYS = ("time", "time compared")
"""Quantities that any two folders share."""


def _rows(a: Drive, b: Drive) -> Iterable[Row]:
    """Every quantity of the table, in its order."""
    common = [name for name in a.record.estimates if name in b.record.estimates]
    for quantity, unit, of in (
        *QUANTITIES,
        *(q for name in common for q in _slip_quantities(name)),
    ):
        yield Row(quantity, unit, of(a), of(b))


def _column(
    column: str, scale: float, of: Callable[[Array], np.floating] = np.mean
) -> Callable[[Drive], float | None]:
    """Mean, or another statistic, of a column over the rows that are compared."""

    def value(drive: Drive) -> float | None:
        values = drive.values(column)
        return scale * float(of(values)) if len(values) else None

    return value


def _slip_quantities(name: str) -> Iterable[Quantity]:
    """Spread of an estimator's slip, and its error where it was scored."""
    for share, said in ((0.5, "median"), (0.05, "5 %"), (0.95, "95 %")):
        yield f"slip, {name}, {said}", "%", partial(_slip, estimator=name, share=share)
    yield f"slip error, {name}, RMS", "%", partial(_rmse, estimator=name)


def _distance_m(drive: Drive) -> float | None:
    values = drive.values("speed_mps")
    if not len(values):
        return None
    return float(np.mean(np.abs(values)) * drive.rows["duration_s"][drive.chosen].sum())


def _slip(drive: Drive, estimator: str, share: float) -> float | None:
    """A quantile of an estimator's slip in the seconds that are compared [%]."""
    table = drive.record.estimates[estimator]
    if "slip" not in table:
        return None
    seconds = drive.rows["epoch_ns"][drive.chosen] // SECOND_NS
    slip = table["slip"][np.isin(table["epoch_ns"] // SECOND_NS, seconds)]
    known = slip[np.isfinite(slip)]
    return 100.0 * float(np.quantile(known, share)) if len(known) else None


def _rmse(drive: Drive, estimator: str) -> float | None:
    """Of the scores, inside their own window [%]."""
    scored = ((drive.record.scores or {}).get("estimators") or {}).get(estimator) or {}
    rmse = (scored.get("slip") or {}).get("rmse")
    return None if rmse is None else 100.0 * float(rmse)


def _fuel_per_ha(drive: Drive) -> float | None:
    took = ((drive.record.scores or {}).get("drive") or {}).get("area") or {}
    per_ha = took.get("fuel_at_work_l_per_ha")
    return None if per_ha is None else float(per_ha)


QUANTITIES: tuple[Quantity, ...] = (
    ("time", "s", lambda d: float(d.rows["duration_s"].sum())),
    ("time compared", "s", lambda d: float(d.rows["duration_s"][d.chosen].sum())),
    ("distance", "m", _distance_m),
    ("ground speed", "km/h", _column("speed_mps", 3.6)),
    ("ground speed, sd", "km/h", _column("speed_mps", 3.6, np.std)),
    ("wheel speed", "km/h", _column("wheel_speed_mps", 3.6)),
    ("slip, truth, mean", "%", _column("true_slip", 100.0)),
    ("draft", "kN", _column("draft_pin_n", 1e-3)),
    ("draft, sd", "kN", _column("draft_pin_n", 1e-3, np.std)),
    ("depth", "cm", _column("depth_m", 100.0)),
    ("axle torque", "kNm", _column("axle_torque_nm", 1e-3)),
    ("engine speed", "1/min", _column("engine_radps", RPM)),
    ("engine load", "%", _column("engine_load", 100.0)),
    ("fuel rate", "L/h", _column("fuel_lph", 1.0)),
    ("fuel per hectare", "L/ha", _fuel_per_ha),
)
"""Name, unit and value of each quantity, in the order of the table; then slip by estimator."""


def _notes(a: Drive, b: Drive, slip_of: Sequence[str]) -> Iterable[str]:
    if a.record.setup.machine != b.record.setup.machine:
        yield f"the machines differ: {a.record.setup.machine} and {b.record.setup.machine}"
    if slip_of[0] != slip_of[1]:
        said = [name or "unknown" for name in slip_of]
        yield f"no estimator gives slip in both: A's slip is {said[0]}, B's is {said[1]}"
    for name, drive in (("A", a), ("B", b)):
        end = (drive.record.scores or {}).get("end") or {"as_planned": True}
        if not end["as_planned"]:
            yield f"{name} {(drive.record.scores or {}).get('ended')}"
        if drive.from_truth:
            told = ", ".join(drive.from_truth)
            yield f"{name}: {told} from the truth, as no sensor measured them"
    yield f"A: {a.done.rule}"
    if b.done.rule != a.done.rule:
        yield f"B: {b.done.rule}"


def _about(drive: Drive) -> dict[str, Plain]:
    scores = drive.record.scores or {}
    return {
        "folder": str(drive.folder),
        "name": scores.get("scenario"),
        "seed": scores.get("seed"),
        "machine": drive.record.setup.machine,
        "kind": drive.kind,
    }
