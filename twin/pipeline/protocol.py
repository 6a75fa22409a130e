"""The recording protocol of a log: uses scale, lag and gyro bias, reports rolling resistance."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import theilslopes

from twin.io.plain import Plain
from twin.logs import Log, driven_speed_mps, ground_speed_mps, paired_speeds
from twin.logs.activity import activity
from twin.logs.clock_check import MARGIN_S, lags_s
from twin.logs.protocol import OPPOSITE_RAD, Protocol, Span, find
from twin.logs.protocol_parts import Part
from twin.logs.timeline import timeline
from twin.pipeline.log_check import scaled
from twin.streams import Array, Setup, Streams, Table

GRAVITY_MPS2 = 9.81
WAYS_DIFFER = 0.03
"""Scales of the two ways that differ by more are not used: slope, wind or a pull is in them."""
SCALES = (0.8, 1.2)
"""A scale outside these is no rolling radius."""
LAG_SPREAD_S = 0.15
"""A lag is used where the starts and stops agree to within this [s]."""
LEAST_LAG_S = 0.02
"""A smaller one is none: the samples' own spacing [s]."""
MOST_SAMPLES = 300
"""Of a coast-down, for the slopes between any two."""
GIVES = {
    Part.STANDING: "gyro bias, noise at rest",
    Part.CLOCK_CHECK: "lag of GNSS behind wheels",
    Part.ZERO_PULL: "zero-slip scale",
    Part.COAST_DOWN: "rolling resistance / weight",
    Part.TOWED: "zero-torque scale",
}
MISSING = {
    Part.STANDING: "no 20 s of standing",
    Part.CLOCK_CHECK: "no three starts and stops",
    Part.ZERO_PULL: "no steady straight passes both ways",
    Part.COAST_DOWN: "no free rolling from 10 km/h",
    Part.TOWED: "no steady drive with the engine idling",
}


@dataclass(frozen=True, kw_only=True)
class Finding:
    """Result of one part of the recording protocol."""

    part: str
    found: bool
    starts_s: tuple[float, ...] = ()
    """Start of each occurrence, since the start of the log [s]."""
    spans_ns: tuple[Span, ...] = ()
    gives: str
    value: str = ""
    number: float | None = None
    """The same as a number: rad/s, s, scale, share of the weight, scale."""
    used: str = ""
    missing: str = ""


def applied(log: Log) -> tuple[Log, dict[str, Plain]]:
    """Log corrected by its recording protocol, and the findings for scores.json.

    Zero-pull passes scale the wheel speeds if the map has no rule [zero_slip]. The clock check
    shifts the GNSS epochs. Standing gives a bias that is subtracted from the gyro. Without a
    protocol the log is unchanged.
    """
    speeds = with_speeds(log.streams, log.setup)
    rows = timeline(speeds)
    if not len(rows["epoch_ns"]):
        return log, {}
    protocol = find(rows, activity(rows), log.protocol)
    if not protocol:
        return log, {"protocol": None}
    start_ns = int(rows["epoch_ns"][0])
    findings = []
    for part, measure in (
        (Part.STANDING, _standing),
        (Part.CLOCK_CHECK, _clock_check),
        (Part.ZERO_PULL, _zero_pull),
        (Part.COAST_DOWN, _coast_down),
        (Part.TOWED, _towed),
    ):
        spans = protocol[part]
        finding = Finding(part=part, found=False, gives=GIVES[part], missing=MISSING[part])
        if spans:
            log, finding = measure(log, speeds, spans, protocol)
            starts_s = tuple((first - start_ns) * 1e-9 for first, _ in spans)
            finding = replace(finding, starts_s=starts_s, spans_ns=spans)
        findings.append(finding)
    return log, {"protocol": {"parts": [asdict(f) for f in findings]}}


def with_speeds(streams: Streams, setup: Setup) -> Streams:
    """Streams with rear wheel speeds w R [m/s], computed from ticks if the source gives ticks.

    w R = 2 pi R / counts * d ticks / d t

    w: wheel speed [rad/s]. R: rolling radius [m]. counts: ticks of one turn. t: time [s].
    """
    wheels = streams.tables.get("wheels")
    block = setup.wheels
    if wheels is None or block is None or block.counts_per_turn is None:
        return streams
    if not {"ticks_rl", "ticks_rr"} <= set(wheels) or len(wheels["epoch_ns"]) < 3:
        return streams
    time_s = (wheels["epoch_ns"] - wheels["epoch_ns"][0]) * 1e-9
    added: Table = {
        f"speed_{w}_mps": 2.0 * math.pi * block.radius_m[w] / block.counts_per_turn
        * np.gradient(wheels[f"ticks_{w}"].astype(np.float64), time_s)
        for w in ("rl", "rr")
    }  # fmt: skip
    return Streams({**streams.tables, "wheels": {**wheels, **added}}, streams.frames)


