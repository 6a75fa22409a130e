"""What is hidden, where it is scored, and how errors are summed up."""

import dataclasses

import numpy as np
import pytest

from estimators.ratio import RATIO
from twin.errors import BadInput
from twin.logs import Log
from twin.pipeline.hidden import hidden_scores
from twin.scores import hidden
from twin.streams import Streams
from twin.testing import drives

SETUP = drives.setup()
DRIVE = drives.Drive(duration_s=120.0, noise=0.0, ticks=False)
STREAMS = drives.streams(DRIVE, SETUP)


@dataclasses.dataclass(frozen=True)
class Holds:
    """Says a constant speed and slip, off by so much, with a stated sd."""

    off_mps: float = 0.0
    slip_sd: float = 0.01
    silent: bool = False

    def init(self, setup):
        return None

    def run(self, state, chunk):
        epoch_ns = chunk["wheels"]["epoch_ns"]
        t = drives.seconds(epoch_ns)
        speed = DRIVE.speed(t) + self.off_mps
        wheel = DRIVE.speed(t) / (1.0 - DRIVE.slip(t))
        slip = np.full(len(t), np.nan) if self.silent else 1.0 - speed / wheel
        told = {"speed_mps": np.full(len(t), np.nan) if self.silent else speed}
        told |= {"wheel_speed_mps": wheel, "slip_sd": np.full(len(t), self.slip_sd)}
        return None, {"epoch_ns": epoch_ns, "slip": slip, **told}


def log(streams=STREAMS):
    return Log(streams=streams, setup=SETUP)


@pytest.mark.parametrize(
    ("hidden_s", "period_s"), [(1.0, 5.0), (10.0, 40.0), (30.0, 80.0), (60.0, 140.0)]
)
def test_gnss_is_seen_again_for_longer_than_it_was_hidden(hidden_s, period_s):
    assert hidden.period_s(hidden_s) == period_s


def test_what_is_hidden_is_gone_and_nothing_else():
    for start_ns in hidden.passes(SETUP, STREAMS, 10.0):
        seen = hidden.without_gnss(STREAMS, start_ns, 10.0)
        t = STREAMS["gnss"]["epoch_ns"]
        gone = np.setdiff1d(t, seen["gnss"]["epoch_ns"])
        within = (t[:, None] > start_ns) & (t[:, None] <= start_ns + 10_000_000_000)
        assert np.array_equal(gone, t[within.any(axis=1)])
        assert seen["wheels"].keys() == STREAMS["wheels"].keys()
        assert start_ns[0] >= t[0] + 30_000_000_000
        assert start_ns[-1] + 10_000_000_000 <= t[-1]


def test_a_short_log_is_passed_again_with_its_places_shifted():
    starts = [s for start_ns in hidden.passes(SETUP, STREAMS, 10.0) for s in start_ns]
    assert len(starts) > 10
    assert len(set(starts)) == len(starts)


def test_the_score_is_the_error_that_was_made():
    estimators = {"right": Holds(), "off": Holds(off_mps=0.1), "silent": Holds(silent=True)}
    found = {each["estimator"]: each for each in hidden_scores(log(), estimators, [10.0])}
    assert found["right"]["speed_rms_mps"] == pytest.approx(0.0, abs=1e-6)
    assert found["off"]["speed_rms_mps"] == pytest.approx(0.1, abs=1e-6)
    assert found["off"]["slip_rms"] == pytest.approx(0.1 * 0.88 / 1.6, rel=0.1)
    assert found["silent"]["speed_rms_mps"] is None
    assert found["right"]["in_2sd"] == 1.0
    assert found["right"]["n"] == found["off"]["n"] > 10
    assert set(found["off"]) == {
        "estimator", "hidden_s", "n", "speed_rms_mps", "slip_rms", "in_2sd", "phases",
    }  # fmt: skip


@pytest.mark.parametrize("ends", [False, True])
def test_an_estimator_without_a_row_in_a_hidden_time_is_silent_there(ends):
    """What it says before or after it, with GNSS to see, is no prediction."""
    _, table = Holds().run(None, STREAMS)
    start_ns = next(hidden.passes(SETUP, STREAMS, 10.0))
    place = hidden.place_of(table["epoch_ns"], start_ns, 10.0)
    kept = (table["epoch_ns"] <= start_ns[1]) if ends else (place != 1)
    table = {name: column[kept] for name, column in table.items()}
    speed, slip, squared = hidden.errors(SETUP, STREAMS, table, start_ns, 10.0)
    silent = np.arange(len(start_ns)) >= 1 if ends else np.arange(len(start_ns)) == 1
    for error in (speed, slip, squared):
        assert np.array_equal(np.isnan(error), silent)


def test_the_receiver_s_own_noise_counts():
    """Off by 0.05 m/s, 0.03 of slip, with an sd of 0.01: the receiver's 0.03 m/s are 0.016."""
    sure = hidden_scores(log(), {"sure": Holds(off_mps=0.05)}, [10.0])[0]
    assert sure["in_2sd"] > 0.9
    told = dataclasses.replace(SETUP, gnss=dataclasses.replace(SETUP.gnss, velocity_sd_mps=1e-3))
    quiet = Log(streams=STREAMS, setup=told)
    assert hidden_scores(quiet, {"sure": Holds(off_mps=0.05)}, [10.0])[0]["in_2sd"] < 0.1


def test_the_antennas_may_stand_across():
    across = dataclasses.replace(
        SETUP, gnss=dataclasses.replace(SETUP.gnss, heading_mount_rad=np.pi / 2)
    )
    gnss = dict(STREAMS["gnss"])
    gnss["heading_rad"] = gnss["heading_rad"] + np.pi / 2
    turned = Streams({**STREAMS.tables, "gnss": gnss})
    assert hidden.speeds(across, turned) == pytest.approx(hidden.speeds(SETUP, STREAMS), abs=1e-9)


def test_a_log_that_stands_has_no_places_to_score():
    still = drives.Drive(duration_s=120.0, speed=lambda t: 0.0 * t, slip=lambda t: 0.0 * t)
    found = hidden_scores(log(drives.streams(still, SETUP)), {"ratio": RATIO}, [10.0])
    assert found[0]["n"] == 0
    assert found[0]["speed_rms_mps"] is None


@pytest.mark.parametrize("hidden_s", [0.0, -1.0, float("nan"), 1e9, 100.0])
def test_a_time_that_cannot_be_hidden_is_said(hidden_s):
    with pytest.raises(BadInput, match="--hide"):
        hidden_scores(log(), {"ratio": RATIO}, [hidden_s])


def test_a_log_without_gnss_is_said():
    with pytest.raises(BadInput, match="GNSS"):
        hidden_scores(log(Streams({"wheels": STREAMS["wheels"]})), {"ratio": RATIO}, [10.0])
