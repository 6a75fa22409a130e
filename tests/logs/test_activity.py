from pathlib import Path

import numpy as np
import pytest

from tests.synthetic_log import job
from twin.errors import BadInput
from twin.logs import read
from twin.logs.activity import EMPTY, STANDING, TURNING, UNKNOWN, WORKING, activity, two_groups
from twin.logs.column_map import column_map_from
from twin.logs.summary import area, highest_slip, shares
from twin.logs.timeline import timeline
from twin.streams import Streams

ROOT = Path(__file__).parents[2]
FIELD_LOG = ROOT.parent / "shared" / "data" / "t7165s_field.csv"


@pytest.mark.parametrize("pull", ["draft_pin_n", "hitch_m", "engine_load", ""])
def test_work_turns_road_and_standing_are_told_apart(pull):
    streams, estimate, kind = job(pull=pull)
    done = activity(timeline(streams, estimate))
    for name, code in (
        ("work", WORKING), ("turn", TURNING), ("road", EMPTY), ("stand", STANDING),
    ):  # fmt: skip
        assert np.mean(done[code][kind == name]) > 0.85, (name, done.rule)
    assert not done[WORKING][kind == "road"].any()
    assert not done[UNKNOWN].any()


def test_the_rule_says_what_told_work():
    streams, estimate, _ = job(pull="engine_load")
    assert "engine load above 55 %" in activity(timeline(streams, estimate)).rule
    streams, estimate, _ = job(pull="")
    assert "load" not in activity(timeline(streams, estimate)).rule


def test_a_slow_road_without_load_is_no_work():
    streams, estimate, kind = job(road_mps=3.0)
    assert not activity(timeline(streams, estimate))[WORKING][kind == "road"].any()


def test_a_load_that_does_not_vary_tells_nothing():
    assert two_groups(np.full(50, 0.8), 0.25) is None
    assert two_groups(np.array([0.1] * 20 + [0.9] * 20), 0.25) == pytest.approx(0.5)


def test_hectares_and_litres():
    streams, estimate, _ = job(passes=4)
    rows = timeline(streams, estimate)
    done = activity(rows)
    took = area(rows, done, 3.0)
    assert took.area_ha == pytest.approx(4 * 120.0 * 3.0 / 1e4, rel=0.06)
    assert took.fuel_at_work_l_per_ha == pytest.approx(25.0 / (2.0 * 3.6 * 3.0 / 10.0), rel=0.02)
    whole = {share.activity: share for share in shares(rows, done)}["all"]
    assert whole.fuel_l == pytest.approx((4 * 60 * 25.0 + (120 + 80 + 30) * 5.0) / 3600.0, rel=0.02)


def test_the_stretch_of_the_highest_slip_is_first():
    streams, estimate, _ = job()
    rows = timeline(streams, estimate)
    first = highest_slip(rows, activity(rows))[0]
    assert first.slip_median == pytest.approx(0.2)
    assert 195.0 <= first.start_s <= 205.0


@pytest.mark.parametrize("rate_hz", [0.2, 1.0, 10.0])
def test_totals_do_not_depend_on_the_rate(rate_hz):
    n = int(600 * rate_hz)
    epoch_ns = (np.arange(n) / rate_hz * 1e9).astype(np.int64)
    stamps = {"epoch_ns": epoch_ns, "arrival_ns": epoch_ns}
    gnss = {**stamps, "v_east_mps": np.full(n, 2.0), "v_north_mps": np.zeros(n)}
    rows = timeline(Streams({"gnss": gnss}))
    assert rows["duration_s"].sum() == pytest.approx(600.0, rel=0.01)
    assert shares(rows, activity(rows))[-1].distance_m == pytest.approx(1200.0, rel=0.01)


def test_a_gap_counts_no_time():
    epoch_ns = np.concatenate([np.arange(100), np.arange(4000, 4100)]) * 10**9
    stamps = {"epoch_ns": epoch_ns, "arrival_ns": epoch_ns}
    gnss = {**stamps, "v_east_mps": np.full(200, 2.0), "v_north_mps": np.zeros(200)}
    rows = timeline(Streams({"gnss": gnss}))
    assert rows["duration_s"].sum() == pytest.approx(200.0)


@pytest.mark.parametrize(
    ("width", "message"),
    [("3", "must be a number of metres"), (0.0, "is outside"), (900, "is outside"),
     (float("nan"), "is outside"), (True, "must be a number")],
)  # fmt: skip
def test_a_width_that_is_none_is_refused(width, message):
    with pytest.raises(BadInput, match=f"implement.width_m .*{message}"):
        column_map_from({"implement": {"width_m": width}})


@pytest.mark.skipif(not FIELD_LOG.exists(), reason="the field log is not beside the checkout")
def test_a_real_log_is_told_apart_as_its_maker_did():
    log = read(FIELD_LOG, ROOT / "examples" / "t7165s.toml")
    done = activity(timeline(log.streams))
    state = log.rows["state"]
    assert np.mean(state[done[WORKING]] == "W") > 0.95
    assert np.mean(done[WORKING][state == "W"]) > 0.7
    assert np.mean(done[STANDING][state == "I"]) > 0.99
