"""What a real log says of itself: its zero-slip scale, the GNSS lag and the slip of steady work."""

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
    """How the rows were chosen, in words."""

    @property
    def lag_s(self) -> float:
        """Lag of GNSS speed behind wheel speed."""
        return self.lag.lag_s


def log_scale(log: Log, *, seed: int = 0) -> Scale:
    """The zero-slip scale from the rows of the map's [zero_slip] rule; BadInput without any."""
    rule = _rule(log, "zero_slip")
    ground, wheel, chosen = _chosen(log, rule)
    scale = zero_slip_scale(ground, wheel, chosen, rule=str(rule), seed=seed)
    if not scale.n:
        raise BadInput(f"no row of the log is chosen by [zero_slip]: {rule}; widen the rule")
    return scale


def log_lag(log: Log, *, seed: int = 0) -> Lag:
    """Delay of GNSS speed behind wheel speed over the whole log.

    Raises:
        BadInput: the log has no speed of one of them.
    """
    if "gnss" not in log.streams or "wheels" not in log.streams:
        raise BadInput("the log has no gnss and wheels to compare; map speeds of both")
    gnss, wheels = log.streams["gnss"], log.streams["wheels"]
    ground, wheel = ground_speed_mps(log.streams), driven_speed_mps(log.streams)
    return gnss_lag(gnss["epoch_ns"], ground, wheels["epoch_ns"], wheel, seed=seed)


def steady_slip(log: Log, *, seed: int = 0) -> SteadySlip:
    """Median slip over the rows of the map's [steady] rule, and its 95 % interval.

    s = 1 - q / k for q < k, k / q - 1 otherwise;  q = v / wheel speed, k the scale

    Slip falls with q everywhere, so the median q gives the median slip, and bootstrap replicates of
    the two medians pair off into replicates of slip. Speeds are not shifted by the lag: in steady
    work it changes next to nothing.

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
    """Slip from v / wR: s = (wR - v) / max(wR, v)."""
    return np.asarray((1.0 - ratio) / np.maximum(1.0, ratio))


def scaled(log: Log, scale: float) -> Log:
    """The log with its wheel speeds times `scale`, so that they are the theoretical speed w R."""
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
