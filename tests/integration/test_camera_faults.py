"""A camera's faults against the answers written beside their scenarios, for `sideslip-ekf`."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

pytest.importorskip("cv2")

from estimators.odometry.lens import Reason
from scenarios.faults import ON_SLOPE, SLOPE_S, SLOPE_START_S
from twin.pipeline.named import load
from twin.pipeline.run import run
from twin.scores import scores

pytestmark = pytest.mark.slow
REASONS = {
    "camera-black": {Reason.FLAT, Reason.FIRST},
    "camera-frozen": {Reason.FROZEN, Reason.FIRST, Reason.UNMATCHED},  # it moved on meanwhile
    "camera-dropout": {Reason.FIRST},
    "camera-half": {Reason.SIZE},
}


@cache
def driven(kind):
    """The scenario with a shorter calibration and a shorter platform."""
    named = load("scenario", f"fault-{kind}")
    scenario = replace(named, course=replace(named.course, calibration_m=5.0, length_m=8.0))
    made = run(scenario, estimators={"own": load("estimator", "sideslip-ekf")})
    return made, int(made.truth["epoch_ns"][0])


@pytest.mark.parametrize("kind", ON_SLOPE)
def test_the_answer_is_the_one_expected(kind):
    made, start_ns = driven(kind)
    told = made.estimates["own"]
    time_s = (told["epoch_ns"] - start_ns) * 1e-9
    assert np.isfinite(told["sideslip_m"][time_s > 0.2]).all()
    late = (time_s > SLOPE_START_S) & (told["epoch_ns"] <= made.truth["epoch_ns"][-1])
    error_m = told["sideslip_m"] - scores.at(made.truth, "sideslip_m", told["epoch_ns"])
    assert np.abs(error_m[late] - error_m[late][0]).max() < ON_SLOPE[kind][0]
    sd_m = np.interp([SLOPE_START_S, SLOPE_START_S + SLOPE_S], time_s, told["sideslip_sd_m"])
    assert (sd_m[1] > 2.5 * sd_m[0]) == (kind != "camera-half")


@pytest.mark.parametrize("kind", ON_SLOPE)
def test_what_was_seen_says_why_it_is_not_used(kind):
    made, start_ns = driven(kind)
    camera = made.streams["camera"]
    time_s = (camera["epoch_ns"] - start_ns) * 1e-9
    during = (time_s > SLOPE_START_S + 0.05) & (time_s < SLOPE_START_S + SLOPE_S - 0.05)
    near = (time_s > SLOPE_START_S - 0.05) & (time_s < SLOPE_START_S + SLOPE_S + 0.3)
    reasons = {Reason(int(r)) for r in camera["reason"][near & ~camera["used"]]}
    assert reasons == REASONS[kind]
    assert during.any() == (kind != "camera-dropout")
    assert camera["used"][during].all() == (kind in ("camera-half", "camera-dropout"))
    assert camera["used"][during].any() == (kind == "camera-half")
    assert np.isnan(camera["v_y_mps"][~camera["used"]]).all()
