"""Which signal is which quantity, in which unit: names first, then what the numbers can be."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.logs.cells import Text, labels, numbers
from twin.logs.geodesy import enu_m
from twin.logs.mapping.names import is_time, quantity_of, unit_of
from twin.logs.quantities import QUANTITIES
from twin.logs.readers.reading import Reading
from twin.logs.signals import Found, Signal
from twin.logs.stamps import TIMESTAMP, stamps
from twin.logs.units import UNITS
from twin.streams import Array

_NS = 1e9
_STEPS_S = (1e-4, 60.0)
"""Steps between rows that a log has."""
_USUAL_UNIT = {
    "gnss.speed": "m/s", "wheels": "km/h", "machine.engine_load": "%", "machine.fuel_rate": "L/h",
    "machine.engine_speed": "rpm", "machine.draft_pin": "N", "imu.gyro": "rad/s",
    "imu.accel": "m/s2", "reference.slip": "1",
}  # fmt: skip
_MOST_LABELS = 20


@dataclass(frozen=True, kw_only=True)
class Guess:
    """What a signal is taken to be."""

    signal: str
    section: str
    key: str
    unit: str
    why: str
    sure: bool
    convention: str = ""
    sign: int = 1


@dataclass(frozen=True, kw_only=True)
class Seen:
    """A signal as numbers on its times."""

    name: str
    values: NDArray[np.float64]
    time_s: NDArray[np.float64]

    @property
    def rate_hz(self) -> float:
        """Values in a second, at the median; NaN for fewer than two."""
        known = self.time_s[np.isfinite(self.values)]
        step = np.diff(known)
        return float(1.0 / np.median(step)) if len(step) and np.median(step) > 0 else math.nan

    @property
    def holes(self) -> float:
        """Share of rows without a value."""
        return float(np.mean(~np.isfinite(self.values))) if len(self.values) else 1.0


@dataclass(frozen=True, kw_only=True)
class Guesses:
    """A first map of one file."""

    time: Guess | None
    quantities: tuple[Guess, ...]
    labels: tuple[str, ...]
    """Columns of text with few values."""
    seen: tuple[Seen, ...]


def guesses(found: Found) -> Guesses:
    """The time, the quantities and the labels of a file's signals."""
    time = _time(found)
    seen, text = [], []
    for name, signal in found.signals.items():
        if time is not None and name == time.signal:
            continue
        numeric = _numeric(name, signal, found, time)
        if numeric is not None:
            seen.append(numeric)
        elif _few_labels(name, signal):
            text.append(name)
    own = _own(found.own_map)
    told = {g.section for g in own}
    guessed = [g for g in _by_name(seen) if g.section not in told]
    chosen = [*own, *(guessed if own else _by_physics(guessed, {s.name: s for s in seen}))]
    return Guesses(time=time, quantities=tuple(chosen), labels=tuple(text), seen=tuple(seen))


def _own(own_map: Mapping[str, object]) -> list[Guess]:
    """What a file says of itself."""
    told = []
    for section, sources in own_map.items():
        for key, source in dict(sources).items() if isinstance(sources, Mapping) else ():
            told.append(Guess(
                signal=str(source["column"]), section=section, key=key, unit=str(source["unit"]),
                why="named by its standard", sure=True,
                convention=str(source.get("convention", "")),
            ))  # fmt: skip
    return told


def _time(found: Found) -> Guess | None:
    """The column of times of a table."""
    table = {n: s for n, s in found.signals.items() if s.epoch_ns is None}
    named = [n for n in table if is_time(n)]
    for name in [*named, *(n for n in table if n not in named)]:
        unit = _time_unit(name, table[name])
        if unit:
            sure = name in named
            return Guess(
                signal=name, section="log", key="time", unit=unit, sure=sure,
                why="by its name" if sure else "it rises from row to row",
            )  # fmt: skip
        if name in named:
            continue
    return None


