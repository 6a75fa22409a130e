"""`twin.tune`: process and sensor noises of estimators from your own log."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.pipeline.tuned import tuned
from twin.plugins.lookup import Thing
from twin.streams import Streams, Table
from twin.tuning.held_out import Gain, HeldOut, verdict
from twin.tuning.likelihood import in_blocks, innovations
from twin.tuning.noises import Noise, moved, noises_of
from twin.tuning.parts import between, driven_s, parts, until
from twin.tuning.result import Tuning, Value
from twin.tuning.stages import Stages, stages, total

if TYPE_CHECKING:
    from twin.logs import Log, Reader
    from twin.pipeline.estimating import Estimator

Array = NDArray[np.float64]


def tune(
    log: str | Path | Iterable[str | Path],
    column_map: str | Path | None = None,
    estimators: Iterable[str | Estimator] | Mapping[str, Estimator] = ("slip-ekf",),
    reader: str | Reader | None = None,
    *,
    learn_share: float = 0.5,
    strict: bool = False,
    seed: int = 0,
    told: Callable[[int, int], None] = lambda done, total: None,
) -> dict[str, Tuning]:
    """The noises under which a log's innovations are likeliest, estimator by estimator.

    The first part of the log is learnt from. What is gained is measured on the rest, by pairs of
    blocks of time. A noise that the log does not determine, or confirms, keeps its value.

    Args:
        log: a run folder, a table, NMEA, CAN, UBX, a bag, or what `reader` reads; or several files.
        column_map: TOML that says which column is what, and in which unit.
        estimators: as `twin.run` takes them; each with `innovations(setup, streams)`.
        reader: what reads the log, or its name.
        learn_share: part of the log's time that is learnt from.
        strict: refuse a log with a single bad row.
        seed: of the points where searches begin.
        told: called with the number of estimators that are done, and of all.

    Raises:
        UnknownName: there is no such estimator or reader.
        BadInput: the log or the map cannot be used, the log is too short, or an estimator gives no
            innovations; the message names the value.

    Example:
        >>> twin.tune("field.csv", "field.toml")["slip-ekf"].verdict  # doctest: +SKIP
    """
    from twin import logs
    from twin.pipeline.log import prepared, reference
    from twin.pipeline.public import by_name

    if not 0.1 <= learn_share <= 0.9:
        raise BadInput(f"learn_share = {learn_share:g} is outside [0.1, 0.9]")
    named = by_name(estimators)
    by = logs.reader(reader) if isinstance(reader, str) else reader
    files = [Path(log)] if isinstance(log, str | Path) else [Path(each) for each in log]
    path = None if column_map is None else Path(column_map)
    read, _, _ = prepared(logs.read(files, path, by, strict=strict))
    known = reference(read, files[0])
    found = {}
    for done, (name, estimator) in enumerate(named.items()):
        told(done, len(named))
        found[name] = tune_one(name, estimator, read, known or {}, learn_share, seed)
    return found


def tune_one(
    name: str, estimator: Thing, log: Log, reference: Table, learn_share: float = 0.5, seed: int = 0
) -> Tuning:
    """What a log that is read already says of one estimator. Raises BadInput as `tune`."""
    setup, streams = log.setup, log.streams
    noises = noises_of(name, estimator, setup, streams)
    whole = innovations(name, estimator, setup, streams)
    learn_ns, rest_ns = parts(name, whole["epoch_ns"], learn_share)
    learnt = until(streams, int(learn_ns[-1]))

    def of(x: Array) -> Thing:
        return tuned(name, estimator, moved(noises, x))

    def densities(x: Array, seen: Streams, edges_ns: NDArray[np.int64]) -> dict[str, Array]:
        return in_blocks(innovations(name, of(x), setup, seen), edges_ns)

    rest = HeldOut(setup, streams, reference, rest_ns, whole)

    def gains(x: Array, less: Array) -> tuple[Gain, ...]:
        """Of noises x over noises `less`, on the held-out part."""
        sums = densities(less, streams, rest_ns), densities(x, streams, rest_ns)
        ahead = rest.errors(of(less), of(x)) if (x != less).any() else ()
        return (*rest.densities(*sums), *ahead)

    found = stages(lambda x: densities(x, learnt, learn_ns), noises, seed)
    x, kept = _kept(found, np.array([n.is_factor for n in noises]), gains)
    after = total(densities(x, streams, rest_ns)).sum()
    own = [after - total(densities(_without(x, k), streams, rest_ns)).sum() if by else 0.0
           for k, by in enumerate(x)]  # fmt: skip
    return Tuning(
        estimator=name,
        values=tuple(_value(n, x[k], found, k, own[k]) for k, n in enumerate(noises)),
        gains=gains(x, np.zeros(len(noises))),
        starts=found.starts,
        learnt_s=driven_s(between(whole["epoch_ns"], learn_ns)),
        held_out_s=driven_s(between(whole["epoch_ns"], rest_ns)),
        kept=kept,
    )


def _kept(
    found: Stages, of_sensors: NDArray[np.bool_], gains: Callable[[Array, Array], Iterable[Gain]]
) -> tuple[Array, str]:
    """What holds on the held-out part: the sensors' noises unless worse, the rest if better."""
    start = np.zeros(len(of_sensors))
    x, kept = start, "nothing"
    if found.sensors.any() and verdict(gains(found.sensors, start)) != "worse":
        x, kept = found.sensors, "sensors"
    own_too = np.where(of_sensors, x, found.all)
    better = (own_too != x).any() and verdict(gains(own_too, x)) == "better"
    if better and verdict(gains(own_too, start)) != "worse":
        return own_too, "all"
    return x, kept


def _without(x: Array, k: int) -> Array:
    return np.where(np.arange(len(x)) == k, 0.0, x)


def _value(noise: Noise, by: float, stages: Stages, k: int, gain: float) -> Value:
    why = "flat" if stages.flat[k] else "no difference told"
    if by != 0.0:
        why = "tuned, at its bound" if abs(by) > 0.99 * noise.bound else "tuned"
    elif stages.all[k] != 0.0:
        why = "not confirmed"
    sd = stages.sd[k] if by != 0.0 else math.nan
    low, high = (noise.before * math.exp(by + way * sd) for way in (-1.96, 1.96))
    return Value(
        name=noise.name, is_factor=noise.is_factor, grade=noise.grade, before=noise.before,
        value=noise.before * math.exp(by), low=low, high=high, why=why, gain=float(gain),
    )  # fmt: skip
