"""The parts of the recording protocol in a log: where they are.

The clock check, three starts and stops from standstill, marks the protocol: nothing else is looked
for in a log without it, unless the map's [protocol] says when the parts were driven.

One module, because every part is found beside the others on one table of motion.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from twin.logs.activity import STANDING, TURN_RADIUS_M, Activity, stretches, two_groups
from twin.logs.protocol_parts import Part, Times
from twin.streams import Array, Table

STOPS = 3
"""Starts and stops of the clock check."""
PULSE_MPS = 1.3
"""A start reaches at least this speed [m/s]."""
PULSE_S = 30.0
"""From start to stop it takes at most so long [s]."""
PULSE_TURN_RAD = math.radians(15.0)
"""It turns by no more than this on the way."""
STAND_S = (4.0, 60.0)
"""Between two it stands at least and at most so long [s]."""
WITHIN_S = 1800.0
"""Everything else lies within this of the clock check [s]."""
QUIET_S = 20.0
"""Shortest standing [s]."""
STEADY_MPS2 = 0.1
"""A pass changes its speed by less than this [m/s2]."""
PASS_S, PASS_M = 10.0, 40.0
"""Shortest pass."""
OPPOSITE_RAD = math.radians(20.0)
"""Passes both ways are opposite to within this."""
COAST_FROM_MPS, COAST_BY_MPS, COAST_S = 2.7, 1.5, 5.0
"""A coast-down begins at least this fast, loses at least so much speed, and takes so long."""
COAST_MPS2 = (0.05, 1.2)
"""Deceleration of a coast-down: less is a slope, more is a brake [m/s2]."""
BRAKED_SHARE = 1.4
"""A coast-down ends where it slows down by so much more than at its start: brakes."""
IDLE_SHARE = 0.1
"""Engine speed while rolling free is idle to within this."""
NO_PULL_N, NO_PULL_SHARE = 1000.0, 0.1
"""Without pull the mean draft is below this, or below this share of the log's 95 % [N, -]."""
HITCH_RAISED_M = 0.1
"""Heights of the raised and the lowered hitch differ by at least this [m]."""
PULLING_LOAD = 0.6
"""An engine that is loaded so far at a steady speed pulls something [-]."""
EDGE_S = 1.0
"""Left out at both ends of a part [s]."""

Span = tuple[int, int]
"""First and last instant [ns]."""


@dataclass(frozen=True)
class Protocol:
    """Times at which each part of the protocol was found."""

    spans: Mapping[Part, tuple[Span, ...]] = field(default_factory=dict)
    written: bool = False
    """Whether the map says where they are."""
    pull_known: bool = False
    """Whether the log shows that the passes were without pull."""

    def __bool__(self) -> bool:
        return bool(self.spans)

    def __getitem__(self, part: Part) -> tuple[Span, ...]:
        return tuple(self.spans.get(part, ()))


def find(
    rows: Table,
    done: Activity,
    written: Mapping[Part, Times] | None = None,
) -> Protocol:
    """Parts in a timeline; empty without a clock check and without times in the map.

    Args:
        rows: table from `twin.logs.timeline.timeline`.
        done: activity of the machine in each row.
        written: times of the parts from the map; if given, no part is searched elsewhere.
    """
    if not len(rows["epoch_ns"]):
        return Protocol()
    if written:
        start_ns = int(rows["epoch_ns"][0])
        spans = {
            part: tuple((start_ns + int(a * 1e9), start_ns + int(b * 1e9)) for a, b in pairs)
            for part, pairs in written.items()
        }
        return Protocol(spans, written=True)
    motion = _Motion(rows, done)
    check = _clock_check(motion)
    if check is None:
        return Protocol()
    near = motion.within(check)
    coasts = _coast_downs(motion, near)
    towed, passes = _passes(motion, near & ~motion.inside(coasts))
    found = {
        Part.STANDING: _standing(motion, near),
        Part.CLOCK_CHECK: [check],
        Part.ZERO_PULL: _both_ways(motion, passes),
        Part.COAST_DOWN: coasts,
        Part.TOWED: towed,
    }
    spans = {part: tuple(map(motion.span, runs)) for part, runs in found.items() if runs}
    known = [without_pull(rows, run) is True for run in found[Part.ZERO_PULL]]
    return Protocol(spans, pull_known=bool(known) and all(known))


Run = tuple[int, int]
"""First row of a stretch, and the row after its last."""


