"""Layers 4 and 6: how far the light tractor slides along a cross-slope, beside print."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from twin.pipeline.named import load
from twin.reproduce.cross_slope import FREE_WITHIN, PUBLISHED_M, SET_WITHIN, drive
from twin.validate.check import Basis, Check, near

SEEDS = 8
SET, FREE = ((9, "dry"), (18, "dry"), (9, "wet")), (18, "wet")
LOOKED = (
    "driven again after the change of the side force under Bekker's law: 9 and 18 dry and 9 wet "
    "first, .330, .442 and .269 m, within what is allowed, so nothing was set anew; then 18 wet, "
    "once, .365 m, and nothing was set after it. Both soils act by Brixius' law, which the change "
    "left alone"
)


def slides_set() -> list[Check]:
    """The three slides by which the tyres' lateral ratios and the wet front grip were set."""
    why = "front and rear lateral ratio and the wet front grip were set by these: a fit"
    return [_slide(*cell, SET_WITHIN, why) for cell in SET]


def slide_left_out() -> list[Check]:
    """The fourth slide, by which nothing was set."""
    why = "twice what is allowed of the slides that were set"
    return [_slide(*FREE, FREE_WITHIN, why)]


def _slide(slope_deg: int, soil: str, within: float, why: str) -> Check:
    """Mean over the seeds of what a run without sensors slides, at its centre of gravity."""
    scenario = load("scenario", f"slope-{slope_deg}-{soil}")
    totals_m = [drive(replace(scenario, seed=s))["sideslip_m"][-1] for s in range(SEEDS)]
    return near(
        f"electric tractor, {slope_deg} deg, {soil}",
        "slide",
        np.abs(totals_m).mean(),
        "m",
        PUBLISHED_M[slope_deg, soil, False],
        relative=within,
        basis=Basis(
            source="Liu et al., Trans. CSAM 2023 54(S2): the paper's own estimate",
            why=why,
            grade="published",
            note=LOOKED,
        ),
    )
