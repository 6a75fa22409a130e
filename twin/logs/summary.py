"""A drive in numbers: time, distance, slip and fuel by activity, and where slip was highest."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.logs.activity import (
    ACTIVITIES,
    PULLS,
    TURNING,
    WORKING,
    Activity,
    Pull,
    stretches,
)
from twin.streams import Array, Table

STRETCH_S = 60.0
"""Work is looked at in stretches of at most so long [s]."""
LEAST_SLIP_S = 5.0
"""A stretch with less known slip is not ranked [s]."""
MOST_STRETCHES = 5
RPM = 30.0 / np.pi
_M2_PER_HA = 1e4
_SHARE_KNOWN = 0.5
"""A total is given where at least this share of its time is known."""

Number = float | None
Rows = NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True)
class Share:
    """What was driven in one activity; None is unknown."""

    activity: str
    time_s: float
    distance_m: Number
    speed_kmh: Number
    """Mean over the time, standing too."""
    slip_median: Number
    slip_p05: Number
    slip_p95: Number
    slip_n: int
    """Rows with a slip, about one a second."""
    engine_rpm: Number
    """Mean while the engine runs, as is the load."""
    engine_load: Number
    fuel_lph: Number
    fuel_l: Number


@dataclass(frozen=True, kw_only=True)
class Area:
    """What an area took; it needs the implement's width."""

    width_m: float
    area_ha: float
    """Distance at work times width: no overlap."""
    ha_per_h: float
    """At work, without turns."""
    fuel_at_work_l_per_ha: Number
    fuel_with_turns_l_per_ha: Number


@dataclass(frozen=True, kw_only=True)
class Stretch:
    """A part of the work, of at most STRETCH_S."""

    start_s: float
    """Since the start of the log."""
    duration_s: float
    slip_median: float
    slip_p95: float
    speed_kmh: Number
    pull: dict[str, Number]
    """Mean of each column of PULLS that there is [SI]."""
    east_m: Number
    north_m: Number


def shares(rows: Table, done: Activity) -> list[Share]:
    """One of each activity that occurs, and one of all together.

    Args:
        rows: of `twin.logs.timeline.timeline`.
        done: what the machine does in them.
    """
    parts = [(name, done[code]) for code, name in enumerate(ACTIVITIES)]
    parts.append(("all", np.ones(len(done.code), np.bool_)))
    return [_share(name, rows, chosen) for name, chosen in parts if chosen.any()]


def area(rows: Table, done: Activity, width_m: float) -> Area | None:
    """What the worked area took; None where no distance at work is known."""
    work = done[WORKING]
    distance_m = _total(rows, "speed_mps", work)
    if not distance_m:
        return None
    area_ha = distance_m * width_m / _M2_PER_HA
    at_work_l, turning_l = (_total(rows, "fuel_lph", done[a], 1 / 3600) for a in (WORKING, TURNING))
    with_turns_l = None if at_work_l is None else at_work_l + (turning_l or 0.0)
    return Area(
        width_m=width_m,
        area_ha=area_ha,
        ha_per_h=area_ha / (float(rows["duration_s"][work].sum()) / 3600.0),
        fuel_at_work_l_per_ha=None if at_work_l is None else at_work_l / area_ha,
        fuel_with_turns_l_per_ha=None if with_turns_l is None else with_turns_l / area_ha,
    )


def highest_slip(rows: Table, done: Activity, most: int = MOST_STRETCHES) -> list[Stretch]:
    """The stretches of work with the highest median slip, the highest first."""
    if "slip" not in rows:
        return []
    found = [
        _stretch(rows, part)
        for first, after in stretches(done[WORKING])
        for part in _parts(rows, first, after)
        if rows["duration_s"][part][np.isfinite(rows["slip"][part])].sum() >= LEAST_SLIP_S
    ]
    return sorted(found, key=lambda stretch: -stretch.slip_median)[:most]