class _Motion:
    """Speeds, acceleration and direction in the rows of a timeline."""

    def __init__(self, rows: Table, done: Activity) -> None:
        self.rows, self.done = rows, done
        self.time_s = (rows["epoch_ns"] - rows["epoch_ns"][0]) * 1e-9
        nothing = np.full(len(self.time_s), np.nan)
        ground = rows.get("speed_mps", nothing)
        wheel = rows.get("wheel_speed_mps", nothing)
        self.speed = np.where(np.isfinite(wheel), wheel, ground)
        self.accel = _slope(self.time_s, self.speed)
        yaw_rate = np.nan_to_num(rows.get("yaw_rate_radps", nothing))
        self.straight = np.abs(yaw_rate) * TURN_RADIUS_M < np.maximum(self.speed, 0.2)
        self.engine = rows.get("engine_radps")

    @property
    def idle(self) -> float | None:
        """Engine speed while standing with the engine running; None where it is unknown."""
        if self.engine is None:
            return None
        stood = self.engine[self.done[STANDING] & (self.engine > 10.0)]
        return float(np.median(stood)) if len(stood) else None

    def span(self, run: Run) -> Span:
        """First and last instant of a run of rows, without its edges."""
        first, last = int(self.rows["epoch_ns"][run[0]]), int(self.rows["epoch_ns"][run[1] - 1])
        edge = int(EDGE_S * 1e9)
        return (first + edge, last - edge) if last - first > 4 * edge else (first, last)

    def within(self, check: Run) -> NDArray[np.bool_]:
        """Rows near the clock check, but not in it."""
        near = np.abs(self.time_s - self.time_s[check[0]]) <= WITHIN_S
        near[check[0] : check[1]] = False
        return np.asarray(near)

    def inside(self, runs: list[Run]) -> NDArray[np.bool_]:
        """Rows of any of the runs."""
        found = np.zeros(len(self.time_s), np.bool_)
        for first, after in runs:
            found[first:after] = True
        return found

    def length_m(self, run: Run) -> float:
        """Distance of a run."""
        part = slice(*run)
        return float(np.nansum(self.speed[part] * self.rows["duration_s"][part]))

    def seconds(self, run: Run) -> float:
        """Duration of a run."""
        return float(self.rows["duration_s"][run[0] : run[1]].sum())

    def direction_rad(self, run: Run) -> float | None:
        """Direction from first to last position; None without positions."""
        if not {"east_m", "north_m"} <= set(self.rows):
            return None
        east, north = (self.rows[c][run[0] : run[1]] for c in ("east_m", "north_m"))
        known = np.isfinite(east) & np.isfinite(north)
        if known.sum() < 2:
            return None
        return math.atan2(*(float(v[known][-1] - v[known][0]) for v in (north, east)))

    def turned_rad(self, run: Run) -> float:
        """Greatest turn away from the first direction of a run."""
        part = slice(*run)
        yaw_rate = np.nan_to_num(self.rows.get("yaw_rate_radps", np.zeros(len(self.time_s))))
        angle = np.cumsum(yaw_rate[part] * self.rows["duration_s"][part])
        return float(np.max(np.abs(angle), initial=0.0))


def _clock_check(motion: _Motion) -> Run | None:
    """The first STOPS starts and stops in a row, with short standings between."""
    stands = stretches(motion.done[STANDING])
    count, first = 0, 0
    for (_, left), (arrived, leaves) in pairwise(stands):
        if not _is_pulse(motion, (left, arrived)):
            count = 0
            continue
        if count == 0:
            first = max(left - 1, 0)
        count += 1
        if count == STOPS:
            return first, min(arrived + 1, len(motion.time_s))
        if not STAND_S[0] <= motion.seconds((arrived, leaves)) <= STAND_S[1]:
            count = 0
    return None


def _is_pulse(motion: _Motion, run: Run) -> bool:
    """Whether a drive between two standings is one of the clock check: short, straight, fast."""
    top_mps = float(np.max(np.nan_to_num(motion.speed[slice(*run)]), initial=0.0))
    short = motion.seconds(run) <= PULSE_S
    return short and top_mps >= PULSE_MPS and motion.turned_rad(run) <= PULSE_TURN_RAD


def _standing(motion: _Motion, near: NDArray[np.bool_]) -> list[Run]:
    stood = stretches(near & motion.done[STANDING])
    return [run for run in stood if motion.seconds(run) >= QUIET_S]


