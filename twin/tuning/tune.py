"""`twin.tune`: process and sensor noises of estimators from one's own log."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.io.atomic import write_text
from twin.pipeline.tuned import SCHEMA, Noises, tuned
from twin.plugins.percent import MOVING_MPS
from twin.tuning import held_out
from twin.tuning.held_out import AFTER, BEFORE, Gain
from twin.tuning.likelihood import in_blocks, innovations
from twin.tuning.noises import Noise, moved, noises_of
from twin.tuning.search import Found, search

if TYPE_CHECKING:
    from twin.logs import Log, Reader
    from twin.pipeline.estimating import Estimator

Array = NDArray[np.float64]

BLOCKS = 20
"""Blocks of each part of a log, by which intervals are made."""
SETTLE_S = 5.0
"""The first innovations are of an unknown start, and do not count [s]."""
LEAST_S, LEAST_INNOVATIONS = 30.0, 300
"""Least time of driving [s] and least number of innovations in each of the two parts."""
GAP_S = 3.0
"""Between innovations further apart than this nothing was driven [s]."""


@dataclass(frozen=True, kw_only=True)
class Value:
    """A noise before and after."""

    name: str
    """Field of the estimator, or factor on an sd of a sensor."""
    is_factor: bool
    grade: str
    before: float
    value: float
    """What the log says; `before` where it cannot tell, or agrees with it."""
    low: float
    high: float
    """95 % interval; NaN where there is none."""
    why: str
    """`tuned`, `tuned, at its bound`, `no difference told`, or `flat`."""
    gain: float
    """Log density that this value alone gains on the held-out part."""


@dataclass(frozen=True, kw_only=True)
class Tuning:
    """What a log says of the noises of an estimator."""

    estimator: str
    values: tuple[Value, ...]
    gains: tuple[Gain, ...]
    """On the held-out part, of all values together."""
    starts: tuple[float, ...]
    """Log density that each search reached."""
    learnt_s: float
    held_out_s: float

    @property
    def verdict(self) -> str:
        """Of the held-out part: `better`, `worse` or `no difference`.

        `better` where the log density is, and no error of the speed is worse.
        """
        of = {gain.quantity: gain.verdict for gain in self.gains}
        density, *others = of.values()
        return "worse" if density == "better" and "worse" in others else density

    @property
    def noises(self) -> Noises:
        """What `--tuning` takes: nothing differs unless the held-out part is better."""
        told = [v for v in self.values if v.value != v.before and self.verdict == "better"]
        return Noises(
            values={v.name: v.value for v in told if not v.is_factor},
            factors={v.name: v.value for v in told if v.is_factor},
        )


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
    blocks of time. A noise that the log cannot tell, or of which it says no other, stays.

    Args:
        log: a run folder, a table, NMEA, CAN, UBX, a bag, or what `reader` reads; or several files.
        column_map: TOML that says which column is what, and in which unit.
        estimators: as `twin.run` takes them; each with `innovations(setup, streams)`.
        reader: what reads the log, or its name.
        learn_share: part of the log's time that is learnt from.
        strict: refuse a log with a single bad row.
        seed: of the points where searches begin.
        told: told how many estimators of how many are done.

    Raises:
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
    name: str, estimator: Any, log: Log, reference: Mapping[str, Any], learn_share: float = 0.5,
    seed: int = 0,
) -> Tuning:  # fmt: skip
    """What a log that is read already says of one estimator. Raises BadInput as `tune`."""
    setup, streams = log.setup, log.streams
    noises = noises_of(name, estimator, setup, streams)
    whole = innovations(name, estimator, setup, streams)
    learn_ns, rest_ns = _parts(name, whole, learn_share)
    part = _until(streams, int(learn_ns[-1]))

    def score(x: Array, seen: Any = part, edges_ns: Any = learn_ns) -> Array:
        other = tuned(name, estimator, moved(noises, x))
        return in_blocks(innovations(name, other, setup, seen), edges_ns)

    found = search(
        _kept(score), np.array([n.prior_sd for n in noises]), np.array([n.bound for n in noises]),
        seed,
    )  # fmt: skip

    def rest(x: Array) -> Array:
        return score(x, streams, rest_ns)

    before, after = in_blocks(whole, rest_ns), rest(found.x)
    n = np.histogram(whole["epoch_ns"], rest_ns)[0]
    gains = [held_out.density_gain(before, after, n)]
    if found.x.any():
        pair = {BEFORE: estimator, AFTER: tuned(name, estimator, moved(noises, found.x))}
        ahead = held_out.foretold(pair, setup, streams, int(rest_ns[0]))
        gains += [ahead] if ahead is not None else []
        gains += held_out.of_reference(pair, setup, streams, dict(reference), rest_ns)
    own = [float((after - rest(_without(found.x, k))).sum()) if found.x[k] else 0.0
           for k in range(len(noises))]  # fmt: skip
    return Tuning(
        estimator=name,
        values=tuple(_value(n, found, k, own[k]) for k, n in enumerate(noises)),
        gains=tuple(gains),
        starts=found.starts,
        learnt_s=_driven_s(_between(whole["epoch_ns"], learn_ns)),
        held_out_s=_driven_s(_between(whole["epoch_ns"], rest_ns)),
    )


def _parts(
    name: str, table: Mapping[str, Any], learn_share: float
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Edges of the blocks of both parts of a log, each block with as many innovations.

    Raises:
        BadInput: there are too few, or in too little time.
    """
    epoch_ns = np.sort(table["epoch_ns"])
    if not len(epoch_ns):
        raise BadInput(
            f"the log gives estimator '{name}' no innovations while driving above {MOVING_MPS:g} "
            "m/s; wheel speeds and GNSS speed are needed"
        )
    epoch_ns = epoch_ns[epoch_ns > epoch_ns[0] + round(SETTLE_S * 1e9)]
    middle = int(learn_share * len(epoch_ns))
    edges = []
    for what, part in (("to learn from", epoch_ns[:middle]), ("held out", epoch_ns[middle:])):
        if _driven_s(part) < LEAST_S or len(part) < LEAST_INNOVATIONS:
            raise BadInput(
                f"the part of the log {what} has {_driven_s(part):.0f} s of driving and "
                f"{len(part)} measurements of '{name}'; {LEAST_S:.0f} s and {LEAST_INNOVATIONS} "
                "are needed"
            )
        at = np.linspace(0, len(part) - 1, BLOCKS + 1).astype(np.int64)
        edges.append(part[at] + (at == len(part) - 1))
    return edges[0], edges[1]