def pulls(rows: Table) -> list[Pull]:
    """The measured quantities that slip may be drawn against, a force or load, where they vary."""
    known = [pull for pull in PULLS if not pull.lowered and pull.column in rows]
    return [pull for pull in known if np.nanmax(rows[pull.column]) > np.nanmin(rows[pull.column])]


def _share(name: str, rows: Table, chosen: Rows) -> Share:
    running = chosen & (rows["engine_radps"] > 0.0) if "engine_radps" in rows else chosen
    rpm = _mean(rows, "engine_radps", running)
    return Share(
        activity=name,
        time_s=float(rows["duration_s"][chosen].sum()),
        distance_m=_total(rows, "speed_mps", chosen),
        speed_kmh=_scaled(_mean(rows, "speed_mps", chosen), 3.6),
        **slip_spread(rows, chosen),
        engine_rpm=_scaled(rpm, RPM),
        engine_load=_mean(rows, "engine_load", running),
        fuel_lph=_mean(rows, "fuel_lph", chosen),
        fuel_l=_total(rows, "fuel_lph", chosen, 1.0 / 3600.0),
    )


def slip_spread(rows: Table, chosen: Rows) -> dict[str, Any]:
    """Median, 5 % and 95 % of slip in the chosen rows, and how many rows have one."""
    slip = rows.get("slip", np.empty(0))[chosen] if "slip" in rows else np.empty(0)
    known = slip[np.isfinite(slip)]
    names = ("slip_p05", "slip_median", "slip_p95")
    if not len(known):
        return dict.fromkeys(names) | {"slip_n": 0}
    values = (float(q) for q in np.quantile(known, (0.05, 0.5, 0.95)))
    return dict(zip(names, values, strict=True)) | {"slip_n": len(known)}


def _parts(rows: Table, first: int, after: int) -> list[slice]:
    """Equal parts of a run of rows, none longer than STRETCH_S."""
    count = max(1, int(np.ceil(rows["duration_s"][first:after].sum() / STRETCH_S)))
    edges = np.linspace(first, after, count + 1).round().astype(int)
    return [slice(a, b) for a, b in pairwise(edges) if b > a]


def _stretch(rows: Table, part: slice) -> Stretch:
    chosen = np.zeros(len(rows["epoch_ns"]), np.bool_)
    chosen[part] = True
    slip = rows["slip"][part]
    slip = slip[np.isfinite(slip)]
    return Stretch(
        start_s=float(rows["epoch_ns"][part][0] - rows["epoch_ns"][0]) * 1e-9,
        duration_s=float(rows["duration_s"][part].sum()),
        slip_median=float(np.median(slip)),
        slip_p95=float(np.quantile(slip, 0.95)),
        speed_kmh=_scaled(_mean(rows, "speed_mps", chosen), 3.6),
        pull={p.column: _mean(rows, p.column, chosen) for p in PULLS if p.column in rows},
        east_m=_mean(rows, "east_m", chosen),
        north_m=_mean(rows, "north_m", chosen),
    )


def _mean(rows: Table, column: str, chosen: Rows) -> Number:
    """Mean over time; None where nothing is known."""
    if column not in rows:
        return None
    values: Array = rows[column]
    known = chosen & np.isfinite(values)
    time_s = rows["duration_s"][known]
    return float(np.sum(values[known] * time_s) / np.sum(time_s)) if known.any() else None


def _total(rows: Table, column: str, chosen: Rows, scale: float = 1.0) -> Number:
    """Mean times time; None where less than half of the time is known."""
    mean = _mean(rows, column, chosen)
    if mean is None:
        return None
    time_s = float(rows["duration_s"][chosen].sum())
    known_s = float(rows["duration_s"][chosen & np.isfinite(rows[column])].sum())
    return scale * abs(mean) * time_s if known_s >= _SHARE_KNOWN * time_s else None


def _scaled(value: Number, scale: float) -> Number:
    return None if value is None else scale * value
