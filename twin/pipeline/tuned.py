"""An estimator with other noises than its own: values of its fields, factors on the sensors' sd.

The file that `twin tune` writes and `--tuning` takes:

    schema = 1
    ["four-state".values]            # fields of the estimator
    jerk_psd_m2ps5 = 0.31
    ["four-state".factors]           # on the sd that the set-up and the streams state
    gnss_velocity = 2.1
"""

from __future__ import annotations

import dataclasses
import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from twin.errors import BadInput, TwinError, UnknownName
from twin.io.plain import Plain
from twin.pipeline.estimating import Estimator, State
from twin.plugins.lookup import Thing
from twin.scenario.fields import replaced
from twin.streams import Setup, Streams, Table

SCHEMA = 1
UNSTATED_SD_MPS = 0.05
"""What estimators take for the sd of a wheel speed whose source states none [m/s]."""

FACTORS: dict[str, tuple[str, str, str]] = {
    "gnss_position": ("gnss", "position_sd_m", "position_sd_m"),
    "gnss_velocity": ("gnss", "velocity_sd_mps", "velocity_sd_mps"),
    "gnss_heading": ("gnss", "heading_sd_rad", "heading_sd_rad"),
    "imu_accel": ("imu", "accel_noise_mps2_rthz", ""),
    "imu_gyro": ("imu", "gyro_noise_radps_rthz", ""),
    "wheel_speed": ("wheels", "", "speed_sd_mps"),
}
"""Factor on an sd -> the sensor, and where the set-up and the stream have that sd."""

Numbers = Mapping[str, float]


@dataclass(frozen=True, kw_only=True)
class Noises:
    """Changes of the noises of an estimator: values of its fields, factors on sensor sd."""

    values: Numbers = field(default_factory=dict)
    """Field of the estimator, by dotted path -> its value."""
    factors: Numbers = field(default_factory=dict)
    """Name in FACTORS -> factor on that sd."""


@dataclass(frozen=True)
class Tuned:
    """An estimator whose inputs have sensor sd multiplied by factors."""

    estimator: Thing
    factors: Numbers

    @property
    def offline(self) -> bool:
        """True if the estimator needs the whole log in one chunk."""
        return bool(getattr(self.estimator, "offline", False))

    def init(self, setup: Setup) -> State:
        """The estimator's state before the first sample."""
        return self.estimator.init(scaled_setup(setup, self.factors))

    def run(self, state: State, chunk: Streams) -> tuple[State, Table]:
        """The estimator's new state, and its estimates of the chunk."""
        result: tuple[State, Table] = self.estimator.run(state, scaled_streams(chunk, self.factors))
        return result

    def innovations(self, setup: Setup, streams: Streams) -> Table:
        """Innovations of the estimator with the scaled sd."""
        scaled, seen = scaled_setup(setup, self.factors), scaled_streams(streams, self.factors)
        found: Table = self.estimator.innovations(scaled, seen)
        return found


def tuned(name: str, estimator: Thing, noises: Noises) -> Thing:
    """Estimator `name` with the changed noises.

    Raises:
        BadInput: the estimator is no dataclass, lacks a field, or refuses a value.
    """
    if noises.values:
        if not dataclasses.is_dataclass(estimator):
            raise BadInput(
                f"estimator '{name}' is no dataclass, so its {', '.join(noises.values)} cannot be "
                "set; tune factors of sensors alone"
            )
        try:
            estimator = replaced(estimator, noises.values)
        except TwinError as error:
            raise BadInput(f"estimator '{name}': {error}") from None
    return Tuned(estimator, noises.factors) if noises.factors else estimator


def scaled_setup(setup: Setup, factors: Numbers) -> Setup:
    """Set-up with sd multiplied by `factors` (name in FACTORS -> factor [-])."""
    for name, factor in factors.items():
        sensor, key, _ = FACTORS[name]
        block = getattr(setup, sensor)
        if key and block is not None:
            block = dataclasses.replace(block, **{key: getattr(block, key) * factor})
            setup = dataclasses.replace(setup, **{sensor: block})
    return setup


def scaled_streams(streams: Streams, factors: Numbers) -> Streams:
    """Streams with sd columns multiplied by `factors` (name in FACTORS -> factor [-])."""
    tables = dict(streams.tables)
    for name, factor in factors.items():
        sensor, _, column = FACTORS[name]
        table = tables.get(sensor)
        if table is None or not column:
            continue
        if column in table:
            tables[sensor] = table | {column: table[column] * factor}
        elif sensor == "wheels" and any(c.startswith("speed_") for c in table):
            stated = np.full(len(table["epoch_ns"]), UNSTATED_SD_MPS * factor)
            tables[sensor] = table | {column: stated}
    return Streams(tables, streams.frames)


def read(path: Path) -> dict[str, Noises]:
    """Estimator -> its tuned fields and factors, from a file that `twin tune` wrote.

    Raises:
        BadInput: the file is missing, or is not a valid file of `twin tune`.
        UnknownName: a factor has a name that is not in FACTORS.
    """
    try:
        plain = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise BadInput(f"--tuning {path}: there is no such file") from None
    except (OSError, ValueError) as error:
        raise BadInput(f"--tuning {path} is not TOML: {error}") from None
    if plain.pop("schema", None) != SCHEMA:
        raise BadInput(f"--tuning {path} has no 'schema = {SCHEMA}'; twin tune writes such a file")
    return {name: _noises(f"--tuning {path}: {name}", part) for name, part in plain.items()}


def _noises(where: str, part: Plain) -> Noises:
    kinds = [f.name for f in dataclasses.fields(Noises)]
    if not isinstance(part, Mapping):
        raise BadInput(f"{where} is no table; it has the tables {' and '.join(kinds)}")
    for kind, numbers in part.items():
        if kind not in kinds:
            raise UnknownName(f"table of {where}", kind, kinds)
        if not isinstance(numbers, Mapping):
            raise BadInput(f"{where}: {kind} = {numbers} is no table of numbers")
        for key, value in numbers.items():
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if not (number and math.isfinite(value) and value > 0.0):
                raise BadInput(f"{where}: {key} = {value} is no number above 0")
            if kind == "factors" and key not in FACTORS:
                raise UnknownName(f"factor of {where}", key, FACTORS)
    return Noises(**{k: {n: float(v) for n, v in part[k].items()} for k in part})


def applied(
    estimators: Mapping[str, Estimator], noises: Mapping[str, Noises], path: Path
) -> tuple[dict[str, Estimator], list[str]]:
    """Estimators with the noises of a file, and a note on each changed estimator.

    Raises:
        BadInput: the file has no noises for any of the estimators.
    """
    there = [name for name in estimators if name in noises]
    if not there:
        raise BadInput(
            f"--tuning {path} is of {', '.join(noises) or 'no estimator'}, "
            f"and {', '.join(estimators)} are run"
        )
    changed = {name: tuned(name, estimators[name], noises[name]) for name in there}
    return {**estimators, **changed}, [f"{n}: {_said(noises[n])}, from {path}" for n in there]


def _said(noises: Noises) -> str:
    values = [f"{name} = {value:.4g}" for name, value in noises.values.items()]
    factors = [f"{name} sd x {factor:.4g}" for name, factor in noises.factors.items()]
    return "tuned: " + (", ".join([*values, *factors]) or "nothing")
