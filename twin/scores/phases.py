"""Which samples are scored, and by what was driven there: work, turn or road."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.streams import Table
from twin.trajectory.phase import Phase

Array = NDArray[np.float64]

SCORED = {"work": Phase.WORK, "turn": Phase.TURN, "road": Phase.ROAD}
"""Phases that are scored apart, by name; a stop is none of them."""
DRIVING_MPS = 0.3
"""A slip is scored where the ground or the wheels are at least so fast [m/s]: below it the noise of
a receiver, 0.03 m/s, alone makes 10 points of slip."""
TURN_RADIUS_M = 25.0
"""A narrower curve is a turn [m], as in `twin.logs.activity`."""
LOWERED_SHARE, LOWERED_M = 0.5, 0.03
"""Above this share of its greatest depth, and this depth [m], an implement works."""


@dataclass(frozen=True)
class Phases:
    """Phases of a drive: a phase code from each epoch on."""

    epoch_ns: NDArray[np.int64]
    """Shape (n,), ascending."""
    code: NDArray[np.int64]
    """A Phase from that instant on. Shape (n,)."""
    rule: str
    """The rule that found the phases, in words."""

    def at(self, epoch_ns: NDArray[np.int64]) -> NDArray[np.int64]:
        """Phase codes at the epochs `epoch_ns` [ns]; before the first row, the first code."""
        before = np.searchsorted(self.epoch_ns, epoch_ns, side="right") - 1
        return np.asarray(self.code[np.maximum(before, 0)])


def phases(truth: Table) -> Phases | None:
    """Phases from the column `phase` of the truth, else from a rule; None without a speed.

    Stop: speed below 0.3 m/s. Work: depth greater than 3 cm and than half of the greatest depth.
    Turn: no work, and a curve radius below 25 m, that is |yaw rate| 25 m > |v|. Road: all else.

    Args:
        truth: table with `epoch_ns` [ns] and, if known, `phase`, `speed_mps` (v [m/s]), `depth_m`
            [m] and `yaw_rate_radps` [rad/s].
    """
    if not len(truth["epoch_ns"]):
        return None
    if "phase" in truth:
        return Phases(truth["epoch_ns"], truth["phase"], "phases are the driver's own")
    if "speed_mps" not in truth:
        return None
    nothing = np.zeros(len(truth["epoch_ns"]))
    depth, turned = truth.get("depth_m", nothing), truth.get("yaw_rate_radps", nothing)
    with np.errstate(invalid="ignore"):
        deepest = float(np.nanmax(depth)) if np.isfinite(depth).any() else 0.0
        works = depth > max(LOWERED_SHARE * deepest, LOWERED_M)
        turns = np.abs(turned) * TURN_RADIUS_M > np.abs(truth["speed_mps"])
        drives = speed_mps(truth) >= DRIVING_MPS
    code = np.select([~drives, works, turns], [Phase.STOP, Phase.WORK, Phase.TURN], Phase.ROAD)
    rule = (
        f"work is deeper than half of the greatest depth and than {100 * LOWERED_M:g} cm; turn is a"
        f" curve narrower than {TURN_RADIUS_M:g} m; stop is slower than {DRIVING_MPS:g} m/s; all"
        " else is road"
    )
    return Phases(truth["epoch_ns"], code.astype(np.int64), rule)


def speed_mps(truth: Table) -> Array:
    """Greater of |ground speed| and |wheel speed| [m/s]; NaN if both are unknown. Shape (n,)."""
    unknown = np.full(len(truth["epoch_ns"]), np.nan)
    both = (np.abs(truth.get(name, unknown)) for name in ("speed_mps", "wheel_speed_mps"))
    fastest: Array = np.fmax(*both)
    return fastest