def _time_unit(name: str, signal: Signal) -> str:
    """The unit of a column of times; nothing where it is none."""
    values = signal.values
    if not isinstance(values, Text | list) and values.dtype.kind == "M":
        return TIMESTAMP
    cells = signal.cells
    number, wrong = numbers(name, cells)
    known = number[np.isfinite(number)]
    if len(known) < 2 or wrong.mean() > 0.5:
        return TIMESTAMP if isinstance(cells, Text) and _are_stamps(name, cells) else ""
    step = np.diff(known)
    if np.mean(step > 0) < 0.9:
        return ""
    for unit, largest in (("s", 4e9), ("ms", 4e12), ("us", 4e15), ("ns", 4e18)):
        if known[0] > 1e9 and 1e9 < known[0] / 10.0 ** {"s": 0, "ms": 3, "us": 6, "ns": 9}[unit] < (
            largest if unit == "s" else 4e9
        ):
            return unit
    told = unit_of(name, tuple(UNITS["time"]))
    if told:
        return told
    usual = float(np.median(step))
    if 20000.0 < known[0] < 80000.0 and usual < 0.1:
        return "days"
    whole = bool(np.all(known == np.round(known)))
    return "ms" if whole and usual >= 5.0 else "s"


def _are_stamps(name: str, cells: Text) -> bool:
    try:
        made = stamps(name, cells, TIMESTAMP)
    except BadInput:
        return False
    return bool(made.kept.mean() > 0.5)


def _numeric(name: str, signal: Signal, found: Found, time: Guess | None) -> Seen | None:
    """A signal as numbers; None for text."""
    values = Text.of(signal.values) if isinstance(signal.values, list) else signal.values
    if not isinstance(values, Text) and values.dtype.kind not in "iufb":
        return None
    number, wrong = numbers(name, values)
    if wrong.sum() > 0.5 * max(int((np.isfinite(number) | wrong).sum()), 1):
        return None
    if signal.epoch_ns is not None:
        return Seen(name=name, values=number, time_s=signal.epoch_ns / _NS)
    if time is None:
        return Seen(name=name, values=number, time_s=np.arange(len(number), dtype=np.float64))
    table = found.signals[time.signal]
    cells = Text.of(table.values) if isinstance(table.values, list) else table.values
    made = stamps(time.signal, cells, time.unit)
    if len(made.kept) != len(number):
        return Seen(name=name, values=number, time_s=np.arange(len(number), dtype=np.float64))
    return Seen(name=name, values=number[made.kept], time_s=made.epoch_ns / _NS)


def _few_labels(name: str, signal: Signal) -> bool:
    if signal.epoch_ns is not None or not isinstance(signal.values, Text | list):
        return False
    try:
        cells = Text.of(signal.values) if isinstance(signal.values, list) else signal.values
        return 1 < len(np.unique(labels(name, cells))) <= _MOST_LABELS
    except BadInput:
        return False


def _by_name(seen: list[Seen]) -> list[Guess]:
    """The first signal with values that is called like a quantity."""
    chosen: dict[str, Guess] = {}
    for each in seen:
        quantity = quantity_of(each.name)
        if not quantity or quantity in chosen or not np.isfinite(each.values).any():
            continue
        section, _, key = quantity.partition(".")
        allowed = tuple(UNITS[QUANTITIES[section][key].dimension])
        told = unit_of(each.name, allowed)
        unit = told or _usual_unit(section, key, each, allowed)
        why = "by its name" if told or len(allowed) <= 2 else "by its name; the unit is not said"
        chosen[quantity] = Guess(
            signal=each.name, section=section, key=key, unit=unit, why=why,
            sure=bool(told) or len(allowed) <= 2,
        )  # fmt: skip
    return _consistent(chosen)


def _usual_unit(section: str, key: str, seen: Seen, allowed: tuple[str, ...]) -> str:
    largest = float(np.nanmax(np.abs(seen.values)))
    if QUANTITIES[section][key].dimension == "angle":
        return "deg" if largest > 2.1 * math.pi or key in ("latitude", "longitude") else "rad"
    if key.startswith("gyro"):
        return "deg/s" if largest > 3.0 else "rad/s"
    if key.startswith("accel"):
        return "g" if key == "accel_z" and 0.5 < abs(np.nanmedian(seen.values)) < 1.5 else "m/s2"
    if key in ("engine_load", "slip"):
        return "%" if largest > 2.0 else "1"
    usual = _USUAL_UNIT.get(f"{section}.{key}", _USUAL_UNIT.get(section, ""))
    return usual if usual in allowed else allowed[0]


