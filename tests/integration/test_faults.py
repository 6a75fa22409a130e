"""Every fault's scenario against the answer that is written beside it, for `slip-ekf`."""

from functools import cache

import numpy as np
import pytest

from scenarios.faults import (
    AFTER_LARGEST,
    AFTER_S,
    EXPECTED,
    START_S,
    TOGETHER_LARGEST,
)
from twin import sensors
from twin.machine.geometry import geometry
from twin.pipeline.named import load
from twin.scores import scores
from twin.sensors import Sensors
from twin.simulation.build import build
from twin.simulation.simulate import simulate
from twin.streams import concatenate
from twin.truth import truth

pytestmark = pytest.mark.slow
LARGEST = {kind: largest for kind, (_, largest, _) in EXPECTED.items()} | {"all": TOGETHER_LARGEST}


@cache
def driven():
    """One drive for all: the faults are the sensors', not the machine's."""
    machine = build(load("scenario", "fault-all"))
    chunks = tuple(simulate(machine))
    nominal = geometry(machine)
    table = truth.concatenate([truth.sample(chunk, nominal.driven) for chunk in chunks])
    return nominal, chunks, table


def estimated(fitted):
    nominal, chunks, true = driven()
    state, parts = sensors.init(fitted, 0), []
    for chunk in chunks:
        state, streams = sensors.sample(fitted, state, chunk)
        parts.append(streams)
    estimator = load("estimator", "slip-ekf")
    setup = sensors.setup(fitted, nominal)
    _, table = estimator.run(estimator.init(setup), concatenate(parts))
    error = table["slip"] - scores.at(true, "slip", table["epoch_ns"])
    return table["epoch_ns"] * 1e-9, error, table["slip_sd"]


@pytest.mark.parametrize("kind", LARGEST)
def test_the_answer_is_the_one_expected(kind):
    time, error, sd = estimated(load("scenario", f"fault-{kind}").sensors)
    assert np.isfinite(error[time > START_S - 10.0]).all()
    during = (time >= START_S) & (time < START_S + 10.0)
    assert np.abs(error[during]).max() < LARGEST[kind]
    assert np.abs(error[time >= START_S + AFTER_S]).max() < AFTER_LARGEST
    if kind == "imu-bias":  # no small sd for longer than half a second while speeds contradict it
        wrong = (np.abs(error[during]) > 0.02) & (np.abs(error[during]) > 3.0 * sd[during])
        assert 0.02 * np.count_nonzero(wrong) < 0.5
    if kind == "wheels-stuck":
        healthy = estimated(Sensors())[2]
        assert sd[during].max() > 10.0 * healthy[during].mean()
