"""Slip-and-draft and speed-and-depth control: the laws, and what is made of two passes."""

import numpy as np
import pytest

from twin.control.draft_mix import DraftMix
from twin.errors import BadInput
from twin.reproduce import slip_and_draft, speed_and_depth
from twin.reproduce.controlled_pass import Worked
from twin.reproduce.slip_and_draft import LEAST_SHARE, SlipAndDraft
from twin.reproduce.speed_and_depth import SpeedAndDepth

VALVE = DraftMix(throttle=0.3, trim_m=0.0, mix=1.0, held_n=1e4, sensitivity_m=0.08)


def seen(slip):
    columns = {"slip": slip, "slip_target": 0.12, "depth_m": 0.2, "depth_target_m": 0.2,
               "draft_pin_n": 1e4}  # fmt: skip
    return {name: np.array([value]) for name, value in columns.items()}


def passed(slip, speed_mps=1.5):
    whole = np.full(7000, slip)
    return Worked(
        slip=whole, depth_m=whole * 0.0 + 0.2, speed_mps=whole * 0.0 + speed_mps,
        fuel_lph=whole * 0.0 + 10.0, width_m=1.0,
    )  # fmt: skip


@pytest.mark.parametrize(("slip", "share"), [(0.18, 1.0), (0.10, 1.0), (0.30, np.exp(-0.6))])
def test_slip_above_its_band_lowers_the_draft_that_is_held(slip, share):
    law = SlipAndDraft(valve=VALVE)
    state = law.init(1)
    for _ in range(50):
        state, levers = law.act(state, seen(slip), 0.02)
    assert state.share[0] == pytest.approx(share)
    assert levers.shape == (1, 2)


def test_the_draft_comes_back_below_the_band_and_has_a_floor():
    law = SlipAndDraft(valve=VALVE)
    state, full = law.act(law.init(1), seen(0.18), 0.02)
    for _ in range(200):
        state, lifted = law.act(state, seen(0.6), 0.02)
    assert state.share[0] == pytest.approx(LEAST_SHARE)
    assert lifted[0, 1] < full[0, 1]
    for _ in range(200):
        state, _ = law.act(state, seen(0.05), 0.02)
    assert state.share[0] == 1.0


def test_speed_and_depth_both_give_way_to_slip():
    law = SpeedAndDepth(throttle=0.2, trim_m=0.0, kp_m=0.5, ki_mps=0.0)
    (throttle, depth), (slower, shallower) = (
        law.act(law.init(1), seen(slip), 0.02)[1][0] for slip in (0.10, 0.22)
    )
    assert (throttle, slower) == (0.2, pytest.approx(-0.1))
    assert shallower < depth


def test_a_pass_knows_its_seconds_capacity_and_fuel():
    done = passed(0.25)
    assert done.seconds_slip.shape == (140,)
    assert done.capacity_haph == pytest.approx(0.54)
    assert done.fuel_lpha == pytest.approx(10.0 / 0.54)
    assert speed_and_depth.above_s(done.first(130.0)) == pytest.approx(130.0)
    with pytest.raises(BadInput, match="lasted 140 s, not 200 s; a longer course would do"):
        done.first(200.0)


def test_rows_stand_beside_what_was_published(monkeypatch):
    slips = {"draft": (0.30, 1.4), "slip and draft": (0.18, 1.5)}
    monkeypatch.setattr(slip_and_draft, "_driven", lambda mm, name, seed: passed(*slips[name]))
    rows = {(r["case"], r["quantity"]): r for r in slip_and_draft.rows(2)}
    most = rows["all depths", "slip of 95 % of the seconds, draft"]
    assert (most["ours"], most["published"]) == (pytest.approx(0.30), 0.48)
    assert rows["150 mm", "capacity gained"]["ours"] == pytest.approx(1.5 / 1.4 - 1.0)
    assert rows["all depths", "fuel per area saved"]["ours"] == pytest.approx(1.0 - 1.4 / 1.5)


def test_less_time_above_the_limit_is_told(monkeypatch):
    slips = {"without": 0.25, "from 20 % slip": 0.25, "from 12 % slip": 0.15}
    monkeypatch.setattr(speed_and_depth, "_driven", lambda name, seed: passed(slips[name]))
    rows = {(r["case"], r["quantity"]): r["ours"] for r in speed_and_depth.rows(2)}
    assert rows["without", "time above 20 % slip in 130 s"] == pytest.approx(140.0)
    assert rows["from 20 % slip", "less time above 20 % slip"] == pytest.approx(0.0)
    assert rows["from 12 % slip", "less time above 20 % slip"] == pytest.approx(1.0)
