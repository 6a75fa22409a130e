"""Slip control by speed and depth while subsoiling, against none (Luo et al. 2023).

Published: a New Holland T1404 with a power-shift gearbox, 130 s of subsoiling, slip above 20 % for
14.1 s with the control and for 18.9 s without, 25.4 % less. Field, subsoiler, depth and the law of
the controller are not known to us. Here a Taishan 1404A of about the same power draws three legs
at 30 cm through firm soil of medium texture, a fifth of it areas of some 8 m where the wheels grip
less. The grip of these areas and the soil's draft are assumed, with a look at how long the wheels
slip without control; what the control makes of it follows. The throttle sets the speed; the gear
stays.

Source: Luo et al. 2023, Agronomy 13(2):281, doi 10.3390/agronomy13020281; what of it is known here
is its abstract.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from joblib import delayed

from twin.compute.mean import mean
from twin.compute.parallel import many
from twin.control.controllers import PI, Array, Constant, Controller, Gain, Seen, slip_error
from twin.io.result_rows import Rows, row
from twin.machine.build import Machine
from twin.reproduce.controlled_pass import PERIOD_S, Worked, worked
from twin.reproduce.story import Story
from twin.scenario import Course, Field, Plough, Scenario, Soil

DURATION_S, LIMIT = 130.0, 0.20
WITHOUT_S, WITH_S = 18.9, 14.1
"""Published time above the limit in it [s]."""
FIELD = Scenario(
    name="speed-and-depth",
    implement="subsoiler_3",
    soil=Soil(preset="firm", draft_scale=0.60),
    field=Field(
        roughness_class="C",
        other_share=0.2,
        other_length_m=8.0,
        other_soil=Soil(preset="firm", friction=0.56, draft_scale=0.60),
    ),
    plough=Plough(depth_m=0.30),
    course=Course(length_m=260.0),
)
THROTTLE = 0.2
"""Throttle action without slip; assumed."""
TRIM_M = -0.10
"""Puts a depth of 0.30 m where the lever has it: its scale ends at the implement's greatest depth,
0.50 m, and that of the controllers at 0.35 m."""


@dataclass(frozen=True, kw_only=True)
class SpeedAndDepth(PI):
    """The PI on slip, which lifts the tool, and less throttle while the slip is above its target.

    throttle = base - k max(0, s - target). The form and the gains are ours.
    """

    slow: Gain = 3.0
    """k: throttle action per slip error."""

    def act(self, state: Array, seen: Seen, period_s: float) -> tuple[Array, Array]:
        """One period."""
        slower = self.throttle - self.slow * np.maximum(0.0, slip_error(seen))
        return PI.act(replace(self, throttle=np.maximum(-1.0, slower)), state, seen, period_s)


def without(machine: Machine) -> Controller:
    """Throttle and depth stay."""
    return Constant(throttle=THROTTLE, trim_m=TRIM_M)


def speed_and_depth(machine: Machine) -> Controller:
    """Both follow the slip above the target."""
    return SpeedAndDepth(throttle=THROTTLE, trim_m=TRIM_M, kp_m=0.5, ki_mps=0.1)


CONTROLS: dict[str, tuple[Callable[[Machine], Controller], float, float | None]] = {
    "without": (without, LIMIT, WITHOUT_S),
    "from 20 % slip": (speed_and_depth, LIMIT, WITH_S),
    "from 12 % slip": (speed_and_depth, 0.12, None),
}
"""What drives, the slip it is told to work at, and the published time above the limit [s]. At which
slip the trial's control begins is not known; 20 % is what its figures count from."""


def rows(trials: int = 16, jobs: int = 1) -> Rows:
    """All rows, over `trials` seeds of the field."""
    cases = [(name, seed) for name in CONTROLS for seed in range(trials)]
    found = dict(zip(cases, many((delayed(_driven)(*case) for case in cases), jobs), strict=True))
    both = {name: [found[name, seed] for seed in range(trials)] for name in CONTROLS}
    out: Rows = []
    for name, passes in both.items():
        above, published = mean(above_s(p) for p in passes), CONTROLS[name][2]
        out += [
            row(name, "time above 20 % slip in 130 s", above.mean, "s", published=published)
            | above.bounds,
            row(name, "mean slip", mean(p.slip.mean() for p in passes).mean, "1"),
            row(name, "mean depth", mean(p.depth_m.mean() for p in passes).mean, "m"),
            row(name, "capacity", mean(p.capacity_haph for p in passes).mean, "ha/h"),
            row(name, "fuel", mean(p.fuel_lpha for p in passes).mean, "L/ha"),
        ]
    before, after, earlier = (sum(above_s(p) for p in passes) for passes in both.values())
    for name, left, theirs in (
        ("from 20 % slip", after, 1.0 - WITH_S / WITHOUT_S), ("from 12 % slip", earlier, None)
    ):  # fmt: skip
        less = 1.0 - left / max(before, PERIOD_S)
        out.append(row(name, "less time above 20 % slip", less, "1", published=theirs))
    return out


def above_s(done: Worked) -> float:
    """Time above the limit [s]."""
    return float(np.count_nonzero(done.slip > LIMIT)) * PERIOD_S


def _driven(control: str, seed: int) -> Worked:
    driver, slip_target, _ = CONTROLS[control]
    return worked(replace(FIELD, seed=seed), driver, slip_target).first(DURATION_S)


def said(rows: Rows) -> Story:
    """What differs from the trial."""
    return Story(
        paragraphs=(
            "What differs: field, subsoiler, depth and law of control of the trial are not known "
            "to us. Ours is a Taishan 1404A with three legs at 0.30 m on soil with areas of less "
            "grip, and a law of the same purpose; it sets the speed by the throttle and shifts no "
            "gear.",
            "How long slip stays above 20 % without control follows from the assumed areas.",
        )
    )
