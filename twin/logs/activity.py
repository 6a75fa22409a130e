"""What a machine does when: working, turning, on the road or empty, standing; by a stated rule."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.streams import Array, Table

ACTIVITIES = ("working", "turning", "road, empty", "standing")
"""Numbered in this order; UNKNOWN has no measurement of speed."""
WORKING, TURNING, EMPTY, STANDING = range(4)
UNKNOWN = -1

STANDING_MPS = 0.2
"""Slower than this stands [m/s]: a GNSS speed at rest reaches 0.1 m/s."""
WORK_KMH = 15.0
"""Faster than this is road [km/h]; tillage ends at about 12 km/h (ASAE D497.7, table 2)."""
TURN_RADIUS_M = 25.0
"""A narrower curve is a turn [m]."""
SHORTEST_WORK_S = 10.0
"""Work shorter than this is none [s]."""
LONGEST_BREAK_S = 5.0
"""A break in work up to this long belongs to it [s]."""
LONGEST_TURN_S = 120.0
"""What lies between two stretches of work, no longer than this, is a turn [s]."""
SMOOTHING_S = 5.0
"""Pull is taken as the median over so long [s]."""


@dataclass(frozen=True)
class Pull:
    """A measured quantity that separates work from driving empty."""

    column: str
    name: str
    unit: str
    scale: float
    """Unit of the text in SI."""
    least: float
    """Least difference of the means of work and of the rest [SI]."""
    lowered: bool = False
    """Whether work is where it is small."""


PULLS = (
    Pull("draft_pin_n", "draft", "kN", 1e-3, 2000.0),
    Pull("hitch_m", "hitch height", "m", 1.0, 0.1, lowered=True),
    Pull("axle_torque_nm", "axle torque", "kNm", 1e-3, 3000.0),
    Pull("engine_load", "engine load", "%", 100.0, 0.25),
)
"""In the order in which they are asked; the first that falls into two groups decides."""


@dataclass(frozen=True)
class Activity:
    """Activity of the machine in each row of a timeline."""

    code: NDArray[np.int64]
    """Index into ACTIVITIES, or UNKNOWN. Shape (n,)."""
    rule: str
    """The rule that found the activities, in words."""

    def __getitem__(self, activity: int) -> NDArray[np.bool_]:
        return np.asarray(self.code == activity)


def activity(rows: Table, no_work_ns: Sequence[tuple[int, int]] = ()) -> Activity:
    """Working, turning, road and standing, row by row.

    Standing: below 0.2 m/s. Working: at most 15 km/h, in no curve narrower than 25 m, and loaded,
    where draft, hitch, torque or engine load fall into loaded and empty (two groups by Otsu's
    threshold); at least 10 s. Turning: a narrower curve, or at most 120 s between two stretches of
    work. What else moves is road, or driving empty.

    Args:
        rows: of `twin.logs.timeline.timeline`.
        no_work_ns: first and last instants of what is known to be no work, as the parts of a
            recording protocol.
    """
    count = len(rows["epoch_ns"])
    speed = _speed_mps(rows)
    known, moving = np.isfinite(speed), speed > STANDING_MPS
    curved = _curved(rows, speed)
    loaded, pull = _loaded(rows, moving)
    slow = speed * 3.6 <= WORK_KMH
    for first, last in no_work_ns:
        loaded &= (rows["epoch_ns"] < first) | (rows["epoch_ns"] > last)
    time_s = (rows["epoch_ns"] - rows["epoch_ns"][0]) * 1e-9 if count else np.empty(0)
    work = _stretched(moving & slow & ~curved & loaded, time_s, rows["duration_s"])
    code = np.where(moving, EMPTY, np.where(known, STANDING, UNKNOWN))
    code[curved & moving] = TURNING
    code[work & known] = WORKING
    code[_between_work(work, time_s) & moving] = TURNING
    rule = (
        f"Standing is below {STANDING_MPS:g} m/s. Working is at most {WORK_KMH:g} km/h in no curve "
        f"narrower than {TURN_RADIUS_M:g} m{pull}, for at least {SHORTEST_WORK_S:g} s. Turning is "
        f"a narrower curve, or driving for at most {LONGEST_TURN_S:g} s between two stretches of "
        "work. All other driving is road or empty."
    )
    return Activity(code.astype(np.int64), rule)


def stretches(chosen: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First row, and the row after the last, of each unbroken sequence of chosen rows."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], chosen, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _speed_mps(rows: Table) -> Array:
    """Ground speed; where it is unknown, that of the wheels."""
    nothing = np.full(len(rows["epoch_ns"]), np.nan)
    ground, wheel = (rows.get(c, nothing) for c in ("speed_mps", "wheel_speed_mps"))
    return np.abs(np.where(np.isfinite(ground), ground, wheel))


def _curved(rows: Table, speed: Array) -> NDArray[np.bool_]:
    """Rows of a curve narrower than TURN_RADIUS_M."""
    yaw_rate = rows.get("yaw_rate_radps", np.zeros(len(speed)))
    with np.errstate(invalid="ignore"):
        return np.asarray(np.abs(yaw_rate) * TURN_RADIUS_M > np.maximum(speed, STANDING_MPS))


def _loaded(rows: Table, moving: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], str]:
    """Rows under load, and the rule that found them; all rows where there is none."""
    for pull in PULLS:
        if pull.column not in rows:
            continue
        level = smoothed(rows[pull.column], rows)
        seen = level[moving & np.isfinite(level)]
        limit = two_groups(seen, pull.least)
        if limit is None:
            continue
        loaded = (level < limit) if pull.lowered else (level > limit)
        side = "below" if pull.lowered else "above"
        told = f", with the {pull.name} {side} {pull.scale * limit:.3g} {pull.unit}"
        return np.array(loaded), told
    return np.ones(len(moving), np.bool_), ""


def smoothed(values: Array, rows: Table) -> Array:
    """Running median over SMOOTHING_S; unknown values are left out."""
    step_s = float(np.median(rows["duration_s"])) if len(values) else 1.0
    half = int(0.5 * SMOOTHING_S / step_s)
    if half < 1 or len(values) < 2 * half + 1:
        return values
    padded: Any = np.pad(values, half, constant_values=np.nan)
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1)
    some = np.isfinite(windows).any(axis=1)
    found = np.full(len(values), np.nan)
    found[some] = np.nanmedian(windows[some], axis=1)
    return found


def two_groups(values: Array, least: float) -> float | None:
    """Threshold between two groups of values; None if their means differ by less than `least`.

    The threshold maximises w (1 - w) (m1 - m0)^2 (Otsu 1979, IEEE Trans. SMC 9, 62).

    w: share of the values in one group [-]. m0, m1: means of the groups, in the unit of the values.
    """
    if len(values) < 10:
        return None
    ordered = np.sort(values)
    below = np.arange(1, len(ordered))
    sums = np.cumsum(ordered)
    low, high = sums[:-1] / below, (sums[-1] - sums[:-1]) / (len(ordered) - below)
    share = below / len(ordered)
    cut = int(np.argmax(share * (1.0 - share) * (high - low) ** 2))
    if high[cut] - low[cut] < least:
        return None
    return float(0.5 * (low[cut] + high[cut]))


def _stretched(work: NDArray[np.bool_], time_s: Array, duration_s: Array) -> NDArray[np.bool_]:
    """Work without its short breaks, and without short work."""
    work = work.copy()
    for first, after in stretches(~work):
        inside = first > 0 and after < len(work)
        if inside and time_s[after] - time_s[first - 1] <= LONGEST_BREAK_S + duration_s[first]:
            work[first:after] = True
    for first, after in stretches(work):
        if duration_s[first:after].sum() < SHORTEST_WORK_S:
            work[first:after] = False
    return work


def _between_work(work: NDArray[np.bool_], time_s: Array) -> NDArray[np.bool_]:
    """Rows between two stretches of work that are no farther apart than a turn takes."""
    found = np.zeros(len(work), np.bool_)
    for first, after in stretches(~work):
        inside = first > 0 and after < len(work)
        if inside and time_s[after] - time_s[first] <= LONGEST_TURN_S:
            found[first:after] = True
    return found
