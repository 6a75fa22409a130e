"""The 100 disturbed trials of the IMA-PKF paper (INMATEH 77-13).

Five disturbances a trial. "Half-sine" of 4.5-5.5 Hz that lasts 0.2 s is either one lobe or a whole
cycle; it is "superimposed onto the actual vehicle speed" but shown on the GNSS speed. All readings
are tabulated. Where the ground truly moves, a filter that leaves the disturbance out is wrong.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from scenarios.ima_pkf import Trial
from twin.io.result_rows import Rows
from twin.reproduce.ima_pkf import FIRST_SEED, floor
from twin.reproduce.ima_pkf_methods import adaptive, beside
from twin.reproduce.ima_pkf_rows import leads, measured, promises
from twin.reproduce.ima_pkf_trials import study

PUBLISHED = {
    "KF": {"MAE": 0.0723, "RMSE": 0.0795, "max": 0.6262},
    "PSO-PKF": {"MAE": 0.0721, "RMSE": 0.0865, "max": 0.3977},
    "MA-PKF": {"MAE": 0.0438, "RMSE": 0.0589, "max": 0.2701},
    "IMA-PKF": {"MAE": 0.0282, "RMSE": 0.0359, "max": 0.1464},
}
FAITHFUL = ("lobe", "gnss")
"""One lobe, as "half-sine" says, on the GNSS speed, as the paper's Fig. 6 shows."""
FORMS: tuple[tuple[Any, Any], ...] = (
    FAITHFUL, ("lobe", "speeds"), ("lobe", "truth"),
    ("cycle", "gnss"), ("cycle", "speeds"), ("cycle", "truth"),
)  # fmt: skip
UNDISTURBED = {"quantity": "RMSE, closed-form floor had there been no disturbance"}
PLACES = {
    "gnss": "on the GNSS speed", "speeds": "on both ground speeds", "truth": "the ground moves",
}  # fmt: skip


def rows(trials: int = 100, jobs: int = 1) -> Rows:
    """All rows, over `trials` seeds; low and high of a measured figure are its 95 % interval."""
    seeds = range(FIRST_SEED, FIRST_SEED + trials)
    estimators = beside(biased=False) | adaptive()
    out: Rows = []
    for form in FORMS:
        disturbance, disturbed = form
        cases = [Trial(seed=s, disturbance=disturbance, disturbed=disturbed) for s in seeds]
        found = study(cases, estimators, jobs)
        case = f"{disturbance}, {PLACES[disturbed]}"
        out += measured(case, found, PUBLISHED if form == FAITHFUL else {})
        out.append(floor(case, [replace(c, disturbance="none") for c in cases]) | UNDISTURBED)
        out += leads(case, found)
        if form == FAITHFUL:
            out += promises(case, found, PUBLISHED["IMA-PKF"]["RMSE"])
    return out
