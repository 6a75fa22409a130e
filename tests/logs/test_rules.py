import numpy as np

from twin.logs.gaps import between, gap_notes
from twin.logs.rules import Rule, choose


def test_labels_speed_and_steadiness_all_count():
    epoch_ns = np.arange(6) * 10**9
    speed_mps = np.array([2.0, 2.0, 2.0, 2.5, 2.5, np.nan])
    rows = {"state": np.array(["W", "W", "T", "W", "W", "W"])}
    rule = Rule(where={"state": ("W",)}, min_speed_kmh=5.0, max_speed_change_kmhps=0.15)
    # no second before the first row; the third is T, the fourth speeds up, the last is NaN
    assert choose(rule, rows, epoch_ns, speed_mps).tolist() == [0, 1, 0, 0, 1, 0]


def test_change_is_over_a_second_whatever_the_rate():
    time_s = np.arange(0, 10, 0.02)
    speed_mps = 1.0 + 0.1 * time_s / 3.6 + np.where(np.arange(500) % 2, 0.001, -0.001)
    rule = Rule(max_speed_change_kmhps=0.15)
    chosen = choose(rule, None, np.round(time_s * 1e9).astype(np.int64), speed_mps)
    assert not chosen[:50].any()
    assert chosen[51:].all()


def test_no_past_is_made_up_across_a_gap():
    epoch_ns = np.array([0, 1, 2, 12, 13, 14]) * 10**9
    chosen = choose(Rule(max_speed_change_kmhps=1.0), None, epoch_ns, np.full(6, 2.0))
    assert chosen.tolist() == [0, 1, 1, 0, 1, 1]


def test_between_bridges_no_gap():
    time_s = np.array([0.0, 1.0, 2.0, 12.0, 13.0])
    found = between(np.array([-1.0, 0.5, 2.0, 5.0, 12.0, 12.5, 14.0]), time_s, time_s)
    np.testing.assert_array_equal(found, [np.nan, 0.5, 2.0, np.nan, 12.0, 12.5, np.nan])


def test_many_gaps_are_summed_up():
    epoch_ns = np.cumsum([1, 1, 1, 1, 1, 1, 1, 1, 9, 1, 8, 1, 7, 1, 6, 1, 5, 1, 30]) * 10**9
    notes = gap_notes("log", epoch_ns)
    assert notes[0] == "log: gap of 9.0 s at row 9"
    assert notes[-1] == "log: 1 more gaps, the longest 30.0 s"
