"""The parts of the report of a recorded drive.

Tables first: where time and fuel went, slip, where slip was high, what the log says of the wheels.
Then the figures; at the end what was assumed.
"""

from __future__ import annotations

import html
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from twin.io.plain import Plain
from twin.io.run_folder import Record, RunLike
from twin.logs.activity import PULLS, Activity, activity
from twin.logs.geodesy import geodetic_rad
from twin.logs.summary import highest_slip, pulls
from twin.logs.timeline import timeline
from twin.report import log_figures, log_maps
from twin.report.clock import clocked
from twin.report.draw import Drawing, Estimates
from twin.report.html import table
from twin.scores.hours import SHORT_S, hours, hours_seconds, start_text
from twin.scores.log_table import (
    ACTIVITY_HEADERS,
    PROTOCOL_HEADERS,
    SLIP_HEADERS,
    activity_rows,
    assumptions,
    fuel_sentences,
    number,
    protocol_rows,
    protocol_spans_ns,
    slip_rows,
)
from twin.streams import Streams, Table

Origin = tuple[float, float, float]
"""Latitude [deg], longitude [deg], height [m]."""
Figure = tuple[str, Drawing | None, str]
"""Heading, drawing and caption."""
OWN = ("Slip", "Path", "Power")
"""Figures of a run in whose place a log has its own, or none."""
OVER_SECONDS = (
    "Slip error", "Sideslip", "Sideslip angle error", "Draft and depth", "Speeds", "Consistency",
)  # fmt: skip
"""Figures of a run with time on their abscissa."""

TINTS = "Tint: green works, amber turns, blue is road or empty, white stands."
OVER_TIME = (
    "Medians of blocks of time, an 800th of the log each, with the 5th to 95th percentile as the "
    "band. Gaps stay open. " + TINTS
)
ON_THE_FIELD = (
    "Each dot is a second at work, its slip the median of 5 s. The numbers are the stretches with "
    "the highest slip, as in the table. Grey: the rest of the path. East and north have one scale."
)


def lead(scores: Mapping[str, Plain], run: RunLike) -> str:
    """What was recorded, in two sentences."""
    drive = scores.get("drive") or {}
    if not drive:
        return f"Recorded log of {run.setup.machine}."
    what = f"Recorded log of {run.setup.machine}, {_duration(drive['span_s'])}."
    return f"{what} Times count from its start: {start_text(drive['start_ns'])}."


def headline(scores: Mapping[str, Plain]) -> str:
    """The numbers that are asked for first."""
    drive = scores.get("drive") or {}
    of = {share["activity"]: share for share in drive.get("shares", ())}
    work, whole, took = of.get("working", {}), of.get("all", {}), drive.get("area") or {}
    items = [
        ("At work", _duration(work["time_s"]) if work else None),
        ("Median slip at work", number(work.get("slip_median"), "{:.1f} %", 100.0)),
        ("5th to 95th percentile", _spread(work)),
        ("Speed at work", number(work.get("speed_kmh"), "{:.1f} km/h")),
        ("Distance", number(whole.get("distance_m"), "{:.2f} km", 1e-3)),
        ("Area", number(took.get("area_ha"), "{:.2f} ha")),
        ("Fuel at work", number(work.get("fuel_lph"), "{:.1f} L/h")),
        ("Fuel, with turns", number(took.get("fuel_with_turns_l_per_ha"), "{:.1f} L/ha")),
        ("Fuel in all", number(whole.get("fuel_l"), "{:.1f} L")),
    ]
    shown = "".join(f"<div><dt>{k}</dt><dd>{v}</dd></div>" for k, v in items if v is not None)
    return f"<dl>{shown}</dl>" if shown else ""


def tables(scores: Mapping[str, Plain], origin_deg: Origin | None = None) -> str:
    """All tables; places in degrees too where the geodetic origin is known."""
    drive = scores.get("drive") or {}
    parts = []
    if drive.get("shares"):
        parts.append(_section("Time, slip and fuel", ACTIVITY_HEADERS, activity_rows(scores)))
        parts.append(_paragraphs(fuel_sentences(scores)))
    if rows := slip_rows(scores):
        parts.append(_section("Slip by estimator", SLIP_HEADERS, rows, names=2))
    if drive.get("high"):
        headers, lines = high_rows(drive["high"], origin_deg)
        parts.append(_section("Where slip was highest", headers, lines))
        parts.append(
            _paragraphs(
                [f"Stretches of work of up to 1 min, by {drive['estimator']}'s median slip. The "
                 "numbers stand on the map; east and north count from the first position."]
            )
        )  # fmt: skip
    if rows := protocol_rows(scores):
        parts.append(_section("Recording protocol", PROTOCOL_HEADERS, rows, kind="words"))
    return "".join(parts)


