"""The plough in its working position: turned over to one side and shifted to the furrow's wall."""

from __future__ import annotations

from typing import Any

from twin.machine.parameters import furrow_edge_m
from twin.scenario import Plough
from twin.scenario.plough import FURROW_SIDES

ASIDE, TURNED, SHARE = "plough.aside.", "plough.turned.", "plough.share_"
"""Name prefixes of the frames that move sideways, of those that turn over, and of the shares."""


def turn_over(spec: Any, plough: Plough, numbers: dict[str, float]) -> None:
    """Move the shares of a specification, and their visual geometry, to the furrow's side.

        y = +-(y_model - shift)        shift = edge - edge(depth)

    A model is made for a furrow on the left. It is shifted so that the first body meets the
    furrow's wall: edge is the model's distance of the wall from the line, edge(depth) that of
    `furrow_edge_m`. For a furrow on the right the visual part is also turned over by half a turn
    about its axis.

    Args:
        spec: mujoco.MjSpec of a tractor with its plough; its frames `plough.aside.` and
            `plough.turned.` are moved, and sites `plough.share_` outside such frames.
        plough: gives the furrow's side and the depth.
        numbers: <numeric> values of the machine and its implement by name.
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
