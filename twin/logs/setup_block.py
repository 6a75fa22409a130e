"""The nominal machine from the plain mapping of a TOML or JSON file, checked field by field."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import TypeVar

from twin.errors import BadInput, UnknownName
from twin.streams import BLOCKS, WHEELS, ZERO_SLIPS, OwnSetup, Setup, own_setup

Block = TypeVar("Block")

ASSUMED: dict[str, dict[str, object]] = {
    "": {
        "machine": "unnamed tractor",
        "wheelbase_m": 2.7,
        "track_front_m": 1.8,
        "track_rear_m": 1.8,
        "cg_x_m": 1.1,
    },
    "wheels": {"rate_hz": 1.0, "radius_m": {"fl": 0.6, "fr": 0.6, "rl": 0.8, "rr": 0.8}},
    "gnss": {
        "rate_hz": 1.0,
        "lever_arm_m": (0.0, 0.0, 3.0),
        "position_sd_m": 1.5,
        "velocity_sd_mps": 0.05,
        "heading_sd_rad": 0.02,
    },
    "imu": {
        "rate_hz": 50.0,
        "lever_arm_m": (0.0, 0.0, 1.0),
        "gyro_noise_radps_rthz": 1e-4,
        "accel_noise_mps2_rthz": 1e-3,
        "gyro_bias_sd_radps": 5e-3,
        "accel_bias_sd_mps2": 0.1,
    },
    "depth": {"rate_hz": 20.0, "zero_m": 1.0, "laser_sd_m": 0.005},
}
"""Defaults of values that nobody gave (a 100 kW standard tractor, a stand-alone receiver, an
industrial MEMS IMU); a log's notes name every one that was used."""

_POSITIVE = ("wheelbase_m", "track_front_m", "track_rear_m", "rate_hz", "counts_per_turn")


def setup_from(raw: Mapping[str, object], *, where: str = "setup", assume: bool) -> Setup:
    """The set-up; with `assume`, values not given come from ASSUMED, else they are BadInput."""
    top = ASSUMED[""] if assume else {}
    values = _fields(Setup, raw, where, top, skip=(*BLOCKS, "extra"))
    for name, block in BLOCKS.items():
        if raw.get(name) is not None:
            section = f"{where}.{name}"
            given = _fields(block, table_of(section, raw[name]), section, _assumed(name, assume))
            values[name] = _made(block, given)
            zero = getattr(values[name], "zero_slip", "law")
            if zero not in ZERO_SLIPS:
                raise BadInput(f"{section}.zero_slip: {UnknownName('zero slip', zero, ZERO_SLIPS)}")
    if raw.get("extra") is not None:
        own = table_of(f"{where}.extra", raw["extra"])
        values["extra"] = {stream: _own(f"{where}.extra.{stream}", own[stream]) for stream in own}
    return _made(Setup, values)


def _assumed(block: str, assume: bool) -> Mapping[str, object]:
    return ASSUMED.get(block, {}) if assume else {}


def _made(kind: type[Block], values: Mapping[str, object]) -> Block:
    return kind(**values)


def _own(where: str, raw: object) -> OwnSetup:
    """The block of a user's own sensor; its values are not checked."""
    try:
        return own_setup({k: table_of(f"{where}.{k}", v) for k, v in table_of(where, raw).items()})
    except TypeError as error:
        raise BadInput(f"[{where}] is no set-up of a sensor: {error}") from None


def table_of(where: str, raw: object) -> Mapping[str, object]:
    """Value of a key, if it is a table. Raises BadInput."""
    if not isinstance(raw, Mapping):
        raise BadInput(f"[{where}] must be a table of values")
    return raw


def assumed_names(raw: Mapping[str, object], sensors: tuple[str, ...]) -> tuple[str, ...]:
    """The values of ASSUMED that `raw` does not give, as `name = value`."""
    names = [_said(k, v) for k, v in ASSUMED[""].items() if k not in raw]
    for sensor in sensors:
        given = table_of(f"setup.{sensor}", raw.get(sensor, {}))
        names += [_said(f"{sensor}.{k}", v) for k, v in ASSUMED[sensor].items() if k not in given]
    return tuple(names)


def _said(name: str, value: object) -> str:
    """`name = value`; of wheels, name and value each."""
    if isinstance(value, Mapping):
        return f"{name} = " + " ".join(f"{key} {part:g}" for key, part in value.items())
    if isinstance(value, tuple):
        return f"{name} = [{' '.join(f'{part:g}' for part in value)}]"
    return f"{name} = {value:g}" if isinstance(value, float) else f"{name} = {value}"


def _fields(
    block: type,
    raw: Mapping[str, object],
    where: str,
    default: Mapping[str, object],
    skip: tuple[str, ...] = (),
) -> dict[str, object]:
    """The values of a dataclass's fields, each of the kind its annotation asks for."""
    fields = {f.name: f for f in dataclasses.fields(block)}
    for key in raw:
        if key not in fields:
            raise BadInput(str(UnknownName(f"value of [{where}]", key, fields)))
    values = dict(default)
    for name, field in fields.items():
        if name in skip:
            continue
        if name in raw:
            values[name] = _value(f"{where}.{name}", str(field.type), raw[name])
        elif name not in values and field.default is dataclasses.MISSING:
            raise BadInput(f"[{where}] has no {name}; give it")
    return values


def _value(where: str, kind: str, value: object) -> object:
    if value is None and "None" in kind:
        return None
    if kind == "bool":
        if not isinstance(value, bool):
            raise BadInput(f"{where} = {value!r} must be true or false")
        return value
    if kind == "str":
        return _text(where, value)
    if kind == "tuple[str, ...]":
        return _wheels(where, value)
    if kind.startswith("tuple[float"):
        if not isinstance(value, list) or len(value) != 3:
            raise BadInput(f"{where} = {value!r} must be three numbers")
        return tuple(_number(where, v) for v in value)
    if kind.startswith("Mapping"):
        return _radii(where, value)
    number = _number(where, value)
    if kind.startswith("int"):
        if number != int(number):
            raise BadInput(f"{where} = {value!r} must be a whole number")
        return int(number)
    return number


def _text(where: str, value: object) -> str:
    if not isinstance(value, str) or not value.strip() or len(value) > 200:
        raise BadInput(f"{where} = {value!r} must be a short text")
    return value


def _number(where: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise BadInput(f"{where} = {value!r} must be a number")
    if not math.isfinite(value) or abs(value) > 1e9:
        raise BadInput(f"{where} = {value} is outside [-1e9, 1e9]")
    name = where.rpartition(".")[2]
    if value <= 0.0 and (name in _POSITIVE or "radius_m" in where):
        raise BadInput(f"{where} = {value} must be above zero")
    return float(value)


def _wheels(where: str, value: object) -> tuple[str, ...]:
    if not isinstance(value, list) or not value or any(w not in WHEELS for w in value):
        raise BadInput(f"{where} = {value!r} must be a list of {', '.join(WHEELS)}")
    return tuple(value)


def _radii(where: str, value: object) -> dict[str, float]:
    if not isinstance(value, Mapping) or any(w not in WHEELS for w in value):
        raise BadInput(f"{where} = {value!r} must give metres by wheel: {', '.join(WHEELS)}")
    return {w: _number(f"{where}.{w}", r) for w, r in value.items()}
