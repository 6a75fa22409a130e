"""Units and senses that the numbers of a log confirm or correct."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from twin.logs.checks.across import mount_across_rad
from twin.logs.geodesy import enu_m
from twin.logs.mapping.guessed import Guess, Seen
from twin.logs.quantities import QUANTITIES
from twin.logs.units import UNITS
from twin.streams import Array


def by_physics(chosen: list[Guess], seen: Mapping[str, Seen]) -> list[Guess]:
    """Units and senses that the numbers confirm or correct."""
    by_key = {f"{g.section}.{g.key}": g for g in chosen}
    track = track_of(by_key, seen)
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


def track_of(
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


def mount_rad(chosen: Sequence[Guess], seen: Mapping[str, Seen]) -> float | None:
    """How the antennas are turned, where the heading lies across the track of the positions."""
    by_key = {f"{g.section}.{g.key}": g for g in chosen}
    guess, track = by_key.get("gnss.heading"), track_of(by_key, seen)
    if guess is None or track is None:
        return None
    each = seen[guess.signal]
    known = np.isfinite(each.values)
    if known.sum() < 2:
        return None
    angle = each.values[known] * UNITS["angle"][guess.unit] * guess.sign
    turned = np.exp(1j * (angle if guess.convention == "east" else math.pi / 2 - angle))
    time_s, speed, course = track
    at = np.searchsorted(each.time_s[known], time_s).clip(0, int(known.sum()) - 1)
    return mount_across_rad(np.angle(turned[at]), course, speed, time_s)


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
    if guess is None or guess.own or len(time_s) < 10:
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
    elif guess.unit_told and off[unit] < near:
        by_key[key] = replace(guess, sure=False, why=f"{guess.why}; but the {why} in {unit}")
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
    if guess is None or guess.own:
        return
    each = seen[guess.signal]
    known = np.isfinite(each.values)
    moving = speed > 0.5
    if known.sum() < 10 or moving.sum() < 10:
        return
    at = np.searchsorted(each.time_s[known], time_s[moving]).clip(0, int(known.sum()) - 1)
    raw = each.values[known][at]
    fits = {}
    for unit in (guess.unit,) if guess.unit_told else ("deg", "rad"):
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
    if rate is None or angle is None or rate.own:
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
    if rate.unit_told and off[rate.unit] >= 0.3:
        why = f"{rate.why}; but it does not turn as the heading does"
        by_key["imu.gyro_z"] = replace(rate, sure=False, why=why)
    elif off[unit] < 0.3:
        unit = rate.unit if rate.unit_told else unit
        sign = 1 if share > 0 else -1
        sure = unit == rate.unit and sign == 1
        why = f"turns as the heading does in {unit}" + (", the other way round" if sign < 0 else "")
        by_key["imu.gyro_z"] = replace(rate, unit=unit, sign=sign, sure=sure, why=why)
