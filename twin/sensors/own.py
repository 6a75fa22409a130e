"""A user's own sensor, found by `module:Name`: base class, `init`, `sample` and `setup`.

`init` and `sample` have the form of those in the modules of the twin's sensors. Errors of a user's
code name the sensor and the line.
"""

from __future__ import annotations

import dataclasses
import re
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

import numpy as np

from twin.errors import BadInput, TwinError, UnknownName
from twin.io.plain import from_plain
from twin.plugins.failing import failing
from twin.plugins.lookup import attribute, line
from twin.sensors.checks import check_fields
from twin.streams import COLUMNS, STAMPS, OwnSetup, Table, Value

if TYPE_CHECKING:
    from twin.sensors.nominal import Geometry
    from twin.trajectory.trajectory import Trajectory

State: TypeAlias = Any
"""State of a sensor from chunk to chunk, of any type."""

STREAM = re.compile("[a-z][a-z0-9_]*")
"""Form of a stream's name, which is also the name of a file."""
PLACE = "sensor"
"""Key in scenario.json with the sensor's name, beside its fields."""


@dataclass(frozen=True)
class Column:
    """A column of a stream."""

    name: str
    unit: str
    meaning: str


@dataclass(frozen=True, kw_only=True)
class Sensor:
    """Base class of your own sensor: a frozen dataclass of its data sheet and its true errors.

    A subclass gives `stream`, `columns`, `init` and `sample`. A field's range is in its type:
    `Annotated[float, Range(0, 1)]`.
    """

    stream: ClassVar[str] = ""
    """Name of the sensor's table in `Streams`."""
    columns: ClassVar[tuple[Column, ...]] = ()
    """Columns of the stream, besides `epoch_ns` and `arrival_ns`."""

    def __post_init__(self) -> None:
        if not STREAM.fullmatch(self.stream) or self.stream in COLUMNS:
            raise BadInput(
                f"sensor {self.name}: stream = '{self.stream}' must be lower-case letters, digits "
                f"and _, and none of {', '.join(COLUMNS)}"
            )
        named = [column.name for column in self.columns]
        if not named or len({*named, *STAMPS}) < len(named) + len(STAMPS):
            raise BadInput(f"sensor {self.name}: columns = {named} must be names, each once")
        check_fields(self.stream, self)

    def setup(self, geometry: Geometry) -> Mapping[str, Value]:
        """Set-up for estimators: nominal values alone, never a true error."""
        return {}

    def init(self, seed: int, start_ns: int) -> State:
        """State at the start of a run; every random number must come from the seed."""
        raise NotImplementedError

    def sample(self, state: State, chunk: Trajectory) -> tuple[State, Table]:
        """New state and the samples of a chunk, the same bits however a run is cut into chunks."""
        raise NotImplementedError

    @property
    def name(self) -> str:
        """Name of the sensor, `module:Name`."""
        kind, module = type(self), type(self).__module__
        script = getattr(sys.modules.get("__main__"), "__file__", None)
        if module == "__main__" and script:
            module = Path(script).stem
        return f"{module}:{kind.__qualname__}"

    @classmethod
    def by_name(cls, spec: str) -> Sensor:
        """The sensor `module:Name`, a class with its defaults or an instance.

        Raises:
            BadInput: the module or the name does not exist, or it is no Sensor.
        """
        if ":" not in spec:
            raise BadInput(f"sensor '{spec}' must be module:Name")
        found = attribute("sensor", spec)
        if isinstance(found, type) and issubclass(found, cls):
            found = _made(spec, found, {})
        if not isinstance(found, cls):
            kind = getattr(found, "__name__", type(found).__name__)
            raise BadInput(f"sensor '{spec}' is {kind}; it must be a twin.sensors.Sensor")
        return found

    def to_plain(self) -> dict[str, object]:
        """Name and fields as plain values, as scenario.json stores them."""
        kept = {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}
        return {PLACE: self.name, **kept}

    @classmethod
    def from_plain(cls, value: object) -> Sensor:
        """Inverse of `to_plain`. Raises BadInput."""
        if not isinstance(value, Mapping) or not isinstance(value.get(PLACE), str):
            raise BadInput(f"a sensor of one's own needs '{PLACE}': 'module:Name'")
        spec = value[PLACE]
        fields = {name: given for name, given in value.items() if name != PLACE}
        return _made(spec, type(cls.by_name(spec)), fields)


