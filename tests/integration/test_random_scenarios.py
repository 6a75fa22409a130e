"""Random scenarios over the whole range a scenario permits: a drive, or a refusal before it.

By hand, more of them and from another seed:

    RANDOM_SCENARIOS=2000 RANDOM_SEED=1 python -m pytest tests/integration/test_random_scenarios.py
"""

import dataclasses
import itertools
import math
import os
from collections import Counter

import numpy as np
import pytest

from twin.errors import TwinError
from twin.scenario import Course, Drive, Field, Patch, Plough, Scenario, Soil
from twin.scenario.course import HEADLANDS, LEAST_APPROACH_M
from twin.scenario.field import MOST_PATCHES, ROUGHNESS
from twin.scenario.plough import FURROW_SIDES, HITCH_MODES
from twin.scenario.scenario import STEPS_S
from twin.scenario.soil import CONE_INDICES_KPA, DEFORMABLE_RANGES, FRICTIONS, NEEDED
from twin.scenario.soils import LAWS, PRESETS
from twin.simulation.build import build
from twin.simulation.guard import Diverged
from twin.simulation.simulate import simulate
from twin.vehicle import files

COUNT = int(os.environ.get("RANDOM_SCENARIOS", "20"))
SEED = int(os.environ.get("RANDOM_SEED", "0"))
DRIVEN_S = 5.0
MOST_MPS = 40.0
"""No machine here reaches it; a simulation that gives energy away does."""

FLAG = (False, True)
RANGES = {
    Soil: {
        "preset": tuple(PRESETS), "law": LAWS, "friction": (0.05, 1.5),
        "cone_index_kpa": (50.0, 5000.0), "draft_scale": (0.0, 2.0), "draft_cv": (0.0, 0.5),
        "draft_length_m": (0.2, 100.0), "ripple_cv": (0.0, 0.5), "strength_cv": (0.0, 0.3),
        "rocks_per_100m2": (0.0, 25.0), "rock_kn": (0.0, 50.0), **DEFORMABLE_RANGES,
        "numbers": None,  # the preset's own, as a run keeps them
    },
    Field: {
        "cross_slope_deg": (-25.0, 25.0), "grade_deg": (-15.0, 15.0),
        "roughness_class": tuple(ROUGHNESS), "patches": Patch,
        "other_share": (0.0, 0.9), "other_length_m": (1.0, 100.0), "other_soil": Soil,
        "height_map": None, "soil_map": None, "map_cell_m": (0.02, 10.0),
        "map_start_m": (-1000.0, 1000.0),
    },
    Patch: {
        "start_m": (-5.0, 30.0), "length_m": (0.5, 50.0), "friction_factor": (0.1, 2.0),
        "cone_index_factor": (0.1, 4.0),
    },
    Plough: {
        "depth_m": (0.05, 0.35), "wheel_share": (0.0, 1.0), "furrow": tuple(FURROW_SIDES),
        "hitch": HITCH_MODES, "expected_draft_scale": (0.0, 2.0), "draft_mix": (0.0, 1.0),
        "sensitivity_rad": (0.01, 0.1), "drop_rate_radps": (0.05, 1.0),
        "upper_limit_rad": (0.4, 0.9), "deepest_m": (0.35, 0.4),
        "front_ballast_kg": (0.0, 1000.0), "top_link_drop_m": (0.0, 0.25),
    },
    Drive: {
        "gear_ratio": (15.0, 300.0), "engine_set_rpm": (900.0, 2400.0), "all_wheel_drive": FLAG,
        "differential_lock": FLAG, "exhaust_brake": FLAG, "gear_kmh": None,
    },
    Course: {
        "approach_m": (0.0, 20.0), "length_m": (1.0, 5000.0), "heading_deg": (-180.0, 180.0),
        "start_left_m": (-50.0, 50.0), "hold_line": FLAG, "edge_m": None,
        "passes": (1, 100), "calibration_m": None,
        "headland": None, "backings": None, "road_m": None,  # drawn by themselves, below
    },
    Scenario: {
        "machine": ("taishan_1404a", "electric_tractor"), "soil": Soil, "field": Field,
        "plough": Plough,
        "drive": Drive, "course": Course, "timestep_s": STEPS_S, "seed": None,
        "name": None, "about": None, "sensors": None,  # the machine knows nothing of these
        "implement": None,  # drawn with the machine, below
        "zero_slip": ("law", "hard-torque", "hard-pull", "field-torque", "field-pull"),
        "machine_numbers": None, "implement_numbers": None,  # kept of files
        "driver": None, "events": None,  # drawn in tests/long/test_random_events.py
    },
}  # fmt: skip
"""Every field with its choices (tuple of names or flags), or its range (two floats). Places are
drawn where five seconds can reach them."""
HITCHED = tuple(RANGES[Plough])[4:]
"""How the hitch is set, drawn from a stream of its own."""
BACKINGS, ROADS_M = tuple(range(1, 7)), (1.0, 20000.0)
"""Of turns and of the road, drawn from the same stream."""
MAY_FOLLOW_PRESET = tuple(f.name for f in dataclasses.fields(Soil) if f.default is None)
OTHERS = tuple(n for n in files.machine_names() if n not in RANGES[Scenario]["machine"])
TOOLS = ("plough_2", "plough_6", "chisel_3m", "subsoiler_3", "cultivator_3m")
EDGE_SHARE = 0.15
"""Share of numbers drawn at an end of their range."""


