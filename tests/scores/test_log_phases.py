"""Scores of a log with a reference: by the activities that are found in it."""

import numpy as np
import pytest

from estimators.ratio import RATIO
from twin.logs import Log
from twin.pipeline.drive import phases_of
from twin.pipeline.hidden import hidden_scores
from twin.scores import scores
from twin.scores.table import hidden_phase_rows
from twin.streams import Streams
from twin.testing import drives
from twin.trajectory.phase import Phase


@pytest.fixture(scope="module")
def log():
    """At 1 Hz: 100 s of work under load, a stop of 50 s, 100 s of road."""
    t = np.arange(250)
    stands, road = (t >= 100) & (t < 150), t >= 150
    speed = np.select([stands, road], [0.0, 6.0], 2.0)
    stamps = {"epoch_ns": t * 1_000_000_000, "arrival_ns": t * 1_000_000_000}
    wheel = speed / np.where(t < 100, 0.9, 1.0)
    streams = Streams(
        {
            "gnss": stamps | {"v_east_mps": speed, "v_north_mps": 0.0 * t},
            "wheels": stamps | {"speed_rl_mps": wheel, "speed_rr_mps": wheel},
            "machine": stamps | {"draft_pin_n": np.where(t < 100, 20e3, 500.0)},
        }
    )
    return streams, {"epoch_ns": stamps["epoch_ns"], "slip": np.where(t < 100, 0.1, 0.0)}


def test_activities_become_phases(log):
    streams, _ = log
    found = phases_of(streams, {})
    seconds = np.array([50, 120, 200]) * 1_000_000_000
    assert found.at(seconds).tolist() == [Phase.WORK, Phase.STOP, Phase.ROAD]
    assert found.rule.startswith("phases are the log's activities: standing is below 0.2 m/s")


def test_a_reference_is_scored_by_activity(log):
    streams, reference = log
    estimate = {
        **reference,
        "slip": reference["slip"] + np.where(reference["slip"] > 0, 0.01, 0.03),
    }
    table = scores.score(
        reference, {"a": estimate}, scenario="log", seed=None, driven=phases_of(streams, {}),
        window=(0.0, 300.0),
    )  # fmt: skip
    by = table["estimators"]["a"]["phases"]
    assert by["work"]["slip"]["rmse"] == pytest.approx(0.01)
    assert by["road"]["slip"]["rmse"] == pytest.approx(0.03)
    assert set(by) == {"work", "road"}


def test_nothing_measured_has_no_phases():
    assert phases_of(Streams({}), {}) is None


def test_what_is_foretold_without_gnss_is_told_by_phase():
    """Slip is foretold well at work and badly on the road; the places are those of the log."""
    drive = drives.Drive(
        duration_s=300.0, noise=0.0, ticks=False, speed=lambda t: np.where(t < 150, 2.0, 6.0)
    )
    setup = drives.setup()
    streams = drives.streams(drive, setup)
    t = np.arange(300)
    stamps = {"epoch_ns": (t + 1) * 1_000_000_000, "arrival_ns": (t + 1) * 1_000_000_000}
    machine = stamps | {"draft_pin_n": np.where(t < 150, 20e3, 500.0)}
    log = Log(streams=Streams({**streams.tables, "machine": machine}), setup=setup)
    found = hidden_scores(log, {"ratio": RATIO}, [2.0])[0]
    assert set(found["phases"]) == {"work", "road"}
    assert sum(p["n"] for p in found["phases"].values()) == found["n"]
    rows = hidden_phase_rows({"hidden": [found]})
    assert [row[:3] for row in rows] == [["ratio", "2", "work"], ["ratio", "2", "road"]]
