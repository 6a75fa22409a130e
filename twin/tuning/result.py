"""What a log says of an estimator's noises, and the file that `--tuning` takes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from twin.io.atomic import write_text
from twin.pipeline.tuned import SCHEMA, Noises
from twin.tuning.held_out import Gain, verdict


@dataclass(frozen=True, kw_only=True)
class Value:
    """A noise before and after."""

    name: str
    """Field of the estimator, or factor on an sd of a sensor."""
    is_factor: bool
    grade: str
    before: float
    value: float
    """Value by the log; `before` where the log does not determine it, or agrees with it."""
    low: float
    high: float
    """95 % interval; NaN where there is none."""
    why: str
    """`tuned`, `tuned, at its bound`, `not confirmed` (on the held-out part), `no difference told`,
    or `flat`."""
    gain: float
    """Log density that this value alone gains on the held-out part."""


@dataclass(frozen=True, kw_only=True)
class Tuning:
    """Noises of an estimator by a log, and what they gain."""

    estimator: str
    values: tuple[Value, ...]
    gains: tuple[Gain, ...]
    """Gains of all values together on the held-out part."""
    starts: tuple[float, ...]
    """Log density that each search reached."""
    learnt_s: float
    """Time of driving from which was learnt [s]."""
    held_out_s: float
    """Time of driving that was held out [s]."""
    kept: str
    """Values that are kept after the held-out part: `all`, `sensors` or `nothing`."""

    @property
    def verdict(self) -> str:
        """Of what is kept, on the held-out part: `better`, `worse` or `no difference`."""
        return verdict(self.gains)

    @property
    def noises(self) -> Noises:
        """What `--tuning` takes."""
        told = [v for v in self.values if v.value != v.before]
        return Noises(
            values={v.name: v.value for v in told if not v.is_factor},
            factors={v.name: v.value for v in told if v.is_factor},
        )


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
