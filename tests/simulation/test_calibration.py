"""The drive there and back before a run."""

from dataclasses import replace

import numpy as np

from twin.pipeline.named import load
from twin.simulation.calibration import leg_machine, legs


def test_back_is_driven_over_the_ground_of_the_way_out():
    scenario = load("scenario", "plough-25cm")
    out, back = legs(replace(scenario, course=replace(scenario.course, calibration_m=20.0)))
    there, home = (leg_machine(leg).maps["heights"] for leg in (out, back))
    s, t = np.linspace(0.0, 20.0, 50), np.linspace(-2.0, 2.0, 50)
    np.testing.assert_allclose(home.at(20.0 - s, -t), there.at(s, t), atol=1e-12)
