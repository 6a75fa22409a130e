"""Zero-slip scale, lag of the GNSS speed and slip of steady work, computed from a log."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.lag import Lag, gnss_lag
from estimators.zero_slip import Scale, bootstrap_medians, zero_slip_scale
from twin.errors import BadInput
from twin.logs import Log, Rule, choose, driven_speed_mps, ground_speed_mps, paired_speeds
from twin.streams import Streams, Table

_WHEEL_SPEEDS = ("speed_fl_mps", "speed_fr_mps", "speed_rl_mps", "speed_rr_mps", "speed_sd_mps")


@dataclass(frozen=True, kw_only=True)
class SteadySlip:
    """Slip of steady work, s = (wR - v) / max(wR, v) with wR = scale x wheel speed."""

    median: float
    low: float
    """2.5 % end; holds the scale's own uncertainty."""
    high: float
    """97.5 % end."""
    n: int
    """Rows of steady work."""
    scale: Scale
    lag: Lag
    rule: str
    """Rule that chose the rows, in words."""

    @property
    def lag_s(self) -> float:
        """Lag of the GNSS speed behind the wheel speed [s]."""
        return self.lag.lag_s


def log_scale(log: Log, *, seed: int = 0) -> Scale:
    """Zero-slip scale [-] from the rows that the rule [zero_slip] of the map chooses.

    Args:
        log: the recorded drive.
        seed: random seed of the bootstrap.

    Raises:
        BadInput: the map has no such rule, or the rule chooses no row.
    """
    rule = _rule(log, "zero_slip")
    ground, wheel, chosen = _chosen(log, rule)
    scale = zero_slip_scale(ground, wheel, chosen, rule=str(rule), seed=seed)
    if not scale.n:
        raise BadInput(f"no row of the log is chosen by [zero_slip]: {rule}; widen the rule")
    return scale


def log_lag(log: Log, *, seed: int = 0) -> Lag:
    """Lag of the GNSS speed behind the wheel speed, over the whole log.

    Raises:
        BadInput: the log has no GNSS speed or no wheel speed.
    """
    if "gnss" not in log.streams or "wheels" not in log.streams:
        raise BadInput("the log has no gnss and wheels to compare; map speeds of both")
    gnss, wheels = log.streams["gnss"], log.streams["wheels"]
    ground, wheel = ground_speed_mps(log.streams), driven_speed_mps(log.streams)
    return gnss_lag(gnss["epoch_ns"], ground, wheels["epoch_ns"], wheel, seed=seed)


def steady_slip(log: Log, *, seed: int = 0) -> SteadySlip:
    """Median slip over the rows of the map's [steady] rule, and its 95 % interval.

    s = 1 - q / k for q < k,  k / q - 1 otherwise;  q = v / wheel speed

    s: slip [-]. v: GNSS speed [m/s]. k: zero-slip scale [-]. Slip decreases with q, so the median q
    gives the median slip. Each bootstrap replicate of the slip uses one replicate of the median q
    and one of k. The lag does not shift the speeds, because the speeds are steady.

    Raises:
        BadInput: the log has no such rule, or the rule chooses no row.
    """
    scale, rule = log_scale(log, seed=seed), _rule(log, "steady")
    ratios = _ratios(log, rule)
    if not len(ratios):
        raise BadInput(f"no row of the log is chosen by [steady]: {rule}; widen the rule")
    medians = bootstrap_medians(ratios, seed=seed + 1)
    scales = bootstrap_medians(_ratios(log, _rule(log, "zero_slip")), seed=seed)
    low, high = np.quantile(slip_from_ratio(medians / scales), (0.025, 0.975))
    median = float(slip_from_ratio(np.median(ratios) / scale.scale))
    return SteadySlip(
        median=median, low=float(low), high=float(high), n=len(ratios),
        scale=scale, lag=log_lag(log, seed=seed), rule=str(rule),
    )  # fmt: skip


def slip_from_ratio(ratio: Any) -> NDArray[np.float64]:
    """Slip s = (wR - v) / max(wR, v) [-] from the ratio v / wR of ground and wheel speed [-]."""
    return np.asarray((1.0 - ratio) / np.maximum(1.0, ratio))


def scaled(log: Log, scale: float) -> Log:
    """Log with wheel speeds multiplied by `scale` [-], which gives the theoretical speed w R."""
    wheels: Table = {
        k: v * scale if k in _WHEEL_SPEEDS else v for k, v in log.streams["wheels"].items()
    }
    note = f"wheels: speeds multiplied by the zero-slip scale {scale:.4f}"
    return replace(
        log, streams=Streams({**log.streams.tables, "wheels": wheels}), notes=(*log.notes, note)
    )


def _rule(log: Log, name: str) -> Rule:
    if name not in log.rules:
        raise BadInput(f"the column map has no [{name}] rule; say which rows count")
    return log.rules[name]


def _chosen(log: Log, rule: Rule) -> tuple[NDArray[Any], NDArray[Any], NDArray[np.bool_]]:
    ground, wheel = paired_speeds(log.streams)
    if not len(wheel):
        raise BadInput("the log has no gnss and wheels to compare; map speeds of both")
    return ground, wheel, choose(rule, log.rows, log.streams["wheels"]["epoch_ns"], wheel)


def _ratios(log: Log, rule: Rule) -> NDArray[Any]:
    """GNSS speed / wheel speed of the rows of a rule where both were measured."""
    ground, wheel, chosen = _chosen(log, rule)
    both = chosen & np.isfinite(ground) & (wheel > 0.0)
    return np.asarray(ground[both] / wheel[both])
