"""The mesh of the ground: strips that make up the whole, and grow with the number of passes."""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from twin.viz.bodies import Bodies
from twin.viz.furrows import PLOUGHED_M, Cut, Pass
from twin.viz.ground import Ground
from twin.viz.ground_mesh import MOST_CORNERS, _lifted_m, begins, lines, reaching, strips

WIDTH_M = 0.4
BODIES = Bodies(
    ahead_m=(-3.0, -4.0, -5.0, -6.0), left_m=(-0.5, -0.1, 0.3, 0.7), width_m=WIDTH_M, side=-1,
    wall_m=0.8, open_m=0.5,
)  # fmt: skip
GROUND = Ground(bodies=BODIES)
PLOUGHING = SimpleNamespace(plough=SimpleNamespace(depth_m=0.25), course=None, field=None)


def field(passes):
    """Passes of 60 m side by side, there and back, and the path that joins them."""
    ahead_m = np.linspace(0.0, 60.0, 61)
    found, path = [], []
    for k in range(passes):
        s_m, t_m = ahead_m[:: 1 if k % 2 == 0 else -1], np.full(61, 1.6 * k + 0.02 * (k % 3))
        wide_m = PLOUGHED_M if k == 0 else 0.5 + 4 * WIDTH_M
        cut = Cut(
            from_ns=k, wall_m=float(t_m[0]) - 0.8, low_m=2.0, high_m=58.0, ploughed_m=wide_m
        )  # fmt: skip
        found.append((cut, Pass(s_m=s_m, t_m=t_m)))
        path.append(np.stack([s_m, t_m, 0.0 * s_m], axis=1))
    return found, np.concatenate(path)


def test_strips_are_the_whole_mesh_and_share_the_lines_between_them():
    found, path = field(6)
    t_m = lines(path, found, PLOUGHING, GROUND)[1]
    parts = strips(t_m, found)
    assert (parts[0][0], parts[-1][1]) == (0, len(t_m))
    assert all(one[1] == other[0] + 1 for one, other in pairwise(parts))
    assert strips(t_m, found[:1]) == [(0, len(t_m))]


@pytest.mark.parametrize("passes", [1, 5])
def test_a_strip_has_the_heights_of_the_whole_whenever_they_change(passes):
    found, path = field(passes)
    s_m, t_m = lines(path, found, PLOUGHING, GROUND)
    s, t = np.meshgrid(s_m[::5], t_m, indexing="ij")
    every = dict(enumerate(found))
    whole = [_lifted_m(PLOUGHING, GROUND, every, k, s, t) for k in range(passes)]
    for first, end in strips(t_m, found):
        near = reaching(found, GROUND, t_m[first], t_m[end - 1])
        drawn = begins(near, passes)
        for k in range(passes):
            shown = max(i for i in drawn if i <= k)
            part = _lifted_m(PLOUGHING, GROUND, near, shown, s[:, first:end], t[:, first:end])
            for own, of_all in zip(part, whole[k], strict=True):
                assert (own == of_all[:, first:end]).all()


def test_a_recording_grows_with_the_passes_and_not_with_their_square():
    def corners(passes):
        found, path = field(passes)
        s_m, t_m = lines(path, found, PLOUGHING, GROUND)
        assert len(s_m) * len(t_m) <= 1.05 * MOST_CORNERS
        return sum(
            len(s_m) * (end - first) * len(begins(near, passes))
            for first, end in strips(t_m, found)
            for near in [reaching(found, GROUND, t_m[first], t_m[end - 1])]
        )

    assert corners(24) < 2.3 * corners(12)
    assert corners(80) < 8 * MOST_CORNERS


def test_a_road_to_the_field_has_few_lines():
    found, path = field(40)
    road = np.stack([np.linspace(-1500.0, 0.0, 1501), np.zeros(1501), np.zeros(1501)], axis=1)
    s_m, _ = lines(np.concatenate([road, path]), found, PLOUGHING, GROUND)
    assert np.diff(s_m[(s_m > 0.0) & (s_m < 60.0)]).max() < 1.0
    assert (s_m < -60.0).sum() < 0.4 * len(s_m)