def _consistent(chosen: dict[str, Guess]) -> list[Guess]:
    """Without what a map cannot have together."""
    have = set(chosen)
    if {"wheels.speed_rl", "wheels.speed_rr"} <= have or any(".ticks_" in k for k in have):
        chosen.pop("wheels.driven_speed", None)
    elif "wheels.driven_speed" in have:
        for wheel in ("fl", "fr", "rl", "rr"):
            chosen.pop(f"wheels.speed_{wheel}", None)
    if {"gnss.v_east", "gnss.v_north"} <= have:
        chosen.pop("gnss.speed", None)
        chosen.pop("gnss.course", None)
    else:
        for key in ("gnss.v_east", "gnss.v_north"):
            chosen.pop(key, None)
    geodetic = {"gnss.latitude", "gnss.longitude"} <= have
    for key in ("gnss.east", "gnss.north") if geodetic else ("gnss.latitude", "gnss.longitude"):
        chosen.pop(key, None)
    order = [f"{section}.{key}" for section, keys in QUANTITIES.items() for key in keys]
    return [chosen[k] for k in order if k in chosen]


def _by_physics(chosen: list[Guess], seen: Mapping[str, Seen]) -> list[Guess]:
    """Units and senses that the numbers confirm or correct."""
    by_key = {f"{g.section}.{g.key}": g for g in chosen}
    track = _track(by_key, seen)
    if track is not None:
        time_s, speed, direction = track
        _fit_speed(by_key, "gnss.speed", seen, time_s, speed, 0.1, "positions move so fast")
        for key in ("gnss.course", "gnss.heading"):
            _fit_angle(by_key, key, seen, time_s, speed, direction)
    ground = _si(by_key, "gnss.speed", seen)
    if ground is not None:
        for key in [k for k in by_key if k.startswith("wheels.") and "speed" in k]:
            _fit_speed(by_key, key, seen, ground[0], ground[1], 0.3, "near the ground's speed")
    _fit_yaw(by_key, seen)
    return list(by_key.values())


def _track(
    by_key: Mapping[str, Guess], seen: Mapping[str, Seen]
) -> tuple[Array, Array, Array] | None:
    """Times, speed and direction (from east) between positions some seconds apart."""
    pairs = (("gnss.latitude", "gnss.longitude"), ("gnss.north", "gnss.east"))
    pair = next((p for p in pairs if set(p) <= set(by_key)), None)
    if pair is None:
        return None
    lat, lon = (seen[by_key[key].signal] for key in pair)
    if len(lat.values) != len(lon.values):
        return None
    known = np.isfinite(lat.values) & np.isfinite(lon.values)
    known &= (lat.values != 0.0) | (lon.values != 0.0)
    if known.sum() < 10:
        return None
    time_s = lat.time_s[known]
    north, east = lat.values[known], lon.values[known]
    if pair[0] == "gnss.latitude":
        unit = UNITS["angle"][by_key["gnss.latitude"].unit]
        a, o = north * unit, east * unit
        if np.abs(a).max() > math.pi / 2:
            return None
        origin = float(np.median(a)), float(np.median(o)), 0.0
        east, north, _ = enu_m(a, o, np.zeros(len(a)), origin)
    step = max(round(2.0 / max(float(np.median(np.diff(time_s))), 1e-6)), 1)
    if len(time_s) <= step:
        return None
    dt = time_s[step:] - time_s[:-step]
    de, dn = east[step:] - east[:-step], north[step:] - north[:-step]
    good = (dt > 0) & (dt < 10.0)
    middle = 0.5 * (time_s[step:] + time_s[:-step])
    return middle[good], np.hypot(de, dn)[good] / dt[good], np.arctan2(dn, de)[good]


def _si(
    by_key: Mapping[str, Guess], key: str, seen: Mapping[str, Seen]
) -> tuple[Array, Array] | None:
    guess = by_key.get(key)
    if guess is None:
        return None
    each, section = seen[guess.signal], guess.section
    known = np.isfinite(each.values)
    factor = UNITS[QUANTITIES[section][guess.key].dimension][guess.unit]
    return each.time_s[known], each.values[known] * factor