def _made(spec: str, kind: type[Sensor], fields: Mapping[str, object]) -> Sensor:
    try:
        return from_plain(kind, fields)
    except TwinError:
        raise
    except Exception as error:  # whatever a user's constructor raises
        raise BadInput(f"sensor '{spec}' cannot be made: {line(error)}") from None


@dataclass(frozen=True, kw_only=True)
class OwnState:
    """State of a user's own sensor."""

    state: State
    arrival_ns: int
    """Arrival of the last sample."""


def init(config: Sensor, seed: int, start_ns: int) -> OwnState:
    """State of the sensor at the start of a run. Raises BadInput if the user's code fails."""
    with failing(f"sensor '{config.name}': init", config):
        return OwnState(state=config.init(seed, start_ns), arrival_ns=start_ns)


def sample(config: Sensor, state: OwnState, chunk: Trajectory) -> tuple[OwnState, Table]:
    """New state and the samples of the chunk.

    Raises:
        BadInput: the user's code fails, or its table does not have the stated columns.
    """
    with failing(f"sensor '{config.name}'", config):
        given: object = config.sample(state.state, chunk.read_only())
    if not (isinstance(given, tuple) and len(given) == 2 and isinstance(given[1], Mapping)):
        kind = type(given).__name__
        raise BadInput(f"sensor '{config.name}': sample gives {kind}, not (state, table)")
    try:
        table = _checked(config, given[1], state.arrival_ns)
    except TwinError as error:
        raise BadInput(f"sensor '{config.name}': {error}") from None
    last_ns = int(table["arrival_ns"][-1]) if len(table["arrival_ns"]) else state.arrival_ns
    return OwnState(state=given[0], arrival_ns=last_ns), table


def setup(config: Sensor, geometry: Geometry) -> OwnSetup:
    """Set-up of the sensor for estimators.

    Raises:
        BadInput: the user's code fails, or returns no mapping of plain values.
    """
    with failing(f"sensor '{config.name}': setup", config):
        told = dict(config.setup(geometry))
    values = {str(name): _value(config, str(name), value) for name, value in told.items()}
    return OwnSetup(columns={c.name: (c.unit, c.meaning) for c in config.columns}, values=values)


def _value(config: Sensor, name: str, value: object) -> Value:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list | tuple) and all(isinstance(v, int | float) for v in value):
        return tuple(float(v) for v in value)
    if isinstance(value, bool | int | float | str):
        return value
    raise BadInput(
        f"sensor '{config.name}': setup gives {name} = {value!r}; "
        "a number, a text or a tuple of numbers will do"
    )


def _checked(config: Sensor, given: Mapping[str, object], last_ns: int) -> Table:
    """The table with its columns in order. Raises BadInput that names the column."""
    wanted = (*STAMPS, *(column.name for column in config.columns))
    for name in given:
        if name not in wanted:
            raise UnknownName(f"column of {config.stream}", str(name), wanted)
    if lacking := [name for name in wanted if name not in given]:
        raise BadInput(f"sample gives no {', no '.join(lacking)}")
    table = {name: np.asarray(given[name]) for name in wanted}
    count = table["epoch_ns"].shape
    for name, values in table.items():
        if values.ndim != 1 or values.shape != count:
            raise BadInput(f"{name} has shape {values.shape}, epoch_ns {count}")
        if name in STAMPS and values.dtype != np.int64:
            raise BadInput(f"{name} is {values.dtype}, not int64 nanoseconds")
        if values.dtype.kind not in "biuf":
            raise BadInput(f"{name} holds {values.dtype} values, not numbers")
    if np.any(np.diff(table["arrival_ns"], prepend=last_ns) < 0):
        raise BadInput("arrival_ns falls; no sample arrives before the one sent before it")
    if np.any(table["arrival_ns"] < table["epoch_ns"]):
        raise BadInput("a sample arrives before the instant it describes")
    return table