def drawn(rng, choices):
    """A number within a range, often at its ends; or one of some choices."""
    if isinstance(choices[0], float) and choices is not STEPS_S:
        low, high = choices
        if rng.random() < EDGE_SHARE:
            return float(rng.choice((low, high)))
        if low > 0.0 and high / low > 20.0:
            return float(np.exp(rng.uniform(np.log(low), np.log(high))))
        return float(rng.uniform(low, high))
    return choices[rng.integers(len(choices))]


def soil(rng):
    """A preset with a few numbers of its own, or all of them; mostly with what its law needs."""
    share = rng.choice((0.0, 0.2, 1.0))
    law, preset = (drawn(rng, RANGES[Soil][n]) for n in ("law", "preset"))
    kind = PRESETS[preset]
    lacks = () if kind.deformable is not None else NEEDED
    if law == "brixius":
        lacks = ("cone_index_kpa",) if math.isnan(kind.cone_index_kpa) else ()
    given = lacks if rng.random() < 0.8 else ()
    values = {
        name: drawn(rng, choices)
        for name, choices in RANGES[Soil].items()
        if choices is not None
        and (name not in MAY_FOLLOW_PRESET or name in given or rng.random() < share)
    }
    return Soil(**values | {"law": law, "preset": preset})


def simple(rng, kind, leaving=()):
    choices = RANGES[kind].items()
    return {n: drawn(rng, c) for n, c in choices if isinstance(c, tuple) and n not in leaving}


def patch(rng):
    """A patch, and whether the soils on it are to stay within their ranges, as most are."""
    return simple(rng, Patch), rng.random() < 0.9


def within_ranges(values, grounds):
    """A patch's values, its factors brought to where soils mostly stay within their ranges."""
    for name, (low, high) in (("friction", FRICTIONS), ("cone_index_kpa", CONE_INDICES_KPA)):
        kind = f"{name.removesuffix('_kpa')}_factor"
        owns = [v for v in (getattr(g.resolved, name) for g in grounds) if not math.isnan(v)]
        for own in owns:
            values[kind] = min(max(values[kind], min(1.0, 2.0 * low / own)), 0.7 * high / own)
    return values


