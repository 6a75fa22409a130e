"""Implements from files: what they pull, and by whose law."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.simulation.rigs import EVEN_PLOUGHING
from twin.errors import BadInput, OutOfRange
from twin.machine.plough_setting import expected_draft_n
from twin.scenario import Course, Plough
from twin.simulation.build import build
from twin.simulation.simulate import simulate
from twin.vehicle import Implement, files
from twin.vehicle.kinds import KINDS

COURSE = Course(approach_m=3.0, length_m=12.0)
LATE = slice(-1000, None)


def scenario(part, depth_m, **own):
    return replace(
        EVEN_PLOUGHING, plough=Plough(depth_m=depth_m), course=COURSE, implement=part.name,
        implement_numbers=part, **own,
    )  # fmt: skip


def worked(made):
    """Draft, depth and speed late in a course, and the machine."""
    machine = build(made)
    chunks = list(simulate(machine))
    assert chunks[-1].end.as_planned
    columns = ("draft_n", "depth_m", "velocity_w")
    draft, depth, speed = (np.concatenate([c[n] for c in chunks])[LATE] for n in columns)
    return draft.mean(), depth.mean(), speed[:, 0].mean(), machine


PLOUGHS = [(2, 0.35), (3, 0.45), (5, 0.30), (6, 0.30)]


@pytest.mark.parametrize(("bodies", "width_m"), PLOUGHS)
def test_another_plough_pulls_by_its_own_bodies_and_width(bodies, width_m):
    part = Implement(name="own", bodies=bodies, width_m=bodies * width_m, mass_kg=300.0 * bodies)
    draft, depth, speed, machine = worked(scenario(part, 0.15))
    scale = machine.scenario.soil.resolved.draft_scale
    wanted = scale * (652.0 + 5.1 * (3.6 * speed) ** 2) * bodies * width_m * 100.0 * depth
    assert draft == pytest.approx(wanted, rel=0.02)
    assert expected_draft_n(machine.numbers, 0.15, scale) == pytest.approx(
        scale * (652.0 + 5.1 * 5.5**2) * bodies * width_m * 15.0
    )


KIND_DEPTHS = [("chisel_3m", 0.15), ("subsoiler_3", 0.25), ("cultivator_3m", 0.08)]


@pytest.mark.parametrize(("name", "depth_m"), KIND_DEPTHS)
def test_a_tool_pulls_by_the_law_and_the_soil_factor_of_its_kind(name, depth_m):
    part = files.implement(name)
    kind = KINDS[part.kind]
    draft, depth, speed, machine = worked(scenario(part, depth_m))
    scale = machine.scenario.soil.resolved.draft_scale  # firm: between medium and fine
    factor = kind.medium + (1.0 - kind.medium) * (scale - 0.70) / 0.30
    kmh = 3.6 * speed
    wanted = factor * (kind.a + kind.b * kmh + kind.c * kmh**2) * part.bodies * 100.0 * depth
    assert draft == pytest.approx(wanted, rel=0.02)
    assert machine.scenario.plough.furrow == "none"


@pytest.mark.parametrize(("scale", "factor"), [(1.0, 1.0), (0.70, 0.85), (0.45, 0.65), (0.0, 0.0)])
def test_the_factor_of_a_kind_is_the_table_s_on_its_three_soils(scale, factor):
    from twin.physics import block
    from twin.physics.plough import soil_factor

    chisel = np.zeros(block.Plough.SIZE)
    chisel[block.Plough.FACTOR_MEDIUM], chisel[block.Plough.FACTOR_COARSE] = 0.85, 0.65
    assert soil_factor(chisel, scale) == pytest.approx(factor)


LAW = '''
"""A law of a user's."""
from twin.physics.block import Soil


def law(implement, soil, tool, depth_m, speed_mps, drift_rad):
    draft = soil[Soil.DRAFT_SCALE] * 1e4 * depth_m * (1.0 + 0.5 * tool)
    return draft, 0.1 * draft, 0.0
'''


def test_a_law_of_one_s_own_is_compiled_and_pulls(tmp_path: Path, monkeypatch):
    (tmp_path / "own_implement_law.py").write_text(LAW)
    monkeypatch.chdir(tmp_path)
    part = replace(
        files.implement("plough_3"), name="own",
        draft=replace(files.implement("plough_3").draft, law="own_implement_law:law"),
    )  # fmt: skip
    draft, depth, _, machine = worked(scenario(part, 0.15))
    scale = machine.scenario.soil.resolved.draft_scale
    assert draft == pytest.approx(scale * 1e4 * depth * (1.0 + 1.5 + 2.0), rel=0.03)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("def law(implement, soil):\n    return 1.0, 0.0, 0.0\n", "cannot be compiled"),
        ("def law(implement, soil, tool, d, v, a):\n    soil[0] = 1.0\n    return 1.0, 0.0, 0.0\n",
         "it writes to"),
        ("def other():\n    pass\n", "no attribute"),
    ],
)  # fmt: skip
def test_a_law_that_is_none_is_refused_in_one_line(tmp_path, monkeypatch, text, said):
    module = f"bad_law_{abs(hash(text)) % 10**8}"
    (tmp_path / f"{module}.py").write_text(text)
    monkeypatch.chdir(tmp_path)
    plain = files.implement("plough_3")
    part = replace(plain, name="own", draft=replace(plain.draft, law=f"{module}:law"))
    with pytest.raises(BadInput, match=said):
        build(scenario(part, 0.15), settle=False)


@pytest.mark.parametrize("bodies", [7, 12, 0])
def test_more_bodies_than_fit_are_refused_by_name(bodies):
    with pytest.raises(OutOfRange, match=rf"bodies = {bodies} .*1 to 6"):
        Implement(bodies=bodies, width_m=0.35 * max(1, bodies), mass_kg=900.0)


def test_the_tractor_alone_is_the_implement_none():
    alone = replace(EVEN_PLOUGHING, implement="none")
    assert alone.plough is None
    assert build(alone, settle=False).hitch is not None


def test_a_depth_beyond_the_implement_is_refused():
    with pytest.raises(OutOfRange, match=r"plough.depth_m = 0.25 .*\[0.03, 0.15\].*cultivator_3m"):
        replace(EVEN_PLOUGHING, implement="cultivator_3m")


def test_bodies_stand_side_by_side_and_within_their_width():
    for name in ("plough_3", "plough_6", "chisel_3m", "cultivator_3m", "subsoiler_3"):
        part = files.implement(name)
        model = build(scenario(part, part.depths_m[0] + 0.05), settle=False).model
        y = sorted(model.site(f"plough.share_{i + 1}").pos[1] for i in range(part.bodies))
        assert np.diff(y) == pytest.approx(part.width_m / part.bodies)
        assert math.isclose(y[-1] - y[0] + part.width_m / part.bodies, part.width_m)
