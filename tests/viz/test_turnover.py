"""The plough as it is drawn stands where the soil's forces act, turned over to its side."""

from functools import cache

import mujoco
import numpy as np
import pytest

from tests.simulation.rigs import PLOUGHING, replace
from twin.machine.build import assemble
from twin.physics import block
from twin.pipeline.run import run
from twin.scenario import Course, Plough
from twin.viz.shapes import joint_states

SIDES = {"right": -1, "left": 1}
COURSE = Course(approach_m=1.0, length_m=6.0)


@cache
def ploughing(side):
    """A dressed model and its state, at the end of a short furrow; and the depth there."""
    scenario = replace(PLOUGHING, plough=Plough(depth_m=0.22, furrow=side), course=COURSE)
    truth = run(scenario, estimators={}).truth
    model = assemble(scenario, looks=True).model
    state = mujoco.MjData(model)
    state.qpos[:] = joint_states(model, {name: column[-1:] for name, column in truth.items()})[0]
    mujoco.mj_kinematics(model, state)
    return model, state, truth["depth_m"][-1]


def force_points(model, state):
    """Where the law lets the soil's forces act, of each body, from the block. Shape (4, 3)."""
    first = model.nnumericdata - block.SIZE + block.PLOUGH + int(block.Plough.SHARES)
    shares = model.numeric_data[first : first + 12].reshape(4, 3)
    frame = state.body("plough.frame")
    return frame.xpos + shares @ frame.xmat.reshape(3, 3).T


def drawn(model, state, part):
    """Points of the drawn parts of this name, of the four that are down. Shape (4, n, 3)."""
    found = []
    for body in range(1, 5):
        both = [
            g for g in range(model.ngeom)
            if model.geom(g).name in (f"plough.body_{body}.{part}", f"plough.body_{body}.{part}_up")
        ]  # fmt: skip
        found.append(min((points(model, state, g) for g in both), key=lambda p: p[:, 2].mean()))
    return np.array(found)


def points(model, state, g):
    mesh = model.geom_dataid[g]
    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    vertices = model.mesh_vert[first : first + count]
    return state.geom_xpos[g] + vertices @ state.geom_xmat[g].reshape(3, 3).T


def cutting_edge(share, side):
    """Its point, ahead on the land's side, and its wing on the furrow's. Shape (2, 3)."""
    furrowward = side * share[:, 1]
    wings = share[furrowward > furrowward.max() - 0.02]
    return np.array([share[share[:, 0].argmax()], wings[wings[:, 0].argmax()]])


@pytest.mark.parametrize("side", SIDES)
def test_seen_from_above_the_shares_cut_where_the_forces_act(side):
    model, state, depth_m = ploughing(side)
    assert depth_m > 0.15
    edges = np.array([cutting_edge(s, SIDES[side]) for s in drawn(model, state, "share")])
    away_m = edges.mean(axis=1) - force_points(model, state)
    assert np.all(np.linalg.norm(away_m[:, :2], axis=1) < 0.03)
    assert np.all(np.abs(away_m[:, 2]) < 0.03)
    across_m = SIDES[side] * (edges[:, 1, 1] - edges[:, 0, 1])
    assert np.all((across_m > 0.34) & (across_m < 0.40)), "a share is as wide as its furrow"


@pytest.mark.parametrize("side", SIDES)
def test_the_bodies_go_back_towards_the_land_and_turn_the_slice_away_from_it(side):
    model, state, _ = ploughing(side)
    points_w = force_points(model, state)
    np.testing.assert_allclose(np.diff(points_w[:, 0]), -0.85, atol=0.02)
    np.testing.assert_allclose(np.diff(points_w[:, 1]), -SIDES[side] * 0.35, atol=0.02)
    for board, share in zip(
        drawn(model, state, "mouldboard"), drawn(model, state, "share"), strict=True
    ):
        tip, end = share[share[:, 0].argmax()], board[board[:, 0].argmin()]
        assert end[0] < tip[0] - 0.5
        assert SIDES[side] * (end[1] - tip[1]) > 0.4
        assert end[2] > tip[2] + 0.1


@pytest.mark.parametrize("side", SIDES)
def test_the_first_body_meets_the_wall_in_which_the_wheels_run(side):
    model, state, _ = ploughing(side)
    field = model.numeric_data[-block.SIZE :][block.FIELD :]
    wall_m = SIDES[side] * field[block.Field.FURROW_EDGE_M]
    inner_m = force_points(model, state)[0, 1] + SIDES[side] * 0.175
    assert inner_m == pytest.approx(wall_m, abs=0.08)
    wheel = state.body("rr_wheel" if side == "right" else "rl_wheel").xpos
    assert SIDES[side] * (wheel[1] - wall_m) > 0.0


def test_the_sites_are_the_points():
    for side in SIDES:
        model, state, _ = ploughing(side)
        sites = [state.site(f"plough.share_{i}").xpos for i in range(1, 5)]
        mujoco.mj_kinematics(model, state)
        np.testing.assert_allclose(sites, force_points(model, state), atol=1e-12)