def _standing(
    log: Log, speeds: Streams, spans: Sequence[Span], protocol: Protocol
) -> tuple[Log, Finding]:
    """Mean rates of the gyro at rest, taken off it; else the speed that the GNSS has at rest."""
    found = Finding(part=Part.STANDING, found=True, gives=GIVES[Part.STANDING])
    imu = log.streams.tables.get("imu", {})
    means = {
        axis: float(np.nanmean(imu[axis][_inside(imu, spans)]))
        for axis in ("gyro_x_radps", "gyro_y_radps", "gyro_z_radps")
        if axis in imu and np.isfinite(imu[axis][_inside(imu, spans)]).any()
    }
    if not means:
        at_rest = _rest_speed_mps(speeds, spans)
        told = "nothing measured" if at_rest is None else f"GNSS speed {1e3 * at_rest:.0f} mm/s RMS"
        return log, replace(found, value=told)
    moved: Table = {**imu, **{axis: imu[axis] - mean for axis, mean in means.items()}}
    log = replace(log, streams=Streams({**log.streams.tables, "imu": moved}, log.streams.frames))
    each = " ".join(f"{axis[5]} {math.degrees(v):+.4f}" for axis, v in means.items())
    told = f"gyro bias {each} °/s"
    yaw = means.get("gyro_z_radps")
    return log, replace(found, value=told, number=yaw, used="taken off the gyro")


