"""Slip-and-draft against draft control of a two-wheel-drive tractor that ploughs (Roul et al.).

Published: slip of 15 to 24 % under the new control and of 12 to 48 % under draft control, 11.2 %
less fuel per hectare, 3.4 to 14.5 % more field capacity, at initial depths of 150, 180 and 220 mm.
The tractor, plough and soil of the trial are not known to us, nor is the law of its controller.
Here a Massey Ferguson 275 draws three bodies over tilled soil, two fifths of it areas of some 12 m
where the wheels grip less. The size and grip of these areas are assumed, with a look at how much
draft control slips on them; what the other control makes of it follows.

Source: Roul et al., J. Sci. Ind. Res., op.niscair.res.in 52444; what of it is known here is its
text page.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from joblib import delayed

from twin.compute.mean import mean
from twin.compute.parallel import many
from twin.control.controllers import Array, Controller, Gain, Seen
from twin.control.draft_mix import DraftMix, MixState
from twin.io.result_rows import Row, Rows, row
from twin.machine.build import Machine
from twin.reproduce.controlled_pass import Worked, worked
from twin.reproduce.story import Story
from twin.scenario import Course, Field, Plough, Scenario, Soil

DEPTHS_MM = (150, 180, 220)
SLIPS = {"draft": (0.12, 0.48), "slip and draft": (0.15, 0.24)}
"""Published least and most slip."""
FUEL_SAVED, MORE_CAPACITY = 0.112, (0.034, 0.145)
FIELD = Scenario(
    name="slip-and-draft",
    machine="mf_275",
    implement="plough_3",
    soil=Soil(preset="tilled"),
    field=Field(
        roughness_class="C",
        other_share=0.4,
        other_length_m=12.0,
        other_soil=Soil(preset="tilled", friction=0.54),
    ),
    plough=Plough(hitch="draft"),
    course=Course(length_m=80.0),
)
THROTTLE = 0.3
"""Throttle action: three quarters of the governor's range; assumed."""
SENSITIVITY_M = 0.08
"""How far the hitch moves for a draft of twice what is held; assumed."""
LEAST_SHARE = 0.3
"""Of the lever's draft, what slip leaves at least; assumed."""


class SlipDraftState(NamedTuple):
    """What the hitch remembers of each tractor (count,)."""

    valve: MixState
    share: Array
    """Draft held over that of the lever."""


@dataclass(frozen=True, kw_only=True)
class SlipAndDraft:
    """Draft control, of which slip lowers the draft that is held.

        d ln q/dt = -k (s - nearest of [least, most])        D_0 = q D_lever, q <= 1

    Slip within its band leaves the draft alone; above it the plough is lifted, and below it the
    lever's draft comes back. The band is the published target; the form and k are ours.
    """

    valve: DraftMix
    rate_ps: Gain = 6.0
    """k [1/s]."""
    least: Gain = 0.15
    most: Gain = 0.20

    def init(self, count: int) -> SlipDraftState:
        """At the lever's depth and draft."""
        return SlipDraftState(self.valve.init(count), np.ones(count))

    def act(
        self, state: SlipDraftState, seen: Seen, period_s: float
    ) -> tuple[SlipDraftState, Array]:
        """One period."""
        off = seen["slip"] - np.clip(seen["slip"], self.least, self.most)
        share = np.clip(state.share * np.exp(-self.rate_ps * off * period_s), LEAST_SHARE, 1.0)
        held = replace(self.valve, held_n=self.valve.held_n * share)
        valve, levers = held.act(state.valve, seen, period_s)
        return SlipDraftState(valve, share), levers


def draft_control(machine: Machine) -> DraftMix:
    """Draft alone, held at what the machine's lever stands for."""
    if machine.setting is None:
        raise ValueError(f"{machine.scenario.name} has no plough set")
    return DraftMix(
        throttle=THROTTLE,
        trim_m=0.0,
        mix=1.0,
        held_n=machine.setting.draft_n,
        sensitivity_m=SENSITIVITY_M,
    )


def slip_and_draft_control(machine: Machine) -> Controller:
    """The same draft, with slip in its band."""
    return SlipAndDraft(valve=draft_control(machine))


CONTROLS = {"draft": draft_control, "slip and draft": slip_and_draft_control}


def rows(trials: int = 16, jobs: int = 1) -> Rows:
    """All rows, over `trials` seeds of the field."""
    cases = [(mm, name, seed) for mm in DEPTHS_MM for name in CONTROLS for seed in range(trials)]
    found = dict(zip(cases, many((delayed(_driven)(*case) for case in cases), jobs), strict=True))
    out: Rows = []
    for mm in DEPTHS_MM:
        both = {name: [found[mm, name, seed] for seed in range(trials)] for name in CONTROLS}
        out += _depth_rows(f"{mm} mm", both)
    every = {
        name: [found[mm, name, seed] for mm in DEPTHS_MM for seed in range(trials)]
        for name in CONTROLS
    }
    return out + _slip_rows("all depths", every, published=True) + _gains("all depths", every)


def _driven(depth_mm: int, control: str, seed: int) -> Worked:
    set_to = replace(FIELD.plough or Plough(), depth_m=1e-3 * depth_mm)
    return worked(replace(FIELD, plough=set_to, seed=seed), CONTROLS[control])


def _depth_rows(case: str, both: dict[str, list[Worked]]) -> Rows:
    out = _slip_rows(case, both)
    for name, passes in both.items():
        out += [
            row(case, f"depth, {name}", mean(p.depth_m.mean() for p in passes).mean, "m"),
            row(case, f"fuel, {name}", mean(p.fuel_lpha for p in passes).mean, "L/ha"),
            row(case, f"capacity, {name}", mean(p.capacity_haph for p in passes).mean, "ha/h"),
        ]
    return out + _gains(case, both)


def _slip_rows(case: str, both: dict[str, list[Worked]], *, published: bool = False) -> Rows:
    """5 and 95 % of the mean slips of single seconds."""
    out: Rows = []
    for name, passes in both.items():
        ends = np.quantile(np.concatenate([p.seconds_slip for p in passes]), [0.05, 0.95])
        for share, end, theirs in zip(("5 %", "95 %"), ends, SLIPS[name], strict=True):
            out.append(
                row(case, f"slip of {share} of the seconds, {name}", float(end), "1",
                    published=theirs if published else None)
            )  # fmt: skip
    return out


def _gains(case: str, both: dict[str, list[Worked]]) -> list[Row]:
    """What slip-and-draft control changes, paired by field."""
    pairs = list(zip(both["draft"], both["slip and draft"], strict=True))
    saved = mean(1.0 - ours.fuel_lpha / before.fuel_lpha for before, ours in pairs)
    more = mean(ours.capacity_haph / before.capacity_haph - 1.0 for before, ours in pairs)
    middle = 0.5 * sum(MORE_CAPACITY)
    return [
        row(case, "fuel per area saved", saved.mean, "1", published=FUEL_SAVED) | saved.bounds,
        row(case, "capacity gained", more.mean, "1", published=middle) | more.bounds,
    ]


def said(rows: Rows) -> Story:
    """What differs from the trial."""
    return Story(
        paragraphs=(
            "What differs: the trial's tractor, plough, soil and law of control are not known to "
            "us. Ours are a Massey Ferguson 275 with three bodies on tilled soil with areas of "
            "less grip, and a law of the same purpose with the published band of slip.",
            "How much fuel and capacity the control gains depends on how often and how far the "
            "draft control slips above the band, and so on the assumed areas.",
        )
    )
