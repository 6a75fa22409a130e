"""The road experiment of Zhang (2018): how much estimated slip scatters, by speed and surface.

The paper has no reference and no error figure: it says that slip stays within 6 % at about 5 km/h
and within 2 % at about 20 km/h on asphalt, and scatters more on gravel and grass. Both are one
speed error of about 0.1 m/s, so the tractor here carries an instrument with such an error: Hall
sensors read every 0.1 s.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from joblib import delayed

from twin.compute.parallel import many
from twin.io.result_rows import Row, Rows, row
from twin.pipeline.named import load
from twin.pipeline.run import run
from twin.scenario import Scenario
from twin.sensors import Gnss, Sensors, Wheels

SURFACES, SPEEDS_KMH = ("asphalt", "gravel", "grass"), (5, 7, 10, 20)
BOUNDS = {("asphalt", 5): (0.04, 0.08, 0.06), ("asphalt", 20): (0.010, 0.027, 0.02)}
"""Low, high, published half-width of the central 99 % of slip."""
START_S = 5.0
FITTED = Sensors(
    gnss=Gnss(rate_hz=10.0),
    imu=None,
    wheels=Wheels(rate_hz=10.0, lines=200, decoding=1),
    depth=None,
    machine=None,
)
"""A receiver and Hall sensors of 200 edges a turn, both at 10 Hz."""


def rows(trials: int = 4, jobs: int = 1) -> Rows:
    """One row per surface and speed: half-width of the central 99 % of slip, mean over seeds."""
    cases = [(s, v) for s in SURFACES for v in SPEEDS_KMH]
    seeds = [(s, v, seed) for s, v in cases for seed in range(trials)]
    widths = many((delayed(half_width)(*case) for case in seeds), jobs)
    found = {
        case: float(np.mean([w for w, c in zip(widths, seeds, strict=True) if c[:2] == case]))
        for case in cases
    }
    return [_row(case, found) for case in cases]


def _row(case: tuple[str, int], found: dict[tuple[str, int], float]) -> Row:
    surface, speed = case
    low, high, published = BOUNDS.get(case, (None, None, None))
    if surface != "asphalt":  # rougher roads scatter more
        low = found["asphalt", speed]
    return row(
        f"{surface}, {speed} km/h", "half-width of the central 99 % of slip", found[case], "1",
        low=low, high=high, published=published,
    )  # fmt: skip


def half_width(surface: str, speed_kmh: int, seed: int) -> float:
    """Half the distance between the 0.5 and 99.5 % quantiles of estimated slip in one run."""
    named: Scenario = load("scenario", f"road-{surface}-{speed_kmh}kmh")
    scenario = replace(named, seed=seed, sensors=FITTED)
    estimator = load("estimator", "four-state-printed")
    estimates = run(scenario, estimators={"printed": estimator}).estimates["printed"]
    late = estimates["epoch_ns"] >= START_S * 1e9
    slip = estimates["slip"][late]
    low, high = np.quantile(slip[np.isfinite(slip)], [0.005, 0.995])
    return 0.5 * float(high - low)
