"""What holds for every registered estimator: the suite that users run on their own."""

import dataclasses

import numpy as np
import pytest

from estimators import REGISTRY
from estimators.layout import OUT_OF_ORDER
from estimators.ratio import RATIO
from twin.pipeline import named as registry
from twin.streams import Streams, check, concatenate
from twin.testing import CHECKS, check_estimator, drives
from twin.testing.checks import SETUP, run, sample_streams
from twin.testing.stops import check_restart, check_reverse

STREAMS = sample_streams()


@pytest.fixture(params=REGISTRY)
def estimator(request):
    return registry.load("estimator", request.param)


def test_streams_obey_the_contract():
    check(STREAMS)
    assert len(STREAMS) == 6 * (20 + 50 + 50)


@pytest.mark.parametrize("holds", CHECKS, ids=lambda c: c.__name__.removeprefix("check_"))
def test_every(holds, estimator):
    holds(estimator)


def test_old_samples_are_flagged(estimator):
    at = len(STREAMS) // 2
    head, tail = STREAMS.samples(0, at), STREAMS.samples(at, len(STREAMS))
    now = max(t["arrival_ns"][-1] for t in head.tables.values())
    old = {
        s: {k: (np.full_like(v, now) if k == "arrival_ns" else v)[10:20] for k, v in t.items()}
        for s, t in STREAMS.tables.items()
    }
    clean, _ = run(estimator, [head, tail])
    disturbed, _ = run(estimator, [concatenate([head, Streams(old)]), tail])
    changed = disturbed["flags"] != clean["flags"]
    assert 1 <= np.count_nonzero(changed) <= 2
    assert np.all(disturbed["flags"][changed] & OUT_OF_ORDER)


def test_one_hertz_log_with_a_single_wheel_speed(estimator):
    """A bus log: horizontal speed as east, one wheel-based speed, no IMU, no heading."""
    t = np.arange(200.0)
    setup = dataclasses.replace(SETUP, gnss=None, imu=None, wheels=None)
    wheel = np.full(t.shape, 2.0)
    streams = Streams(
        {
            "gnss": drives.stamps(t)
            | {"v_east_mps": np.full(t.shape, 1.8), "v_north_mps": np.zeros(t.shape)},
            "wheels": drives.stamps(t) | {"speed_rl_mps": wheel, "speed_rr_mps": wheel.copy()},
        }
    )
    table, _ = run(estimator, [streams], setup)
    if np.isfinite(table["slip"]).any():
        assert table["slip"][-50:] == pytest.approx(0.1, abs=1e-6)


class Unsigned:
    """Slip as a size: what a slip meter without the sign of the speeds shows."""

    def init(self, setup):
        return RATIO.init(setup)

    def run(self, state, chunk):
        state, table = RATIO.run(state, chunk)
        return state, {**table, "slip": np.abs(table["slip"])}


def test_one_without_the_sign_of_slip_in_reverse_is_told():
    with pytest.raises(AssertionError, match=r"in reverse slip is off by 0\.2"):
        check_reverse(Unsigned())


class Counting:
    """Differences of counts, whatever lies between two samples."""

    def init(self, setup):
        return None

    def run(self, state, chunk):
        epoch_ns, ticks = (chunk["wheels"][c] for c in ("epoch_ns", "ticks_rl"))
        speed = np.diff(ticks, prepend=ticks[0]) / np.diff(epoch_ns, prepend=0) * 1e9
        slip = np.full(len(ticks), 0.12)
        return None, {
            "epoch_ns": epoch_ns,
            "slip": slip,
            "wheel_speed_mps": speed * 2 * np.pi * 0.8 / 4000,
        }


def test_one_that_differences_counts_over_a_restart_is_told():
    with pytest.raises(
        AssertionError, match=r"wheel_speed_mps is \d+\.\d m/s: counters begin anew"
    ):
        check_restart(Counting())


class Broken:
    """An estimator that gets everything wrong that can be got wrong."""

    def __init__(self) -> None:
        self.seen = 0

    def init(self, setup):
        return []

    def run(self, state, chunk):
        wheels = chunk.tables.get("wheels", {"epoch_ns": np.empty(0, np.int64)})
        self.seen += 1
        epoch_ns = wheels["epoch_ns"]
        if "speed_rl_mps" in wheels:
            wheels["speed_rl_mps"] -= 1.0
        slip = np.full(len(epoch_ns), 12.0 + self.seen)
        return state, {
            "epoch_ns": epoch_ns,
            "slip": slip,
            "slipp": slip,
            "slip_sd": 0.01 + 0 * slip,
        }


def test_a_broken_one_is_told_all_that_is_wrong():
    with pytest.raises(AssertionError) as told:
        check_estimator(Broken())
    for name in ("columns", "chunks", "deterministic", "nan", "gap", "honest"):
        assert f"check_{name}:" in str(told.value)
    assert "['slipp'] are unknown" in str(told.value)
