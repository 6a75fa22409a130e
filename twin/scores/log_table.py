"""What was found of a recorded drive as rows of text, for the terminal and for the report.

Everything is made of the plain values in scores.json. Slip is in percent on every line.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from twin.io.plain import Plain
from twin.scores.hours import SHORT_S, hours, hours_seconds
from twin.scores.table import zero_line

ACTIVITY_RANKS = {
    "activity": 0, "time [h:mm]": 0, "share [%]": 5, "distance [km]": 4, "speed [km/h]": 1,
    "median slip [%]": 0, "5th to 95th percentile [%]": 2,
    "engine running [1/min]": 7, "load [%]": 6, "fuel [L/h]": 0, "fuel [L]": 3,
}  # fmt: skip
"""Heading -> its rank, as in `twin.scores.table`."""
ACTIVITY_HEADERS = tuple(ACTIVITY_RANKS)
SLIP_RANKS = {
    "estimator": 0, "choice": 0, "median slip [%]": 0, "5th percentile [%]": 0,
    "95th percentile [%]": 0, "values": 1,
}  # fmt: skip
SLIP_HEADERS = tuple(SLIP_RANKS)
PROTOCOL_RANKS = {"part": 0, "when [h:mm:ss]": 1, "gave": 0, "used": 0}
PROTOCOL_HEADERS = tuple(PROTOCOL_RANKS)
PARTS_OF_SLIP = {
    "slip": "while driving", "work_slip": "at work",
    "steady_slip": "by [steady] of the column map",
}  # fmt: skip
"""Key of what was found -> what its rows are called."""


_ZERO = re.compile(r"^-(?=0(\.0+)?(?![\d.]))")
"""The sign of what rounds to zero."""


def protocol_spans_ns(scores: Mapping[str, Plain]) -> Sequence[tuple[int, int]]:
    """First and last instants of every part of the protocol, which is no work."""
    parts = (scores.get("protocol") or {}).get("parts") or ()
    return [(int(first), int(last)) for part in parts for first, last in part["spans_ns"]]


def number(value: float | None, form: str, scale: float = 1.0) -> str | None:
    """A number as text; None where it is unknown."""
    return None if value is None else _ZERO.sub("", form.format(scale * value))


def activity_rows(scores: Mapping[str, Plain]) -> list[list[str]]:
    """One row for each activity and one of all, in the order of ACTIVITY_HEADERS."""
    drive = scores.get("drive") or {}
    shares = drive.get("shares") or ()
    whole_s = sum(s["time_s"] for s in shares if s["activity"] != "all") or 1.0
    clock = hours if drive.get("span_s", 0.0) >= SHORT_S else hours_seconds
    return [
        [
            s["activity"],
            clock(s["time_s"]),
            f"{100.0 * s['time_s'] / whole_s:.0f}",
            _text(s["distance_m"], "{:.2f}", 1e-3),
            _text(s["speed_kmh"], "{:.1f}"),
            _text(s["slip_median"], "{:.1f}", 100.0),
            _between(s["slip_p05"], s["slip_p95"]),
            _text(s["engine_rpm"], "{:.0f}"),
            _text(s["engine_load"], "{:.0f}", 100.0),
            _text(s["fuel_lph"], "{:.1f}"),
            _text(s["fuel_l"], "{:.1f}"),
        ]
        for s in shares
    ]


def slip_rows(scores: Mapping[str, Plain]) -> list[list[str]]:
    """One row for each estimator with a slip, and choice of rows, in the order of SLIP_HEADERS."""
    return [
        [
            name,
            rows,
            _text(slip["median"], "{:.2f}", 100.0),
            _text(slip["p05"], "{:.2f}", 100.0),
            _text(slip["p95"], "{:.2f}", 100.0),
            str(slip["n"]),
        ]
        for key, rows in PARTS_OF_SLIP.items()
        for name, slip in (scores.get(key) or {}).items()
        if slip["n"]
    ]


def protocol_rows(scores: Mapping[str, Plain]) -> list[list[str]]:
    """One row for each part of the recording protocol, found or not; none where none was found."""
    parts = (scores.get("protocol") or {}).get("parts") or ()
    if not any(part["found"] for part in parts):
        return []
    return [
        [
            part["part"],
            ", ".join(hours_seconds(s) for s in part["starts_s"]) or "-",
            part["value"] or f"not found: {part['missing']}",
            part["used"] or "-",
        ]
        for part in parts
    ]


def scale_lines(scores: Mapping[str, Plain]) -> list[str]:
    """What steady work and the wheels' scale were found to be, by the map's rules."""
    steady, zero = scores.get("steady"), zero_line(scores)
    told = [] if zero is None or not slip_rows(scores) else [zero]
    if not steady:
        return told
    lag_s = steady["lag_s"]
    lag = "is unknown" if lag_s is None else f"is {lag_s:.2f} s"
    return [
        *told,
        f"steady work: median slip {_percent(steady, 'slip_median', 'slip_low', 'slip_high')}, "
        f"{steady['n']} rows of the log where {steady['rule']}",
        f"lag of GNSS speed behind wheel speed {lag}",
    ]


def fuel_sentences(scores: Mapping[str, Plain]) -> list[str]:
    """Area, L/ha and ha/h of the work, or why not; empty where the log has no activities."""
    drive = scores.get("drive") or {}
    if not drive.get("shares"):
        return []
    took, of = drive.get("area"), {share["activity"]: share for share in drive["shares"]}
    if of.get("all", {}).get("fuel_lph") is None:
        return ["The log has no fuel rate, so no litres can be told; map machine.fuel_rate."]
    if drive.get("width_m") is None:
        return [
            "Litres per hectare cannot be told: the implement's width is unknown. "
            "[implement] width_m in the column map gives it."
        ]
    if not took:
        return ["Litres per hectare cannot be told: no work was found in the log."]
    if took["fuel_at_work_l_per_ha"] is None:
        return ["Litres per hectare cannot be told: the fuel rate at work is unknown."]
    return [
        f"{took['area_ha']:.2f} ha at a width of {took['width_m']:g} m: "
        f"{took['fuel_at_work_l_per_ha']:.1f} L/ha at work, "
        f"{took['fuel_with_turns_l_per_ha']:.1f} L/ha with the turns; "
        f"{took['ha_per_h']:.2f} ha/h at work."
    ]


def assumptions(scores: Mapping[str, Plain]) -> list[str]:
    """Rules, definitions and values that the numbers rest on, then the notes of the reading."""
    drive = scores.get("drive") or {}
    lines = []
    if drive.get("estimator"):
        lines.append(
            f"Slip in tables and figures is {drive['estimator']}'s, unless they say else. Slip is "
            "1 - ground speed / wheel speed of the driven wheels; negative where they turn slower "
            "than the ground passes, as in curves, braking, or by noise."
        )
    lines += scale_lines(scores)
    if scores.get("zero_slip_from"):
        lines.append(scores["zero_slip_from"])
    if drive.get("rule"):
        lines.append(drive["rule"])
    if drive.get("area"):
        lines.append(
            f"Area is distance at work times {drive['width_m']:g} m, the width in the column map. "
            "Where passes overlap, less ground is worked, and its litres per hectare are more."
        )
    return [*lines, *scores.get("notes", ())]


def _text(value: float | None, form: str, scale: float = 1.0) -> str:
    return number(value, form, scale) or "-"


def _between(low: float | None, high: float | None) -> str:
    return (
        f"{_text(low, '{:.1f}', 100.0)} to {_text(high, '{:.1f}', 100.0)}"
        if low is not None
        else "-"
    )


def _percent(of: Mapping[str, Plain], middle: str, low: str, high: str) -> str:
    return (
        f"{100 * of[middle]:.1f} % (95 % interval: {100 * of[low]:.1f} to {100 * of[high]:.1f} %)"
    )
