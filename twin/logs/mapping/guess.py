"""Which signal is which quantity, in which unit: names first, then what the numbers can be."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from twin.errors import BadInput
from twin.logs.cells import Text, labels, numbers
from twin.logs.column_map import BEARINGS
from twin.logs.mapping.guessed import Guess, Seen
from twin.logs.mapping.names import OWN_NAMES, quantity_of, unit_of
from twin.logs.mapping.physics import by_physics, mount_rad
from twin.logs.mapping.times import time_of
from twin.logs.quantities import QUANTITIES
from twin.logs.signals import Found, Signal
from twin.logs.stamps import stamps
from twin.logs.units import UNITS

_NS = 1e9
_USUAL_UNIT = {
    "gnss.speed": "m/s", "wheels": "km/h", "machine.engine_load": "%", "machine.fuel_rate": "L/h",
    "machine.engine_speed": "rpm", "machine.draft_pin": "N", "imu.gyro": "rad/s",
    "imu.accel": "m/s2", "reference.slip": "1",
}  # fmt: skip
_MOST_LABELS = 20
_MOST_ENGINE_RADPS = 420.0
"""4000 rpm, more than a tractor's engine reaches; in rpm it would be less than any idles at."""


@dataclass(frozen=True, kw_only=True)
class Guesses:
    """A first map of one file."""

    time: Guess | None
    quantities: tuple[Guess, ...]
    labels: tuple[str, ...]
    """Columns of text with few values."""
    seen: tuple[Seen, ...]
    heading_mount_rad: float | None = None
    """Where the heading lies across the track, how the antennas are turned."""


def guesses(found: Found) -> Guesses:
    """The time, the quantities and the labels of a file's signals."""
    time = time_of(found)
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
    chosen = [*own, *(guessed if own else by_physics(guessed, {s.name: s for s in seen}))]
    return Guesses(
        time=time, quantities=tuple(chosen), labels=tuple(text), seen=tuple(seen),
        heading_mount_rad=mount_rad(chosen, {s.name: s for s in seen}),
    )  # fmt: skip


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
        units = UNITS[QUANTITIES[section][key].dimension]
        if each.name in OWN_NAMES:
            chosen[quantity] = _of_a_stream(each.name, section, key, units)
            continue
        allowed = tuple(units)
        told = unit_of(each.name, allowed)
        unit = told or _usual_unit(section, key, each, allowed)
        large = np.nanmax(np.abs(each.values)) > 2.1 * math.pi
        plain = len(allowed) <= 2 or (unit == "deg" and large)
        why = "by its name" if told or plain else "by its name; the unit is not said"
        chosen[quantity] = Guess(
            signal=each.name, section=section, key=key, unit=unit, why=why,
            sure=bool(told) or plain, unit_told=bool(told),
        )  # fmt: skip
    return _consistent(chosen)


def _of_a_stream(name: str, section: str, key: str, units: Mapping[str, float]) -> Guess:
    """What the name of a stream's column says: SI, angles from east."""
    return Guess(
        signal=name, section=section, key=key, sure=True, unit_told=True, own=True,
        unit=next(unit for unit, factor in units.items() if factor == 1.0),
        why="by its name, that of a stream's column", convention="east" if key in BEARINGS else "",
    )  # fmt: skip


def _usual_unit(section: str, key: str, seen: Seen, allowed: tuple[str, ...]) -> str:
    largest = float(np.nanmax(np.abs(seen.values)))
    if QUANTITIES[section][key].dimension == "angle":
        return "deg" if largest > 2.1 * math.pi or key in ("latitude", "longitude") else "rad"
    if key.startswith("gyro"):
        return "deg/s" if largest > 3.0 else "rad/s"
    if key.startswith("accel"):
        return "g" if key == "accel_z" and 0.5 < abs(np.nanmedian(seen.values)) < 1.5 else "m/s2"
    if key == "engine_speed" and largest < _MOST_ENGINE_RADPS:
        return "rad/s"
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