def _driven_s(epoch_ns: NDArray[np.int64]) -> float:
    """Time of driving [s], from the epochs of innovations in order; gaps are left out."""
    step_s = np.diff(epoch_ns) * 1e-9
    return float(step_s[step_s < GAP_S].sum())


def _until(streams: Any, stop_ns: int) -> Any:
    """The samples that arrived before an instant."""
    from twin.streams import Streams

    return Streams({
        sensor: {k: v[: np.searchsorted(table["arrival_ns"], stop_ns)] for k, v in table.items()}
        for sensor, table in streams.tables.items()
    })  # fmt: skip


def _between(epoch_ns: NDArray[np.int64], edges_ns: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.sort(epoch_ns[(epoch_ns >= edges_ns[0]) & (epoch_ns < edges_ns[-1])])


def _kept(score: Callable[[Array], Array]) -> Callable[[Array], Array]:
    """The score, computed once for each point."""
    known: dict[bytes, Array] = {}

    def looked_up(x: Array) -> Array:
        key = np.asarray(x, np.float64).tobytes()
        if key not in known:
            known[key] = score(x)
        return known[key]

    return looked_up


def _without(x: Array, k: int) -> Array:
    return np.where(np.arange(len(x)) == k, 0.0, x)


def _value(noise: Noise, found: Found, k: int, gain: float) -> Value:
    by, sd = found.x[k], found.sd[k]
    at_bound = abs(by) > 0.99 * noise.bound
    why = "flat" if found.flat[k] else "no difference told"
    if by != 0.0:
        why = "tuned, at its bound" if at_bound else "tuned"
    low, high = (noise.before * math.exp(by + way * sd) for way in (-1.96, 1.96))
    return Value(
        name=noise.name, is_factor=noise.is_factor, grade=noise.grade, before=noise.before,
        value=noise.before * math.exp(by), low=low, high=high, why=why, gain=gain,
    )  # fmt: skip


def to_text(tunings: Mapping[str, Tuning], heading: str) -> str:
    """The file that `--tuning` takes."""
    lines = [f"# {line}" for line in heading.splitlines()] + [f"schema = {SCHEMA}"]
    for name, tuning in tunings.items():
        lines += ["", f"# {name}: {tuning.verdict} on the held-out {tuning.held_out_s:.0f} s"]
        for table in ("values", "factors"):
            lines.append(f"[{json.dumps(name)}.{table}]")
            for key, value in getattr(tuning.noises, table).items():
                lines.append(f"{json.dumps(key)} = {value:.6g}")
    return "\n".join(lines) + "\n"


def write(tunings: Mapping[str, Tuning], path: Path, heading: str) -> None:
    """Write it whole or not at all. Raises BadInput or NoSpace."""
    write_text(path, to_text(tunings, heading))
