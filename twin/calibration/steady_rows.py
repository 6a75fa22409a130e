"""Rows of steady driving from a log: means over five seconds, by a stated rule."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.logs import Log, choose
from twin.logs.activity import EMPTY, WORKING, activity
from twin.logs.timeline import brought
from twin.streams import Table

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

ROW = 5
"""Rows of a second in a mean."""
LEAST_MPS, STEADY_MPS2, STRAIGHT_RAD, LEAST_RPM = 0.7, 0.04, math.radians(3.0), 600.0
FEWEST = 12
"""Rows of steady work, at least."""
RULE = (
    f"Rows are means over {ROW} s of steady work: the wheels faster than {LEAST_MPS:g} m/s, their "
    f"speed changing by less than {STEADY_MPS2:g} m/s a second, the heading within "
    f"{math.degrees(STRAIGHT_RAD):.0f} degrees, the engine above {LEAST_RPM:.0f} rpm."
)


@dataclass(frozen=True)
class SteadyRows:
    """Means of steady driving. Shapes (n,)."""

    time_s: Array
    """Start of each, since the start of the log."""
    speed_mps: Array
    """Ground speed; NaN where it was not measured."""
    wheel_mps: Array
    """As the log has it."""
    engine_radps: Array
    torque: Array
    """Engine torque over the reference torque, or what replaces it."""
    force: Array
    """Mean of torque times engine speed over wheel speed [N over the reference torque in N m]."""
    fuel_lph: Array
    """NaN without a measurement."""

    def __len__(self) -> int:
        return len(self.time_s)

    def chosen(self, rows: Mask) -> SteadyRows:
        """Some of them."""
        return SteadyRows(**{name: getattr(self, name)[rows] for name in self.__dataclass_fields__})

    @property
    def ratio(self) -> Array:
        """Ground over wheel speed."""
        return np.asarray(self.speed_mps / self.wheel_mps)


def steady_rows(
    log: Log, rows: Table, torque: Array, steady_mps2: float = STEADY_MPS2
) -> SteadyRows:
    """The rows of steady work of a log.

    Args:
        log: for its headings and its labels of rows.
        rows: the log in seconds.
        torque: engine torque over its reference, of each second.
        steady_mps2: change of the wheels' speed a second below which work is steady.

    Raises:
        BadInput: fewer than 12 rows of steady work.
    """
    working, _ = doing(log, rows)
    heading = _heading(log, rows)
    time_s = (rows["epoch_ns"] - rows["epoch_ns"][0]) * 1e-9
    ground, wheel, engine = rows["speed_mps"], rows["wheel_speed_mps"], rows["engine_radps"]
    fuel = rows.get("fuel_lph", np.full(len(wheel), np.nan))
    found = []
    for first in range(0, len(wheel) - ROW, ROW):
        part = slice(first, first + ROW)
        if not working[part].all() or time_s[first + ROW - 1] - time_s[first] > ROW - 0.5:
            continue
        change = np.abs(np.diff(wheel[part])).max()
        turned = heading[part] - heading[first]
        if (
            change < steady_mps2
            and wheel[part].min() > LEAST_MPS
            and engine[part].min() * 30.0 / math.pi > LEAST_RPM
            and not np.abs(turned).max() >= STRAIGHT_RAD
            and np.isfinite(torque[part]).all()
        ):
            force = np.mean(torque[part] * engine[part] / wheel[part])
            found.append((time_s[first], ground[part].mean(), wheel[part].mean(),
                          engine[part].mean(), torque[part].mean(), force,
                          fuel[part].mean()))  # fmt: skip
    columns = np.array(found, np.float64).reshape(-1, 7).T
    out = SteadyRows(*columns)
    if (count := len(out)) < FEWEST:
        raise BadInput(
            f"the log has {count} rows of {ROW} s of steady work; {FEWEST} would do: straight "
            f"driving under load at a wheel speed that changes by less than {STEADY_MPS2:g} m/s a "
            "second"
        )
    return out


def doing(log: Log, rows: Table) -> tuple[Mask, Mask]:
    """Seconds of work, and of driving empty: by the map's labels, or else by `activity`."""
    told = activity(rows)
    masks = []
    for name, code in (("steady", WORKING), ("zero_slip", EMPTY)):
        rule = log.rules.get(name)
        if rule is None or not rule.where or log.rows is None:
            masks.append(told[code])
            continue
        epoch_ns = log.streams["wheels"]["epoch_ns"]
        labelled = choose(replace(rule, min_speed_kmh=-1.0, max_speed_kmh=math.inf,
                                  max_speed_change_kmhps=math.inf), log.rows, epoch_ns,
                          np.zeros(len(epoch_ns)))  # fmt: skip
        share = brought(epoch_ns, labelled.astype(np.float64), rows["epoch_ns"])
        masks.append(np.asarray(share > 0.99))
    return masks[0], masks[1]


def _heading(log: Log, rows: Table) -> Array:
    """Heading of each second without jumps; 0 where the log has none."""
    heading = log.streams.column("gnss", "heading_rad")
    known = np.isfinite(heading)
    if known.sum() < 2:
        return np.zeros(len(rows["epoch_ns"]))
    epoch_ns = log.streams["gnss"]["epoch_ns"][known]
    found = brought(epoch_ns, np.unwrap(heading[known]), rows["epoch_ns"])
    return np.nan_to_num(found)
