"""The oracle: hats, plans, a search that does not get worse, and shares of its headroom."""

import gzip
import json

import numpy as np
import pytest

from twin.control import compare, front, oracle, plans, regret
from twin.control.plans import KNOT_S, Plans, between, shipped
from twin.control.trials import ENVIRONMENTS
from twin.errors import BadInput


@pytest.mark.parametrize("count", [1, 3, 6])
def test_hats_add_up_to_one_and_each_has_a_top(count):
    shape = oracle.hats(count, 41)
    np.testing.assert_allclose(shape.sum(axis=1), 1.0)
    if count in (1, 3, 6) and 40 % max(count - 1, 1) == 0:
        np.testing.assert_allclose(shape.max(axis=0), 1.0)


def test_a_plan_is_linear_between_its_knots_and_holds_its_last():
    knots = np.array([[[0.0, 1.0], [1.0, 0.0], [0.5, 0.5]]])
    np.testing.assert_allclose(between(knots, 0.5 * KNOT_S), [[0.5, 0.5]])
    np.testing.assert_allclose(between(knots, KNOT_S), [[1.0, 0.0]])
    np.testing.assert_allclose(between(knots, 99.0), [[0.5, 0.5]])


def test_plans_of_fewer_grounds_than_tractors_are_refused():
    with pytest.raises(BadInput, match="--episodes 2 would do"):
        Plans(np.zeros((2, 3, 4))).init(3)


def test_a_search_finds_no_worse_than_it_begins_with_and_its_plan_repeats(monkeypatch):
    monkeypatch.setattr(oracle, "DURATION_S", 3.0)
    kind, baselines = ENVIRONMENTS["WheelSlip-v1"]
    episodes = kind(6, observation="truth", nthread=1).episodes
    on = oracle.held_out(episodes, 0, 2)
    _, knots = oracle.reached(episodes, on * 3, baselines["pi"])
    search = oracle.Search((0.2, 0.2), 3, 2, 1, ((1, 2, 1.0), (3, 1, 0.5)))
    first = oracle.reached(episodes, on * 3, Plans(knots.round(oracle.DECIMALS)))[0][:2]
    with_pi, _ = oracle.reached(episodes, on * 3, baselines["pi"])
    own, did = oracle.tuned(episodes, on, baselines["pi"], search, np.random.default_rng(0))
    assert np.all(own >= with_pi[:2])
    assert did.shape == knots[:2].shape
    most, best = oracle.plan(episodes, on, knots[:2], search, np.random.default_rng(0))
    assert np.all(most >= first)
    again, _ = oracle.reached(episodes, on * 3, Plans(np.tile(best, (3, 1, 1))))
    np.testing.assert_array_equal(again[:2], most)


def test_what_is_written_is_read(tmp_path, monkeypatch):
    monkeypatch.setattr(plans, "FOLDER", tmp_path)
    knots = np.random.default_rng(0).uniform(-1.0, 1.0, (2, 3, 4)).round(oracle.DECIMALS)
    content = oracle.written("Plough-v1", knots, oracle.SEARCHES["Plough-v1"])
    assert content == oracle.written("Plough-v1", knots, oracle.SEARCHES["Plough-v1"])
    (tmp_path / "Plough-v1.json.gz").write_bytes(content)
    np.testing.assert_array_equal(shipped("Plough-v1").knots, knots)
    assert json.loads(gzip.decompress(content))["schema"] == 1
    assert shipped("Plough-v0") is None


def test_shares_of_the_headroom():
    """The PI has none of it, the oracle all, and half of it everywhere leaves no interval."""
    headroom = np.array([0.1, 0.3, 0.2, 0.4])
    half = regret.share(0.5 * headroom, headroom)
    assert half.mean == pytest.approx(0.5)
    assert half.half == pytest.approx(0.0, abs=1e-12)
    assert regret.share(headroom, headroom).mean == 1.0
    wide = regret.share(np.array([0.2, 0.0, 0.3, 0.1]), headroom)
    assert wide.low < wide.mean < wide.high


def test_rows_stand_over_all_grounds_and_by_tier():
    rewards = {
        "pi": np.zeros(4), "oracle": np.array([0.1, 0.3, 0.2, 0.4]), "mine": np.full(4, 0.1),
    }  # fmt: skip
    rows = regret.regret_rows(rewards, np.array(["easy", "hard", "easy", "hard"]))
    said = {(row["case"], row["quantity"]): row["ours"] for row in rows}
    assert said["oracle", f"{regret.HEADROOM} (all, 4)"] == pytest.approx(0.25)
    assert said["mine", f"{regret.SHARE} (easy, 2)"] == pytest.approx(0.1 / 0.15)
    assert said["mine", f"{regret.SHARE} (hard, 2)"] == pytest.approx(0.1 / 0.35)


def test_tiers():
    assert regret.patchy({"field.patches": ()}) == "no patch"
    assert regret.steep({"field.cross_slope_deg": -12.0}) == "above 10 deg"


@pytest.mark.parametrize("name", oracle.SEARCHES)
def test_the_shipped_plans_are_of_all_held_out_grounds(name):
    found = shipped(name)
    assert found is not None
    assert found.knots.shape[:2] == (oracle.GROUNDS, round(plans.DURATION_S / KNOT_S) + 1)
    assert np.abs(found.knots).max() <= 1.0
    controllers = {"pi": ENVIRONMENTS[name][1]["pi"]}
    assert "oracle" in compare.with_oracle(controllers, name, 50, 20.0)
    assert "oracle" not in compare.with_oracle(controllers, name, 51, 20.0)
    assert "oracle" not in compare.with_oracle(controllers, name, 50, 21.0)


def test_the_front_leaves_out_what_another_beats_and_keeps_equals():
    values = np.array([[1.0, 0.0], [0.0, 1.0], [0.5, 0.0], [1.0, 0.0]])
    np.testing.assert_array_equal(front.undominated(values), [True, True, False, True])


def test_front_rows_know_what_is_asked_for():
    asked = front.OBJECTIVES["WheelSlip-v1"]
    good = {name: np.array([sign, sign]) for name, sign in asked.items()}
    bad = {name: np.array([-sign, -sign]) for name, sign in asked.items()}
    rows = front.front_rows("WheelSlip-v1", {"good": good, "bad": bad})
    assert [(row["case"], row["ours"]) for row in rows] == [("good", 1.0), ("bad", 0.0)]
    assert front.front_rows("Plough-v0", {"good": good}) == []
