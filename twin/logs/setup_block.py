"""The nominal machine from the plain mapping of a TOML or JSON file, checked field by field."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

from twin.errors import BadInput, UnknownName
from twin.streams import WHEELS, DepthSetup, GnssSetup, ImuSetup, Setup, WheelsSetup

BLOCKS: dict[str, Any] = {
    "wheels": WheelsSetup,
    "gnss": GnssSetup,
    "imu": ImuSetup,
    "depth": DepthSetup,
}

ASSUMED: dict[str, dict[str, Any]] = {
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
"""What stands in for a value nobody gave (a 100 kW standard tractor, a stand-alone receiver, an
industrial MEMS IMU); a log's notes name every one that was used."""

_POSITIVE = ("wheelbase_m", "track_front_m", "track_rear_m", "rate_hz", "counts_per_turn")


def setup_from(raw: Mapping[str, Any], *, where: str = "setup", assume: bool) -> Setup:
    """The set-up; with `assume`, values not given come from ASSUMED, else they are BadInput."""
    values = _fields(Setup, raw, where, ASSUMED[""] if assume else {}, skip=tuple(BLOCKS))
    for name, block in BLOCKS.items():
        if raw.get(name) is not None:
            section = f"{where}.{name}"
            if not isinstance(raw[name], Mapping):
                raise BadInput(f"[{section}] must be a table of values")
            given = _fields(block, raw[name], section, ASSUMED[name] if assume else {})
            values[name] = block(**given)
    return Setup(**values)


def assumed_names(raw: Mapping[str, Any], sensors: tuple[str, ...]) -> tuple[str, ...]:
    """Names of the values of ASSUMED that stand in for what `raw` does not give."""
    names = [k for k in ASSUMED[""] if k not in raw]
    for sensor in sensors:
        names += [f"{sensor}.{k}" for k in ASSUMED[sensor] if k not in raw.get(sensor, {})]
    return tuple(names)


def _fields(
    block: Any,
    raw: Mapping[str, Any],
    where: str,
    default: Mapping[str, Any],
    skip: tuple[str, ...] = (),
) -> dict[str, Any]:
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


def _value(where: str, kind: str, value: Any) -> Any:
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


def _text(where: str, value: Any) -> str:
    if not isinstance(value, str) or not value.strip() or len(value) > 200:
        raise BadInput(f"{where} = {value!r} must be a short text")
    return value


def _number(where: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise BadInput(f"{where} = {value!r} must be a number")
    if not math.isfinite(value) or abs(value) > 1e9:
        raise BadInput(f"{where} = {value} is outside [-1e9, 1e9]")
    name = where.rpartition(".")[2]
    if value <= 0.0 and (name in _POSITIVE or "radius_m" in where):
        raise BadInput(f"{where} = {value} must be above zero")
    return float(value)


def _wheels(where: str, value: Any) -> tuple[str, ...]:
    if not isinstance(value, list) or not value or any(w not in WHEELS for w in value):
        raise BadInput(f"{where} = {value!r} must be a list of {', '.join(WHEELS)}")
    return tuple(value)


def _radii(where: str, value: Any) -> dict[str, float]:
    if not isinstance(value, Mapping) or any(w not in WHEELS for w in value):
        raise BadInput(f"{where} = {value!r} must give metres by wheel: {', '.join(WHEELS)}")
    return {w: _number(f"{where}.{w}", r) for w, r in value.items()}