def _rest_speed_mps(speeds: Streams, spans: Sequence[Span]) -> float | None:
    if "gnss" not in speeds:
        return None
    speed = ground_speed_mps(speeds)[_inside(speeds["gnss"], spans)]
    known = speed[np.isfinite(speed)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else None


def _clock_check(
    log: Log, speeds: Streams, spans: Sequence[Span], protocol: Protocol
) -> tuple[Log, Finding]:
    """The mean lag of the GNSS behind the wheels in the starts and stops; it is moved by it."""
    found = Finding(part=Part.CLOCK_CHECK, found=True, gives=GIVES[Part.CLOCK_CHECK])
    if "gnss" not in speeds or "wheels" not in speeds:
        return log, replace(found, value="no GNSS and wheels to compare")
    lags = _lags_s(speeds, spans)
    if not len(lags):
        return log, replace(found, value="too few samples to tell it")
    lags = lags[np.isfinite(lags)]
    if not len(lags):
        return log, replace(found, value="wheels locked or spun; brake more gently")
    lag_s, spread_s = float(np.mean(lags)), float(np.ptp(lags))
    each = ", ".join(f"{lag:.2f}" for lag in lags)
    found = replace(found, value=f"GNSS late by {lag_s:.2f} s ({each})", number=lag_s)
    if len(lags) < 2 or spread_s > LAG_SPREAD_S:
        return log, replace(found, used="no, the starts and stops do not agree")
    if abs(lag_s) <= max(spread_s, LEAST_LAG_S):
        return log, replace(found, used="no, not apart from zero")
    tables = {**log.streams.tables, "gnss": _earlier(log.streams["gnss"], lag_s)}
    moved = replace(log, streams=Streams(tables, log.streams.frames))
    return moved, replace(found, used="GNSS moved by it")


def _lags_s(speeds: Streams, spans: Sequence[Span]) -> Array:
    """The lags in all the starts and stops of the spans."""
    edge_ns = int(MARGIN_S * 1e9)
    wide = [(first - edge_ns, last + edge_ns) for first, last in spans]
    ground, driven = ground_speed_mps(speeds), driven_speed_mps(speeds)
    found = []
    for span in wide:
        gnss, wheels = (_inside(speeds[sensor], [span]) for sensor in ("gnss", "wheels"))
        times = [
            (speeds[sensor]["epoch_ns"][inside] - span[0]) * 1e-9
            for sensor, inside in (("gnss", gnss), ("wheels", wheels))
        ]
        found.append(lags_s(times[0], ground[gnss], times[1], driven[wheels]))
    return np.concatenate(found)


def _earlier(gnss: Table, lag_s: float) -> Table:
    """The table with epochs that are earlier by a lag; none arrives before its epoch."""
    epoch_ns = gnss["epoch_ns"] - round(lag_s * 1e9)
    arrival_ns = np.maximum.accumulate(np.maximum(gnss["arrival_ns"], epoch_ns))
    return {**gnss, "epoch_ns": epoch_ns, "arrival_ns": arrival_ns}


def _zero_pull(
    log: Log, speeds: Streams, spans: Sequence[Span], protocol: Protocol
) -> tuple[Log, Finding]:
    """The mean over both ways of ground by wheel speed; the wheels are scaled by it."""
    found = Finding(part=Part.ZERO_PULL, found=True, gives=GIVES[Part.ZERO_PULL])
    ratios = list(_ratios(speeds, spans))
    if not ratios:
        return log, replace(found, value="no GNSS and wheels to compare")
    scale = float(np.mean(ratios))
    ways = ", ".join(f"{ratio:.4f}" for ratio in ratios)
    found = replace(found, value=f"{GIVES[Part.ZERO_PULL]} {scale:.4f} ({ways})", number=scale)
    if refusal := _not_used(log, ratios, scale):
        return log, replace(found, used=refusal)
    proof = "" if protocol.pull_known else "; no pull was measured"
    return _scaled(log, scale), replace(found, used=f"wheels times {scale:.4f}{proof}")


def _not_used(log: Log, ratios: Sequence[float], scale: float) -> str:
    """Why a scale is not used; empty where it is."""
    if "zero_slip" in log.rules:
        return "no, the map's [zero_slip] is"
    if len(ratios) < 2:
        return "no, one way only"
    if np.ptp(ratios) > WAYS_DIFFER:
        return f"no, the ways differ by {100.0 * np.ptp(ratios):.1f} %"
    return "" if SCALES[0] <= scale <= SCALES[1] else "no, not a rolling radius"


def _scaled(log: Log, scale: float) -> Log:
    """The log with its wheel speeds, or the nominal radii of its ticks, times the scale."""
    wheels = log.setup.wheels
    if wheels is None or wheels.counts_per_turn is None:
        return scaled(log, scale)
    radius_m = {w: scale * r if w in log.setup.driven else r for w, r in wheels.radius_m.items()}
    return replace(log, setup=replace(log.setup, wheels=replace(wheels, radius_m=radius_m)))


def _coast_down(
    log: Log, speeds: Streams, spans: Sequence[Span], protocol: Protocol
) -> tuple[Log, Finding]:
    """Deceleration over gravity, each direction counting the same; the wheels' inertia is in it."""
    found = Finding(part=Part.COAST_DOWN, found=True, gives=GIVES[Part.COAST_DOWN])
    each = [(way, share) for span in spans for way, share in _rolling(speeds, span)]
    if not each:
        return log, replace(found, value="no speed to tell it from")
    ahead = each[0][0]
    sides: dict[bool, list[float]] = {}
    for way, share in each:
        sides.setdefault(math.cos(way - ahead) > math.cos(OPPOSITE_RAD), []).append(share)
    mean = float(np.mean([np.mean(side) for side in sides.values()]))
    ways = ", ".join(f"{share:.4f}" for _, share in each)
    told = f"{GIVES[Part.COAST_DOWN]} {mean:.4f} ({ways})"
    if len(sides) < 2:
        told += ", one way only: a slope is in it"
    return log, replace(found, value=told, number=mean)


def _rolling(speeds: Streams, span: Span) -> Iterable[tuple[float, float]]:
    """Direction of travel, and deceleration over gravity: the median slope between two samples."""
    if "gnss" not in speeds:
        return
    gnss, speed = speeds["gnss"], ground_speed_mps(speeds)
    inside = _inside(gnss, [span]) & np.isfinite(speed)
    if inside.sum() < 4:
        return
    rows = np.flatnonzero(inside)[:: 1 + int(inside.sum()) // MOST_SAMPLES]
    time_s = (gnss["epoch_ns"][rows] - span[0]) * 1e-9
    slope = float(theilslopes(speed[rows], time_s).slope)
    east, north = (float(np.mean(gnss[f"v_{axis}_mps"][inside])) for axis in ("east", "north"))
    yield math.atan2(north, east), -slope / GRAVITY_MPS2


def _towed(
    log: Log, speeds: Streams, spans: Sequence[Span], protocol: Protocol
) -> tuple[Log, Finding]:
    """Ground by wheel speed of wheels that roll free: zero slip by zero torque, not zero pull."""
    found = Finding(part=Part.TOWED, found=True, gives=GIVES[Part.TOWED])
    ratios = list(_ratios(speeds, spans))
    if not ratios:
        return log, replace(found, value="no GNSS and wheels to compare")
    scale = float(np.mean(ratios))
    return log, replace(
        found, value=f"{GIVES[Part.TOWED]} {scale:.4f}", number=scale, used="no, zero pull is"
    )


def _ratios(speeds: Streams, spans: Sequence[Span]) -> Iterable[float]:
    """Ground speed over wheel speed, the ratio of the means in each span."""
    ground, wheel = paired_speeds(speeds)
    if not len(wheel):
        return
    for span in spans:
        both = _inside(speeds["wheels"], [span]) & np.isfinite(ground) & np.isfinite(wheel)
        if both.any() and np.mean(wheel[both]) > 0.0:
            yield float(np.mean(ground[both]) / np.mean(wheel[both]))


def _inside(table: Table, spans: Sequence[Span]) -> NDArray[np.bool_]:
    epoch_ns: Array = table["epoch_ns"]
    found = np.zeros(len(epoch_ns), np.bool_)
    for first, last in spans:
        found |= (epoch_ns >= first) & (epoch_ns <= last)
    return found
