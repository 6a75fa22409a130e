"""Slip by another zero: what a free wheel and a free tractor then show."""

import dataclasses

import numpy as np
import pytest

import twin
from tests.simulation.rigs import BARE
from twin.errors import UnknownName
from twin.scenario import Soil
from twin.streams import ZERO_SLIPS

FREE = dataclasses.replace(BARE, soil=Soil(strength_cv=0.0))


def driven(zero):
    done = twin.run(dataclasses.replace(FREE, zero_slip=zero), ["ratio"])
    late = slice(-100, None)
    return done, {n: float(np.mean(done.truth[n][late])) for n in ("slip", "slip_fl", "slip_rr")}


def test_a_towed_wheel_has_no_slip_by_no_torque_and_a_free_tractor_none_by_no_pull():
    _, own = driven("law")
    _, torque = driven("field-torque")
    done, pull = driven("field-pull")
    assert own["slip"] > 0.004
    assert own["slip_fl"] < -0.004
    assert torque["slip_fl"] == pytest.approx(0.0, abs=1e-3)
    assert torque["slip"] > own["slip"]
    assert pull["slip"] == pytest.approx(0.0, abs=1e-3)
    assert done.scores["zero_slip"] == "field-pull"


def test_the_radii_that_are_told_follow_and_the_motion_does_not():
    (own, _), (pull, _) = driven("law"), driven("field-pull")
    radii = [done.setup.wheels.radius_m["rl"] for done in (own, pull)]
    assert radii[0] == 0.83
    assert 0.98 < radii[1] / radii[0] < 0.999
    np.testing.assert_array_equal(own.truth["speed_mps"], pull.truth["speed_mps"])
    np.testing.assert_array_equal(
        own.streams["wheels"]["ticks_rl"], pull.streams["wheels"]["ticks_rl"]
    )


def test_a_hard_surface_has_less_between_its_zeros():
    names = ("field-torque", "field-pull", "hard-torque", "hard-pull")
    slips = {name: driven(name)[1]["slip"] for name in names}
    field, hard = (slips[f"{n}-torque"] - slips[f"{n}-pull"] for n in ("field", "hard"))
    assert 0.0 < hard < field


def test_a_zero_that_there_is_not_is_refused():
    with pytest.raises(UnknownName, match="zero_slip"):
        dataclasses.replace(FREE, zero_slip="unknown")
    assert "unknown" in ZERO_SLIPS