def scenario(seed):
    """The scenario of a seed.

    Raises:
        TwinError: what was drawn cannot be.
    """
    rng = np.random.default_rng(seed)
    own = np.random.default_rng((seed, 1))
    hitched = {name: drawn(own, RANGES[Plough][name]) for name in HITCHED}
    machine = drawn(rng, RANGES[Scenario]["machine"])
    ploughs = machine != "electric_tractor" and rng.random() < 0.7
    course = simple(rng, Course) | {"approach_m": drawn(rng, (0.0, 20.0)) * rng.integers(2)}
    drive = simple(rng, Drive)
    if machine == "electric_tractor":
        course["edge_m"] = drawn(rng, (0.5, 100.0)) if rng.random() < 0.3 else None
        drive["engine_set_rpm"] = drawn(rng, (300.0, 3000.0))
    implement = None
    if machine != "electric_tractor" and own.random() < 0.4:
        machine = OTHERS[own.integers(len(OTHERS))]
        drive |= {"gear_ratio": None, "engine_set_rpm": None, "all_wheel_drive": False}
        drive["gear_kmh"] = drawn(own, (2.0, 15.0))
    if ploughs and own.random() < 0.4:
        implement = TOOLS[own.integers(len(TOOLS))]
        hitched["deepest_m"] = None
    field = simple(rng, Field)
    if rng.random() < 0.5:
        field["other_share"] = 0.0
    if course["approach_m"] < LEAST_APPROACH_M or not course["hold_line"] or course.get("edge_m"):
        course["passes"] = 1
    if own.random() < 0.3:
        course |= {"headland": drawn(own, HEADLANDS), "backings": drawn(own, BACKINGS)}
    if own.random() < 0.5 and course["passes"] % 2 == 0:
        course["road_m"] = drawn(own, ROADS_M)
    ground = soil(rng)
    drawn_patches = [patch(rng) for _ in range(rng.integers(MOST_PATCHES + 1))]
    ploughed = simple(rng, Plough, HITCHED) | hitched if ploughs else {}
    if ploughs and (implement or machine in OTHERS):  # as deep as the implement works
        tool = files.implement(implement or files.machine(machine).implement or "plough_2")
        (low, high), (shallow, deep) = RANGES[Plough]["depth_m"], tool.depths_m
        share = (ploughed["depth_m"] - low) / (high - low)
        ploughed |= {"depth_m": shallow + share * (deep - shallow), "deepest_m": None}
    other = soil(rng)
    grounds = (ground, other) if field["other_share"] > 0.0 else (ground,)
    patches = tuple(
        Patch(**(within_ranges(values, grounds) if within else values))
        for values, within in drawn_patches
    )
    return Scenario(
        name=f"random-{seed}",
        machine=machine,
        implement=implement,
        soil=ground,
        field=Field(**field, patches=patches, other_soil=other),
        plough=Plough(**ploughed) if ploughs else None,
        drive=Drive(**drive),
        course=Course(**course),
        timestep_s=drawn(rng, STEPS_S),
        seed=int(rng.integers(2**31)),
    )


def outcome(seed):
    """How a seed's scenario ended: "driven", "refused: ...", or "failed: ..."."""
    try:
        chosen = scenario(seed)
        machine = build(chosen)
    except Diverged as error:
        return f"failed: {error}"
    except TwinError as error:
        return f"refused: {error}"
    try:
        chunks = list(itertools.islice(simulate(machine), round(DRIVEN_S)))
    except Diverged as error:
        return f"failed: {error}"
    for chunk in chunks:
        for name, column in chunk.columns.items():
            absent = chosen.plough is None and name in ABSENT
            if not absent and not np.all(np.isfinite(column)):
                return f"failed: {name} is not finite in '{chosen.name}'"
    fastest = max(float(np.abs(c["velocity_w"]).max()) for c in chunks)
    if fastest > MOST_MPS:
        return f"failed: {fastest:.0f} m/s in '{chosen.name}'"
    return "driven"


ABSENT = ("laser_m", "inclination_rad", "plough_pitch_rad")
"""NaN without a plough."""


@pytest.mark.parametrize("kind", RANGES, ids=lambda kind: kind.__name__)
def test_every_field_of_a_scenario_is_drawn(kind):
    assert set(RANGES[kind]) == {f.name for f in dataclasses.fields(kind)}


@pytest.mark.slow
def test_a_random_scenario_drives_or_is_refused_by_name():
    ends = {seed: outcome(seed) for seed in range(SEED * COUNT, (SEED + 1) * COUNT)}
    print(Counter(end.split(":")[0] for end in ends.values()))
    failed = {seed: end for seed, end in ends.items() if end.startswith("failed")}
    assert not failed
    parts = (
        "soil",
        "field",
        "plough",
        "drive",
        "course",
        "patch",
        "machine",
        "implement",
        "timestep_s",
    )
    refused = [end for end in ends.values() if end.startswith("refused")]
    assert all(any(part in end for part in parts) for end in refused)
    assert sum(end == "driven" for end in ends.values()) > COUNT // 2