def _coast_downs(motion: _Motion, near: NDArray[np.bool_]) -> list[Run]:
    """Stretches in which it rolls free: it slows down evenly, and the engine, if known, idles."""
    low, high = COAST_MPS2
    with np.errstate(invalid="ignore"):
        slowing = near & motion.straight & (motion.accel < -low) & (motion.accel > -high)
        if motion.idle is not None:
            slowing &= ~(motion.rows["engine_radps"] > (1.0 + IDLE_SHARE) * motion.idle)
    found = []
    for first, after in (_before_brakes(motion, run) for run in stretches(slowing)):
        speed = motion.speed[first:after]
        lost = float(speed[0] - speed[-1])
        fast = speed[0] >= COAST_FROM_MPS and lost >= COAST_BY_MPS
        if fast and motion.seconds((first, after)) >= COAST_S and _free(motion, (first, after)):
            found.append((first, after))
    return found


def _before_brakes(motion: _Motion, run: Run) -> Run:
    """A run up to where it slows down clearly more than in its first seconds."""
    first, after = run
    begins = motion.time_s[first:after] - motion.time_s[first] < COAST_S
    usual = float(np.median(motion.accel[first:after][begins]))
    harder = np.flatnonzero(motion.accel[first:after] < BRAKED_SHARE * usual)
    return first, first + max(int(harder[0]), 1) if len(harder) else after


def _free(motion: _Motion, run: Run) -> bool:
    """Whether the engine idles; true where its speed is unknown."""
    if motion.engine is None:
        return True
    engine = motion.engine[run[0] + 1 : run[1]]
    known = engine[np.isfinite(engine)]
    if not len(known):
        return True
    idle = motion.idle
    if idle is None:
        return float(np.ptp(known)) <= IDLE_SHARE * float(np.median(known))
    return float(np.median(known)) <= (1.0 + IDLE_SHARE) * idle


def _passes(motion: _Motion, near: NDArray[np.bool_]) -> tuple[list[Run], list[Run]]:
    """Steady straight drives without load: those with an idling engine, and those under power."""
    with np.errstate(invalid="ignore"):
        steady = near & motion.straight & (np.abs(motion.accel) < STEADY_MPS2)
        steady &= motion.speed > PULSE_MPS
    runs = [
        run
        for run in stretches(steady)
        if motion.seconds(run) >= PASS_S
        and motion.length_m(run) >= PASS_M
        and without_pull(motion.rows, run) is not False
    ]
    if motion.idle is None:
        return [], runs
    towed = [run for run in runs if _free(motion, run)]
    return towed, [run for run in runs if run not in towed]


def without_pull(rows: Table, run: Run) -> bool | None:
    """Whether draft, hitch or engine load show a stretch without pull; None if none is measured."""
    part = slice(*run)
    if "draft_pin_n" in rows:
        level = float(np.nanquantile(np.abs(rows["draft_pin_n"]), 0.95))
        mean = np.abs(np.nanmean(rows["draft_pin_n"][part]))
        return bool(mean <= max(NO_PULL_N, NO_PULL_SHARE * level))
    if "hitch_m" in rows:
        limit = two_groups(rows["hitch_m"][np.isfinite(rows["hitch_m"])], HITCH_RAISED_M)
        if limit is not None:
            return bool(np.nanmedian(rows["hitch_m"][part]) > limit)
    if "engine_load" in rows and np.nanmean(rows["engine_load"][part]) >= PULLING_LOAD:
        return False
    return None


def _both_ways(motion: _Motion, passes: list[Run]) -> list[Run]:
    """The first pass and the next one in the opposite direction; none without both."""
    for i, first in enumerate(passes):
        there = motion.direction_rad(first)
        for second in passes[i + 1 :]:
            back = motion.direction_rad(second)
            if there is None or back is None:
                continue
            turned = abs(math.remainder(back - there, 2.0 * math.pi))
            if math.pi - turned <= OPPOSITE_RAD:
                return [first, second]
    return []


def _slope(time_s: Array, values: Array) -> NDArray[np.float64]:
    """Change per second over four rows about each."""
    if len(values) < 5:
        return np.full(len(values), np.nan)
    found = np.full(len(values), np.nan)
    found[2:-2] = (values[4:] - values[:-4]) / (time_s[4:] - time_s[:-4])
    return found
