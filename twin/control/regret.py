"""How much of what an oracle gains over the PI a controller gets, by the difficulty of the ground.

share = mean(reward - PI's) / mean(oracle's - PI's)          regret = 1 - share
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from twin.compute.mean import Mean, mean
from twin.env.grounds import Options
from twin.io.result_rows import Row, Rows, row

Array = NDArray[np.float64]

HEADROOM = "headroom: oracle less pi, paired"
SHARE = "share of the headroom"
ALL = "all"


def patchy(ground: Options) -> str:
    """Plough-v1: by the patches of weaker soil among the two soils."""
    return ("no patch", "one patch", "two patches")[min(2, len(ground["field.patches"]))]


def steep(ground: Options) -> str:
    """WheelSlip-v1: by the cross slope."""
    degrees = abs(ground["field.cross_slope_deg"])
    return "below 5 deg" if degrees < 5.0 else "5 to 10 deg" if degrees < 10.0 else "above 10 deg"


TIERS: dict[str, Callable[[Options], str]] = {"Plough-v1": patchy, "WheelSlip-v1": steep}
"""Tier of difficulty of a ground, by environment."""


def share(gained: Array, headroom: Array) -> Mean:
    """Share of the headroom gained, with its paired interval.

        q = mean(gained) / mean(headroom)        se(q) = se(gained - q headroom) / mean(headroom)

    Args:
        gained: reward less the PI's on each ground.
        headroom: the oracle's less the PI's on the same grounds.

    Source of the interval: the ratio estimator's, Cochran 1977, Sampling Techniques, section 6.
    """
    whole = float(headroom.mean())
    ratio = float(gained.mean()) / whole
    half = mean(gained - ratio * headroom).half / abs(whole)
    return Mean(ratio, ratio - half, ratio + half, len(gained))


def regret_rows(rewards: Mapping[str, Array], tiers: NDArray[np.str_]) -> Rows:
    """The headroom, and each controller's share of it, over all grounds and by tier.

    Args:
        rewards: by controller, "pi" and "oracle" among them; others get rows.
        tiers: the name of each ground's tier.
    """
    out = []
    for tier in (ALL, *dict.fromkeys(np.sort(tiers).tolist())):
        here = np.ones(len(tiers), dtype=np.bool_) if tier == ALL else tiers == tier
        if here.sum() < 2:
            continue
        headroom = (rewards["oracle"] - rewards["pi"])[here]
        out.append(_row("oracle", f"{HEADROOM} ({tier}, {here.sum()})", mean(headroom)))
        for name, values in rewards.items():
            if name not in ("pi", "oracle"):
                gained = (values - rewards["pi"])[here]
                found = share(gained, headroom)
                out.append(_row(name, f"{SHARE} ({tier}, {here.sum()})", found))
    return out


def _row(case: str, quantity: str, found: Mean) -> Row:
    return dict(row(case, quantity, found.mean, "1")) | found.bounds
