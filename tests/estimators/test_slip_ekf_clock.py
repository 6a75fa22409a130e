"""Clocks that are set while a tractor drives, and stamps that come twice."""

from itertools import pairwise

import numpy as np
import pytest

from estimators.slip_ekf import SLIP_EKF
from estimators.slip_ekf.smooth import SLIP_EKF_SMOOTH
from twin.streams import Streams
from twin.testing.drives import Drive, seconds, setup, streams

SET_S = 20.0
BRAKING = Drive(
    duration_s=40.0,
    speed=lambda t: 2.2 - 0.4 * np.tanh((t - 20.5) / 0.5),
    slip=lambda t: 0.10 + 0.05 * np.tanh((t - 20.5) / 0.5),
)


def as_speeds(made):
    """The wheels give speeds and not counts, as on a bus."""
    table = dict(made["wheels"])
    for wheel, radius_m in (("fl", 0.6), ("fr", 0.6), ("rl", 0.8), ("rr", 0.8)):
        ticks = table.pop(f"ticks_{wheel}")
        turned = np.diff(ticks, prepend=ticks[0] - (ticks[1] - ticks[0])) / 4000 * 2 * np.pi
        table[f"speed_{wheel}_mps"] = radius_m * turned * 50.0
    return Streams({**made.tables, "wheels": table})


def clock_set(made, by_s):
    """The clock of all sensors is set ahead by so much, or back."""
    tables = {}
    for name, table in made.tables.items():
        late = np.where(seconds(table["epoch_ns"]) > SET_S, round(by_s * 1e9), 0)
        arrival_ns = np.maximum.accumulate(table["arrival_ns"] + late)
        tables[name] = dict(table, epoch_ns=table["epoch_ns"] + late, arrival_ns=arrival_ns)
    return Streams(tables)


def after(rows, by_s):
    """Rows since the clock was set, and their true times [s]."""
    stamped = seconds(rows["epoch_ns"])
    since = stamped > SET_S + max(by_s, 0.0)
    t = stamped[since] - by_s
    return {name: values[since] for name, values in rows.items()}, t


@pytest.mark.parametrize("by_s", [-3.0, -1.0, -0.5, -0.2, 0.5, 1.0, 3.0])
@pytest.mark.parametrize("counts", [True, False], ids=["counts", "speeds"])
def test_the_slip_after_a_clock_was_set_is_as_uncertain_as_it_says(by_s, counts):
    made = streams(BRAKING, setup())
    made = clock_set(made if counts else as_speeds(made), by_s)
    rows, t = after(SLIP_EKF.run(SLIP_EKF.init(setup()), made)[1], by_s)
    error = np.abs(rows["slip"] - BRAKING.slip(t))
    assert (error < 0.01 + 3.0 * rows["slip_sd"]).all()
    assert error[50:].mean() < 0.012
    assert rows["slip_sd"][50:].mean() < 0.02


def test_the_sd_grows_by_the_time_that_the_clock_repeats():
    made = streams(Drive(duration_s=30.0), setup())
    first = []
    for by_s in (0.0, -0.2, -1.0, -3.0):
        made_so = as_speeds(clock_set(made, by_s))
        rows, t = after(SLIP_EKF.run(SLIP_EKF.init(setup()), made_so)[1], by_s)
        assert t[0] == pytest.approx(SET_S - by_s + 0.02, abs=0.021)
        first.append(rows["slip_sd"][0])
    assert first[1] > 1.02 * first[0]
    assert (np.diff(first) > 0.0).all()


def test_how_samples_are_cut_changes_no_bit_where_the_clock_is_set_back():
    made = clock_set(streams(Drive(duration_s=25.0), setup()), -1.0)
    _, whole = SLIP_EKF.run(SLIP_EKF.init(setup()), made)
    state, parts = SLIP_EKF.init(setup()), []
    cuts = [0, *range(2395, 2525, 3), len(made)]  # a third of these samples repeat times
    for begin, end in pairwise(cuts):
        state, part = SLIP_EKF.run(state, made.samples(begin, end))
        parts.append(part)
    for name, values in whole.items():
        joined = np.concatenate([part[name] for part in parts])
        np.testing.assert_array_equal(joined, values, err_msg=name)


def test_a_sample_that_comes_twice_or_late_changes_no_estimate():
    made = streams(Drive(duration_s=10.0), setup())
    _, clean = SLIP_EKF.run(SLIP_EKF.init(setup()), made)
    for at in (200, 195):  # of wheel sample 200: again, and an older one
        table = made["wheels"]
        order = np.insert(np.arange(len(table["epoch_ns"])), 201, at)
        again = {name: values[order] for name, values in table.items()}
        again["arrival_ns"] = np.maximum.accumulate(again["arrival_ns"])
        doubled = Streams({**made.tables, "wheels": again})
        _, rows = SLIP_EKF.run(SLIP_EKF.init(setup()), doubled)
        for name in ("epoch_ns", "slip", "slip_sd", "speed_mps"):
            np.testing.assert_array_equal(rows[name], clean[name], err_msg=name)


def test_a_smoother_knows_the_time_that_was_missed():
    made = clock_set(as_speeds(streams(BRAKING, setup())), -1.0)
    _, rows = SLIP_EKF_SMOOTH.run(SLIP_EKF_SMOOTH.init(setup()), made)
    rows, t = after(rows, -1.0)
    error = np.abs(rows["slip"] - BRAKING.slip(t))
    assert (error < 0.01 + 3.0 * rows["slip_sd"]).all()
    assert error[50:].mean() < 0.012
