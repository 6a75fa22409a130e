"""What a drive with the plough says of its hitch, from 5 m after the plough is at work."""

import numpy as np

from twin.simulation.build import build
from twin.simulation.driver import full_depth_m
from twin.simulation.simulate import simulate

NAMES = ("depth_m", "depth_sd_m", "draft_over_held", "slip_sd")
SETTLED_M = 5.0


def hitch_row(scenario):
    """Means and standard deviations by NAMES; the drive has to reach its end."""
    machine = build(scenario)
    parts = list(simulate(machine))
    assert parts[-1].end.as_planned, (scenario.plough.hitch, scenario.seed, parts[-1].end)
    c = {
        name: np.concatenate([part[name] for part in parts])
        for name in ("depth_m", "draft_n", "slip", "velocity_w")
    }
    way_m = np.cumsum(np.linalg.norm(c["velocity_w"], axis=1)) * scenario.timestep_s
    deep = c["depth_m"] >= full_depth_m(scenario.plough.depth_m, scenario.plough.hitch)
    late = way_m >= way_m[np.argmax(deep)] + SETTLED_M
    depth, draft, slip = c["depth_m"][late], c["draft_n"][late], c["slip"][late, 2:]
    held = machine.setting.draft_n
    values = depth.mean(), depth.std(), draft.mean() / held, slip.mean(axis=1).std()
    return dict(zip(NAMES, values, strict=True))