def _fit_speed(
    by_key: dict[str, Guess], key: str, seen: Mapping[str, Seen], time_s: Array, speed: Array,
    near: float, why: str,
) -> None:  # fmt: skip
    """The unit with which a speed comes nearest to another."""
    guess = by_key.get(key)
    if guess is None or len(time_s) < 10:
        return
    each = seen[guess.signal]
    known = np.isfinite(each.values)
    if known.sum() < 10:
        return
    raw = np.abs(np.interp(time_s, each.time_s[known], each.values[known]))
    moving = (speed > 0.5) & (raw > 0.0)
    if moving.sum() < 10:
        return
    ratio = float(np.median(speed[moving] / raw[moving]))
    off = {u: abs(math.log(factor / ratio)) for u, factor in UNITS["speed"].items()}
    unit = min(off, key=lambda u: off[u])
    if off[guess.unit] < near:
        by_key[key] = replace(guess, sure=True, why=f"{guess.why}; confirmed, {why}")
    elif off[unit] < near:
        by_key[key] = replace(guess, unit=unit, sure=False, why=f"the {why} in {unit}")
    else:
        by_key[key] = replace(guess, sure=False, why=f"{guess.why}; but no unit makes the {why}")


def _fit_angle(
    by_key: dict[str, Guess], key: str, seen: Mapping[str, Seen], time_s: Array, speed: Array,
    direction: Array,
) -> None:  # fmt: skip
    """Degrees or radians, from north or from east, whichever goes along the track."""
    guess = by_key.get(key)
    if guess is None:
        return
    each = seen[guess.signal]
    known = np.isfinite(each.values)
    moving = speed > 0.5
    if known.sum() < 10 or moving.sum() < 10:
        return
    at = np.searchsorted(each.time_s[known], time_s[moving]).clip(0, int(known.sum()) - 1)
    raw = each.values[known][at]
    fits = {}
    for unit in ("deg", "rad"):
        for convention in ("compass", "east"):
            angle = raw * UNITS["angle"][unit]
            angle = math.pi / 2 - angle if convention == "compass" else angle
            off = np.abs(np.angle(np.exp(1j * (angle - direction[moving]))))
            fits[unit, convention] = float(np.median(off))
    unit, convention = min(fits, key=lambda f: fits[f])
    now = fits[guess.unit, guess.convention or "compass"]
    if fits[unit, convention] > math.radians(25.0):
        by_key[key] = replace(guess, sure=False, why=f"{guess.why}; it does not follow the track")
    elif now <= fits[unit, convention] + math.radians(3.0):
        by_key[key] = replace(guess, sure=True, why=f"{guess.why}; it follows the track")
    else:
        by_key[key] = replace(
            guess, unit=unit, convention="" if convention == "compass" else convention,
            sure=False, why=f"follows the track in {unit}, {convention}",
        )  # fmt: skip


def _fit_yaw(by_key: dict[str, Guess], seen: Mapping[str, Seen]) -> None:
    """Unit and sign of a yaw rate, by how the heading turns."""
    rate, angle = by_key.get("imu.gyro_z"), by_key.get("gnss.heading") or by_key.get("gnss.course")
    if rate is None or angle is None:
        return
    turn, gyro = seen[angle.signal], seen[rate.signal]
    known, own = np.isfinite(turn.values), np.isfinite(gyro.values)
    if known.sum() < 20 or own.sum() < 20:
        return
    sense = 1.0 if angle.convention == "east" else -1.0
    heading = np.unwrap(turn.values[known] * UNITS["angle"][angle.unit]) * sense
    step = np.diff(gyro.time_s[own], prepend=gyro.time_s[own][0])
    summed = np.interp(turn.time_s[known], gyro.time_s[own], np.cumsum(gyro.values[own] * step))
    rows = max(round(10.0 / max(float(np.median(np.diff(turn.time_s[known]))), 1e-6)), 1)
    change, by_gyro = heading[rows:] - heading[:-rows], summed[rows:] - summed[:-rows]
    turning = (np.abs(change) > 0.15) & (np.abs(change) < math.pi)
    if turning.sum() < 5:
        return
    share = float(np.median(change[turning] / by_gyro[turning]))
    if not math.isfinite(share) or share == 0.0:
        return
    off = {u: abs(math.log(abs(share) / f)) for u, f in UNITS["angular rate"].items()}
    unit = min(off, key=lambda u: off[u])
    if off[unit] < 0.3:
        sign = 1 if share > 0 else -1
        sure = unit == rate.unit and sign == 1
        why = f"turns as the heading does in {unit}" + (", the other way round" if sign < 0 else "")
        by_key["imu.gyro_z"] = replace(rate, unit=unit, sign=sign, sure=sure, why=why)


def file_guesses(found: Mapping[str, Found]) -> dict[str, Guesses]:
    """The guesses of every file."""
    return {name: guesses(each) for name, each in found.items()}


__all__ = ["Guess", "Guesses", "Reading", "Seen", "file_guesses", "guesses"]
