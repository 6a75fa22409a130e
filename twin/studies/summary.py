"""Means over the seeds, with their 95 % intervals.

The lower end of the interval is at least 0 for what cannot be negative, as an RMSE.

Runs that failed are left out and counted. Runs that were not driven as planned are counted, and
are in the means with the part that was scored.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from twin.compute.mean import Mean, mean
from twin.io.plain import Plain
from twin.io.result_rows import row

Row = Mapping[str, Plain]

UNITS = {"m": "m", "rad": "rad", "mps": "m/s", "kmh": "km/h", "kn": "kN"}
"""Last part of a quantity's name -> its unit."""
NEVER_NEGATIVE = {
    "rmse", "mae", "max", "p999", "rel_err", "coverage_2sd", "nees_mean", "slip_sd", "draft_cv",
    "depth_sd_m", "slip_causal", "slip_offline", "speed_causal_mps", "sideslip_causal_rad",
    "sideslip_offline_rad",
}  # fmt: skip
"""Last part of the name of quantities that are never below 0."""
NOT_MEASURED = {"scenario", "seed", "estimator", "error", "ended", "as_planned"}


@dataclass(frozen=True, kw_only=True)
class Group:
    """The runs that differ in nothing but the seed."""

    scenario: str
    swept: tuple[tuple[str, Plain], ...]
    estimator: str
    rows: tuple[Row, ...]

    @property
    def setting(self) -> str:
        """`plough-25cm, soil.friction = 0.6`."""
        return ", ".join([self.scenario, *(f"{path} = {value}" for path, value in self.swept)])

    @property
    def case(self) -> str:
        """What the rows of results call it: setting and estimator."""
        return f"{self.setting}, {self.estimator}"

    @property
    def failed(self) -> int:
        """How many ended in an error."""
        return sum(each["error"] is not None for each in self.rows)

    @property
    def not_driven(self) -> int:
        """How many did not drive their course as planned."""
        return sum(each.get("as_planned") is False for each in self.rows)

    def values(self, quantity: str) -> dict[int, float]:
        """Seed -> value, where there is one."""
        found = {each["seed"]: each.get(quantity) for each in self.rows}
        return {s: v for s, v in found.items() if v is not None and math.isfinite(v)}


def groups(rows: Iterable[Row], swept: Sequence[str]) -> list[Group]:
    """The rows of a study by scenario, swept values and estimator, in order of appearance."""
    found: dict[tuple[Any, ...], list[Row]] = {}
    for each in rows:
        values = tuple((path, each[path]) for path in swept)
        found.setdefault((each["scenario"], values, each["estimator"]), []).append(each)
    return [
        Group(scenario=scenario, swept=values, estimator=estimator, rows=tuple(held))
        for (scenario, values, estimator), held in found.items()
    ]


def early_ends(rows: Iterable[Row], swept: Sequence[str]) -> list[str]:
    """How each run ended that was not driven as planned, a line for each run."""
    lines = (
        ", ".join(
            [
                each["scenario"],
                *(f"{path} = {each[path]}" for path in swept),
                f"seed {each['seed']}",
            ]
        )
        + f": {each['ended']}"
        for each in rows
        if each.get("as_planned") is False
    )
    return list(dict.fromkeys(lines))  # each estimator has a row of the run


def quantities(rows: Iterable[Row], swept: Sequence[str]) -> list[str]:
    """What was measured: the columns that hold a number somewhere, in order of appearance."""
    known = NOT_MEASURED | set(swept)
    found = (name for each in rows for name, v in each.items() if isinstance(v, float))
    return [name for name in dict.fromkeys(found) if name not in known]


def mean_of(group: Group, quantity: str) -> Mean:
    """Mean and interval of a quantity over the seeds."""
    found = mean(group.values(quantity).values())
    if quantity.rpartition(".")[2] in NEVER_NEGATIVE and found.low < 0.0:
        return replace(found, low=0.0)
    return found


def paired(group: Group, other: Group, quantity: str) -> Mean:
    """Mean difference to another estimator on the seeds that both have."""
    ours, theirs = group.values(quantity), other.values(quantity)
    return mean(ours[seed] - theirs[seed] for seed in ours if seed in theirs)


def differences_to(found: Sequence[Group], quantity: str, against: str) -> list[Mean | None]:
    """Mean difference of each group to an estimator on its setting; None for that one itself."""
    references = {group.setting: group for group in found if group.estimator == against}
    return [
        None if (other := references.get(group.setting)) in (None, group)
        else paired(group, other, quantity)
        for group in found
    ]  # fmt: skip


def rows(
    found: Sequence[Group], measured: Sequence[str], against: str | None = None
) -> list[dict[str, Plain]]:
    """Rows as `twin.io.result_rows` writes them, the interval in low and high.

    Args:
        found: the groups.
        measured: quantities.
        against: an estimator that every other is compared with, seed by seed.
    """
    out = []
    references = {g.setting: g for g in found if g.estimator == against}
    for group in found:
        case = group.case
        out.append(row(case, "runs", len(group.rows), "1"))
        out.append(row(case, "failed", group.failed, "1"))
        out.append(row(case, "not driven as planned", group.not_driven, "1"))
        reference = references.get(group.setting)
        for quantity in measured:
            out += _row(case, quantity, mean_of(group, quantity), quantity)
            if reference is not None and reference is not group:
                difference = paired(group, reference, quantity)
                out += _row(case, f"{quantity} less that of {against}", difference, quantity)
    return out


def _row(case: str, name: str, found: Mean, quantity: str) -> list[dict[str, Plain]]:
    if found.n == 0:
        return []
    return [row(case, name, found.mean, _unit(quantity)) | found.bounds]


def _unit(quantity: str) -> str:
    """From the name: `sideslip_m.true_m` in m, `speed_mps.rmse` in m/s, `slip.rmse` in 1."""
    group, _, last = quantity.rpartition(".")
    if last in ("coverage_2sd", "nees_mean", "n", "n_nan", "rel_err"):
        return "1"
    ends = [part.rsplit("_", 1)[-1] for part in (last, group) if "_" in part]
    return next((UNITS[end] for end in ends if end in UNITS), "1")
