"""Uneven ground and a plough near standstill: forces follow the step, they do not jump."""

from dataclasses import replace

import numpy as np
import pytest

from scenarios.plough import CM_25
from tests.simulation.closure import CELL_M, edges
from tests.simulation.rigs import BARE, driven
from twin.physics import block
from twin.physics.block import WheelSlot
from twin.scenario import Course, Field
from twin.simulation.build import build
from twin.simulation.simulation import Simulation

GROUNDS = {
    "10 cm edges": Field(height_map=edges(), map_cell_m=CELL_M),
    "ISO D": Field(roughness_class="D"),
    "ISO F": Field(roughness_class="F"),
}


def largest_change_n(field, timestep_s):
    """Largest change of a tyre's spring force, a vector, from step to step. Shape (4,).

    Its damper is left out: at first touch it has the speed of what it meets.
    """
    course = Course(approach_m=0.0, length_m=14.0)
    scenario = replace(BARE, field=field, course=course, timestep_s=timestep_s)
    simulation = Simulation(build(scenario))
    slots = np.concatenate([simulation.advance()["userdata"][0] for _ in range(300)])
    wheels = slots[:, : block.MACHINE_SLOTS].reshape(len(slots), 4, -1)
    force_w = wheels[:, :, WheelSlot.SPRING_X_N : WheelSlot.SPRING_Z_N + 1]
    return np.linalg.norm(np.diff(force_w, axis=0), axis=2).max(axis=0)


@pytest.mark.parametrize("ground", GROUNDS)
def test_contact_forces_change_in_proportion_to_the_step(ground):
    coarse, fine = (largest_change_n(GROUNDS[ground], dt_s) for dt_s in (0.002, 0.0005))
    assert np.all(coarse >= 3.0 * fine)
    assert np.all(coarse > 0.0)


@pytest.fixture(scope="module")
def overloaded():
    """Twice the draft brings the tractor to a stand: columns at two steps."""
    heavy = replace(CM_25, soil=replace(CM_25.soil, draft_scale=2.0))
    return {dt_s: driven(replace(heavy, timestep_s=dt_s)) for dt_s in (0.002, 0.0005)}


def test_a_plough_near_standstill_does_not_chatter(overloaded):
    """From half a second after it has come to a stand, wheels spinning; before, draft falls."""
    c = overloaded[0.002]
    slow = (np.hypot(*c["velocity_w"][:, :2].T) < 0.1) & (c["depth_m"] > 0.2)
    stands = np.argmax(slow) + 250
    assert len(slow) - stands > 1000
    assert np.all(slow[stands:])
    assert np.sqrt(np.mean(np.diff(c["draft_n"][stands:]) ** 2)) < 50.0


def test_its_speed_and_its_way_are_those_of_a_finer_step(overloaded):
    coarse, fine = (overloaded[dt_s]["position_w"] for dt_s in (0.002, 0.0005))
    gone = [np.linalg.norm(p[-1] - p[0]) / (len(p) * dt_s)
            for p, dt_s in ((coarse, 0.002), (fine, 0.0005))]  # fmt: skip
    assert gone[0] == pytest.approx(gone[1], rel=0.02)


def test_its_power_closes(overloaded):
    c, dt_s = overloaded[0.002], 0.002
    work = {n: dt_s * float(v[:-1].sum()) for n, v in c.items() if n.startswith("power_")}
    engine = work.pop("power_engine_w")
    stored = sum(float(c[n][-1] - c[n][0]) for n in ("kinetic_j", "potential_j"))
    assert engine - sum(work.values()) - stored == pytest.approx(0.0, abs=0.01 * engine)