def high_rows(
    high: Sequence[Mapping[str, Plain]], origin_deg: Origin | None = None
) -> tuple[list[str], list[list[str]]]:
    """Headers and rows of the stretches with the highest slip."""
    known = [p for p in PULLS if any(s["pull"].get(p.column) is not None for s in high)]
    headers = [
        "no.",
        "start [h:mm:ss]",
        "time [s]",
        "median slip [%]",
        "95th percentile [%]",
        "speed [km/h]",
    ]
    headers += [f"{p.name} [{p.unit}]" for p in known] + ["east [m]", "north [m]"]
    headers += [] if origin_deg is None else ["latitude, longitude [°]"]
    rows = [
        [
            str(i), hours_seconds(s["start_s"]), f"{s['duration_s']:.0f}",
            number(s["slip_median"], "{:.1f}", 100.0) or "-",
            number(s["slip_p95"], "{:.1f}", 100.0) or "-",
            number(s["speed_kmh"], "{:.1f}") or "-",
            *(number(s["pull"].get(p.column), "{:.3g}", p.scale) or "-" for p in known),
            number(s["east_m"], "{:.0f}") or "-", number(s["north_m"], "{:.0f}") or "-",
            *_place(s, origin_deg),
        ]
        for i, s in enumerate(high, 1)
    ]  # fmt: skip
    return headers, rows


def _place(stretch: Mapping[str, Plain], origin_deg: Origin | None) -> list[str]:
    """Latitude and longitude, where there are any."""
    if origin_deg is None:
        return []
    if stretch["east_m"] is None or stretch["north_m"] is None:
        return ["-"]
    east_m, north_m, up_m = (np.asarray(v) for v in (stretch["east_m"], stretch["north_m"], 0.0))
    latitude_deg, longitude_deg, height_m = origin_deg
    origin = (np.radians(latitude_deg), np.radians(longitude_deg), height_m)
    latitude, longitude, _ = (np.degrees(v) for v in geodetic_rad(east_m, north_m, up_m, origin))
    return [f"{latitude:.5f}, {longitude:.5f}"]


def figures(run: RunLike, scores: Mapping[str, Plain]) -> Iterable[Figure]:
    """Heading, drawing and caption of each figure."""
    drive = scores.get("drive") or {}
    shown: Estimates = run.estimates
    rows = timeline(run.streams, run.estimates.get(str(drive.get("estimator"))))
    if not len(rows["epoch_ns"]):
        return
    done: Activity = activity(rows, protocol_spans_ns(scores))
    start_ns, high = int(rows["epoch_ns"][0]), highest_slip(rows, done)
    yield "Slip", log_figures.slip(rows, done, shown, start_ns, run.truth), OVER_TIME
    yield "Slip on the field", log_maps.slip_map(rows, done, high), ON_THE_FIELD
    yield "Path", log_maps.activity_map(rows, done), "East and north have one scale."
    for pull in pulls(rows):
        caption = (
            "At work. Bins of equal count. Activities last 10 s at least, so that work holds "
            "single seconds of low load."
        )
        yield f"Slip against {pull.name}", log_figures.slip_against(rows, done, pull), caption
    told = f"By {drive.get('estimator')}, about a value a second."
    yield "Distribution of slip", log_figures.histogram(rows, done), told
    yield "Engine and fuel", log_figures.engine(rows, done), OVER_TIME


def assumed(scores: Mapping[str, Plain]) -> str:
    """What was assumed and what else a reader should know, as a list."""
    items = "".join(f"<li>{html.escape(line)}</li>" for line in assumptions(scores))
    return f"<h2>What was assumed, and what to know</h2><ul>{items}</ul>" if items else ""


def clocked_figures(drawn: Iterable[Figure], scores: Mapping[str, Plain]) -> Iterable[Figure]:
    """The figures of a run that a log has too, with the log's time on their abscissa."""
    span_s = (scores.get("drive") or {}).get("span_s", 0.0)
    for title, drawing, caption in drawn:
        if title in OVER_SECONDS:
            yield title, clocked(drawing, span_s), caption
        elif title not in OWN:
            yield title, drawing, caption


def since_start(run: RunLike, scores: Mapping[str, Plain]) -> tuple[Record, dict[str, Plain]]:
    """The log and its scored window, with times that count from the start of the log."""
    start_ns = int((scores.get("drive") or {}).get("start_ns", 0))
    window = scores.get("window_s")
    moved = Record(
        setup=run.setup,
        streams=Streams({n: _moved(t, start_ns) for n, t in run.streams.tables.items()}),
        estimates={n: _moved(t, start_ns) for n, t in run.estimates.items()},
        truth=_moved(run.truth, start_ns) if run.truth else None,
    )
    shifted = [edge - start_ns * 1e-9 for edge in window] if window else None
    return moved, {**scores, "window_s": shifted}


def _moved(table_: Table, start_ns: int) -> Table:
    return {**table_, "epoch_ns": table_["epoch_ns"] - start_ns}


def _duration(time_s: float) -> str:
    return f"{hours(time_s)} h" if time_s >= SHORT_S else f"{time_s:.0f} s"


def _spread(share: Mapping[str, Plain]) -> str | None:
    low, high = share.get("slip_p05"), share.get("slip_p95")
    return None if low is None or high is None else f"{100 * low:.1f} to {100 * high:.1f} %"


def _section(
    title: str,
    headers: Sequence[str],
    rows: Sequence[Sequence[str]],
    *,
    names: int = 1,
    kind: str = "",
) -> str:
    return f"<h2>{html.escape(title)}</h2>{table(headers, rows, names=names, kind=kind)}"


def _paragraphs(lines: Iterable[str]) -> str:
    return "".join(f'<p class="soft">{html.escape(line)}</p>' for line in lines)
