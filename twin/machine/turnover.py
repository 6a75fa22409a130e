"""The plough as it stands to work: turned over to its side, and shifted to the furrow's wall."""

from __future__ import annotations

from typing import Any

from twin.machine.parameters import furrow_edge_m
from twin.scenario import Plough
from twin.scenario.plough import FURROW_SIDES

ASIDE, TURNED, SHARE = "plough.aside.", "plough.turned.", "plough.share_"
"""Frames of a model that go to the side that is worked; frames that turn over; the shares."""


def turn_over(spec: Any, plough: Plough, numbers: dict[str, float]) -> None:
    """Set the shares of a specification, and all that is drawn about them, to the furrow's side.

        y = +-(y_model - shift)        shift = edge - edge(depth)

    A model stands as it works with the furrow on the left. The operator has shifted it so that the
    first body meets the wall, which is nearer to the line the deeper the furrow. Where the soil's
    forces act and what is drawn there move together: they are in one frame. For a furrow on the
    right the drawn part is also turned over by half a turn about its axis.

    Args:
        spec: mujoco.MjSpec of a tractor with its plough; frames `aside.` and `turned.` are moved
            where there are any, and sites `share_` that are in none.
        plough: which side, and how deep.
        numbers: the models' <numeric> values.
    """
    side = FURROW_SIDES[plough.furrow]
    shift_m = (
        0.0 if side == 0 else numbers["furrow.edge_m"] - furrow_edge_m(numbers, plough.depth_m)
    )
    mirror = -1.0 if side < 0 else 1.0
    frames = [frame for frame in spec.frames if frame.name.startswith(ASIDE)]
    alone = [s for s in spec.sites if s.name.startswith(SHARE) and not _inside(s, ASIDE)]
    for placed in (*frames, *alone):
        x, y, z = placed.pos
        placed.pos = (x, mirror * (y - shift_m), z)
    if side < 0:
        for frame in spec.frames:
            if frame.name.startswith(TURNED):
                frame.quat = (0.0, 1.0, 0.0, 0.0)


def _inside(site: Any, name: str) -> bool:
    """Whether a site is in a frame whose name begins so."""
    frame = site.frame
    return frame is not None and frame.name.startswith(name)
