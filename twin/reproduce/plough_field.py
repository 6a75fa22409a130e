"""The field experiment of Fu et al. (INMATEH 77-13): four depths at one throttle setting.

Of what was measured the paper publishes the mean speeds alone. Slip and draft, and how much both
vary, are assumed: one set that agrees with these speeds. Speed and draft determine slip to about
+-30 % (5 to 95 %).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from joblib import delayed

from scenarios import plough
from twin.compute.parallel import many
from twin.io.result_rows import Row, Rows, row
from twin.reproduce.passes import Pass, drive
from twin.scenario import Course, Scenario

DEPTHS_CM = (15, 20, 25, 30)
SCENARIOS: dict[int, Scenario] = {
    15: plough.CM_15, 20: plough.CM_20, 25: plough.CM_25, 30: plough.CM_30,
}  # fmt: skip
SPEEDS_KMH = {15: 6.48, 20: 5.83, 25: 5.44, 30: 5.04}
FUEL_LPHA = (15.0, 27.0)
"""Fuel of mouldboard ploughs at 10 to 30 cm and 4 to 7 km/h behind other tractors."""
SLIPS = {15: (0.056, 0.087), 20: (0.074, 0.121), 25: (0.097, 0.165), 30: (0.123, 0.233)}
"""5 to 95 % of the slip that draft and traction laws allow at the published speeds."""


def rows(trials: int = 16, jobs: int = 1) -> Rows:
    """All rows, over `trials` seeds."""
    passes = {cm: _drive_all(SCENARIOS[cm], trials, jobs) for cm in DEPTHS_CM}
    out: Rows = []
    for cm in DEPTHS_CM:
        out += _depth_rows(cm, passes[cm])
    growth = _mean(passes[30], "slip_sd") / _mean(passes[15], "slip_sd")
    out.append(row("15 to 30 cm", "growth of slip sd", growth, "1", low=3.0))
    return out + _prediction_rows(passes, trials, jobs) + [_even_soil_row(), *_step_rows()]


def _drive_all(scenario: Scenario, trials: int, jobs: int) -> list[Pass]:
    seeds = [replace(scenario, seed=seed) for seed in range(trials)]
    return many((delayed(drive)(s) for s in seeds), jobs)


def _mean(passes: list[Pass], quantity: str) -> float:
    return float(np.mean([getattr(p, quantity) for p in passes]))


def _depth_rows(cm: int, passes: list[Pass]) -> Rows:
    case, speed = f"{cm} cm", SPEEDS_KMH[cm]
    course_m = SCENARIOS[cm].course.length_m
    stalled = sum(p.length_m < 0.95 * course_m - 10.0 for p in passes)
    roll_error = max(abs(p.roll_deg - p.roll_expected_deg) for p in passes)
    closure = max(abs(p.power_closure) for p in passes)
    low, high = SLIPS[cm]
    return [
        row(case, "mean speed", _mean(passes, "speed_kmh"), "km/h",
             low=0.975 * speed, high=1.025 * speed, published=speed),
        row(case, "runs stalled", float(stalled), "1", high=0.0),
        row(case, "mean slip", _mean(passes, "slip"), "1", low=low, high=high),
        row(case, "slip sd", _mean(passes, "slip_sd"), "1"),
        row(case, "mean draft", 1e-3 * _mean(passes, "draft_n"), "kN"),
        row(case, "draft CV", _mean(passes, "draft_cv"), "1", low=0.08, high=0.13),
        row(case, "draft correlation length", _mean(passes, "draft_length_m"), "m",
             low=2.0, high=5.0),
        row(case, "fuel", _mean(passes, "fuel_lpha"), "L/ha",
             low=FUEL_LPHA[0], high=FUEL_LPHA[1]),
        row(case, "roll", _mean(passes, "roll_deg"), "deg",
             reference=_mean(passes, "roll_expected_deg")),
        row(case, "largest roll error", roll_error, "deg", high=0.3),
        row(case, "largest power imbalance over engine work", closure, "1", high=0.01),
    ]  # fmt: skip


def _prediction_rows(passes: dict[int, list[Pass]], trials: int, jobs: int) -> Rows:
    """The throttle set by three depths; the speed at the fourth, simulated with it.

    Only the throttle is fitted. The published speeds scatter by about 1.6 % about any smooth law; a
    second parameter, such as the draft, follows that scatter and stalls the tractor at 30 cm.
    """
    speeds = {cm: _mean(passes[cm], "speed_kmh") for cm in DEPTHS_CM}
    out = []
    for cm in DEPTHS_CM:
        ratio = np.mean([SPEEDS_KMH[other] / speeds[other] for other in DEPTHS_CM if other != cm])
        set_rpm = SCENARIOS[cm].gear.set_rpm * float(ratio)
        fitted = replace(SCENARIOS[cm], drive=replace(SCENARIOS[cm].drive, engine_set_rpm=set_rpm))
        speed = _mean(_drive_all(fitted, trials, jobs), "speed_kmh")
        published = SPEEDS_KMH[cm]
        out.append(
            row(f"{cm} cm", "speed predicted from the other depths", speed, "km/h",
                low=0.96 * published, high=1.04 * published, published=published)
        )  # fmt: skip
    return out


def _even_soil_row() -> Row:
    """Implement force against D497 where the soil does not vary."""
    even = replace(plough.CM_25.soil, draft_cv=0.0, ripple_cv=0.0, strength_cv=0.0)
    scenario = replace(plough.CM_25, soil=even, course=Course(length_m=60.0))
    ratio = drive(scenario).draft_over_d497
    return row("25 cm, even soil", "implement force over D497", ratio, "1", low=0.99, high=1.01)


def _step_rows() -> Rows:
    """Mean slip at half the time step."""
    scenario = replace(plough.CM_25, course=Course(length_m=60.0))
    full, half = (drive(replace(scenario, timestep_s=dt_s)).slip for dt_s in (0.002, 0.001))
    change = abs(half / full - 1.0)
    return [
        row("25 cm, half the time step", "relative change of mean slip", change, "1", high=0.01)
    ]
