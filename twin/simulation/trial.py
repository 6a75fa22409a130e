"""The operator's trial furrow: what lever, draft and depth wheel are set by.

Squat, sinkage, pitch and slip put a plough elsewhere than its linkage would. So the operator
ploughs a few metres, mends the depth until it is right, and leaves hitch and depth wheel there.
Here that is a drive on soil that is even and has the draft that is expected.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from twin.machine.build import Machine
from twin.machine.plough_setting import Setting
from twin.scenario import Course, Driver, Plough, Scenario
from twin.simulation.build import build
from twin.simulation.simulate import simulate
from twin.trajectory.end import Outcome

COURSE = Course(approach_m=3.0, length_m=30.0)
LAST_S = 2.0
"""What is looked at of the drive [s]: by then the depth is mended."""
TRIES, ENOUGH_M = 4, 0.002
"""How often at most, and how close, the depth wheel of a plough that floats is set [m]."""


@dataclass(frozen=True)
class FurrowMeans:
    """Means at the end of a trial furrow."""

    hitch_rad: float
    draft_n: float
    depth_m: float


def tried(scenario: Scenario, plough: Plough, geometry: Setting) -> Setting:
    """The setting after the trial; what the geometry asks for where the tractor got stuck in it."""
    if plough.hitch == "float":
        return _afloat(_expected(scenario, plough), plough.depth_m, geometry)
    trimmed = replace(
        plough, hitch="depth", front_ballast_kg=plough.ballast_kg, top_link_drop_m=plough.drop_m
    )
    found = _ploughed(build(_expected(scenario, trimmed), setting=geometry))
    if found is None:
        return geometry
    squat_rad = found.hitch_rad - geometry.lever_rad
    lowest_rad = geometry.lowest_rad + squat_rad
    return Setting(found.hitch_rad, lowest_rad, found.draft_n, geometry.sag_m)


def _afloat(scenario: Scenario, depth_m: float, setting: Setting) -> Setting:
    """The depth wheel is moved until the floating plough works at its depth."""
    for _ in range(TRIES):
        found = _ploughed(build(scenario, setting=setting))
        if found is None:
            break
        setting = replace(setting, sag_m=setting.sag_m + found.depth_m - depth_m)
        if abs(found.depth_m - depth_m) < ENOUGH_M:
            break
    return setting


def _expected(scenario: Scenario, plough: Plough) -> Scenario:
    """A short drive on the soil that the operator expects: even, smooth, without rocks."""
    soil = replace(
        scenario.soil,
        draft_scale=scenario.expected_draft_scale,
        draft_cv=0.0,
        ripple_cv=0.0,
        strength_cv=0.0,
        rocks_per_100m2=0.0,
    )
    field = replace(
        scenario.field,
        roughness_class="smooth",
        height_map=None,
        soil_map=None,
        other_share=0.0,
        patches=(),
    )
    return replace(
        scenario, soil=soil, field=field, plough=plough, course=COURSE, driver=Driver(), events=()
    )


def _ploughed(machine: Machine) -> FurrowMeans | None:
    """Means of the last seconds of a drive; None where it ended early."""
    parts = list(simulate(machine))
    end = parts[-1].end
    if end is None or end.outcome not in (Outcome.DRIVEN, Outcome.SHALLOW):
        return None
    rows = round(LAST_S / machine.scenario.timestep_s)

    def mean(name: str) -> float:
        return float(np.mean(np.concatenate([part[name] for part in parts])[-rows:]))

    return FurrowMeans(mean("hitch_rad"), mean("draft_n"), mean("depth_m"))
