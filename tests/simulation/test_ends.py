"""Every drive says how, when and where it ended."""

import dataclasses
from dataclasses import replace

import numpy as np
import pytest

from tests.simulation.rigs import BARE, PLOUGHING, bare_rig, field, soiled
from twin.pipeline import named as registry
from twin.scenario import Course, Drive, Plough
from twin.simulation.build import build
from twin.simulation.ends import LEFT_M, EndMonitor, Progress, stance
from twin.simulation.simulate import simulate
from twin.trajectory.end import LOOK_BACK_S, STUCK_SLIP, End, Outcome

PERIOD_S = 0.02
UPRIGHT = (0.0, 0.0, 1.0)


def ended(scenario, **how):
    """The end of a drive, which only its last chunk tells."""
    *before, last = simulate(build(scenario), **how)
    assert all(chunk.end is None for chunk in before)
    assert last.end.time_s == pytest.approx(1e-9 * last.epoch_ns[-1] + scenario.timestep_s)
    return last.end


def leaning(roll_deg=0.0, pitch_deg=0.0):
    """The direction against gravity in the axes of a body that leans."""
    roll, pitch = np.radians([roll_deg, pitch_deg])
    up = -np.sin(pitch), np.cos(pitch) * np.sin(roll), np.cos(pitch) * np.cos(roll)
    return tuple(map(float, up))


PLATFORM = registry.load("scenario", "slope-18-dry")
FREE = replace(PLATFORM, course=replace(PLATFORM.course, calibration_m=0.0))
PLANNED = {
    "a course": (BARE, Outcome.DRIVEN),
    "a ploughed course": (PLOUGHING, Outcome.DRIVEN),
    "a platform": (FREE, Outcome.EDGE),
    "a platform too wide to leave": (
        replace(FREE, course=replace(FREE.course, edge_m=100.0, length_m=2.0)), Outcome.DRIVEN,
    ),
}  # fmt: skip
DEEP = replace(PLOUGHING, plough=Plough(depth_m=0.35))
SLIPPERY = field(soiled(BARE, friction=0.1), cross_slope_deg=25.0)
FLOATING = replace(PLOUGHING, plough=Plough(hitch="float"))
EARLY = {
    "soil that does not bear": (soiled(PLOUGHING, cone_index_kpa=50.0), Outcome.STUCK),
    "a floating plough in hard soil": (soiled(FLOATING, draft_scale=1.6), Outcome.STUCK),
    "uphill without grip": (field(soiled(BARE, friction=0.1), grade_deg=15.0), Outcome.STUCK),
    "downhill without grip": (
        field(soiled(BARE, friction=0.1), grade_deg=-15.0), Outcome.SLID,
    ),
    "twice the draft": (soiled(DEEP, draft_scale=2.0), Outcome.STUCK),
    "too tall a gear": (replace(PLOUGHING, drive=Drive(gear_ratio=20.0)), Outcome.STALLED),
    "a slope without grip": (SLIPPERY, Outcome.LEFT_LINE),
    "a plough that hangs on its wheel": (
        replace(PLOUGHING, plough=Plough(depth_m=0.05, wheel_share=1.0)), Outcome.SHALLOW,
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", PLANNED)
def test_a_course_that_is_driven_is_said_to_be(what):
    scenario, outcome = PLANNED[what]
    end = ended(scenario)
    assert end.outcome is outcome
    assert end.as_planned
    assert str(end).startswith("course driven")


@pytest.mark.parametrize("what", EARLY)
def test_what_goes_wrong_is_named_with_its_time_and_place(what):
    scenario, outcome = EARLY[what]
    if outcome is not Outcome.SHALLOW:
        scenario = replace(scenario, course=Course(approach_m=2.0, length_m=200.0))
    end = ended(scenario)
    assert end.outcome is outcome
    assert not end.as_planned
    assert end.early is (outcome is not Outcome.SHALLOW)
    assert f"{outcome}" in str(end)
    if end.early:
        assert f"at {end.time_s:.1f} s, {end.along_m:.1f} m along the course" in str(end)
    low, high = {
        Outcome.STUCK: (STUCK_SLIP, 2.0), Outcome.STALLED: (-1.0, 0.25),
        Outcome.SLID: (-1.0, -STUCK_SLIP), Outcome.LEFT_LINE: (LEFT_M, LEFT_M + 0.5),
        Outcome.SHALLOW: (0.0, 0.95 * 0.05),
    }[outcome]  # fmt: skip
    assert low < end.measured < high


@pytest.mark.parametrize("roll_deg", [60.0, 180.0])
def test_a_tractor_on_its_side_has_rolled_over(roll_deg):
    """Turned about its own axis and dropped from high enough to be clear of the ground."""
    machine = bare_rig()
    qpos = machine.start_qpos.copy()
    half = np.radians(roll_deg) / 2.0
    qpos[2] += 1.0
    qpos[3:7] = np.cos(half), np.sin(half), 0.0, 0.0
    *_, last = simulate(dataclasses.replace(machine, start_qpos=qpos))
    assert last.end.outcome is Outcome.ROLLED_OVER
    assert last.end.measured == pytest.approx(roll_deg, abs=2.0)
    assert str(last.end).startswith("rolled over at 0.0 s")


def test_where_the_line_need_not_be_held_the_tractor_may_slide_aside():
    free = replace(SLIPPERY, course=Course(approach_m=0.0, length_m=6.0, hold_line=False))
    end = ended(free)
    assert abs(end.left_m) > LEFT_M
    assert end.outcome is Outcome.DRIVEN


def test_to_begin_far_beside_the_line_is_not_to_have_left_it():
    far = Course(approach_m=3.0, length_m=40.0, start_left_m=LEFT_M + 1.0)
    assert ended(replace(BARE, course=far)).outcome is Outcome.DRIVEN


@pytest.mark.parametrize("what", ["a floating plough in hard soil", "a slope without grip"])
def test_an_end_does_not_depend_on_how_the_drive_is_cut(what):
    scenario, _ = EARLY[what]
    assert ended(scenario) == ended(scenario, chunk_decisions=7)


def test_it_falls_where_the_plumb_line_leaves_the_wheels():
    """atan of half the track, or of the distance to an axle, over the height of the centre."""
    stand = stance(bare_rig())
    sideways = np.degrees(np.arctan(stand.half_track_m / stand.height_m))
    back = np.degrees(np.arctan(stand.ahead_m / stand.height_m))
    ahead = np.degrees(np.arctan((stand.wheelbase_m - stand.ahead_m) / stand.height_m))
    assert 35.0 < sideways < 50.0
    for sign in (-1.0, 1.0):
        assert not stand.falls(leaning(roll_deg=sign * (sideways - 0.1)))
        assert stand.falls(leaning(roll_deg=sign * (sideways + 0.1)))
    assert not stand.falls(leaning(pitch_deg=-(back - 0.1)))
    assert stand.falls(leaning(pitch_deg=-(back + 0.1)))
    assert not stand.falls(leaning(pitch_deg=ahead - 0.1))
    assert stand.falls(leaning(pitch_deg=ahead + 0.1))
    assert stand.falls((0.0, 0.0, -1.0))


def watched(moments):
    """The first early end in moments, and its time; None where there is none."""
    monitor = EndMonitor(bare_rig(), PERIOD_S)
    for count, moment in enumerate(moments, start=1):
        if (found := monitor.look(moment)) is not None:
            return found[0], count * PERIOD_S
    return None


def rolling(slip, time_s, rim_mps=2.0, left_m=0.0, follows=True, start_m=0.0, engine_rpm=1600.0):
    """Moments of a drive with a slip that stays."""
    hub_mps = rim_mps * (1.0 - slip)
    return [
        Progress(
            along_m=start_m + hub_mps * PERIOD_S * i, left_m=left_m, follows=follows,
            up_b=UPRIGHT, rim_mps=rim_mps, hub_mps=hub_mps, engine_rpm=engine_rpm,
        )
        for i in range(1, round(time_s / PERIOD_S) + 1)
    ]  # fmt: skip


@pytest.mark.parametrize("slip", [0.62, 0.8, 0.9])
def test_wheels_that_spin_for_five_seconds_are_stuck_however_fast(slip):
    assert watched(rolling(slip, 20.0)) == (Outcome.STUCK, pytest.approx(LOOK_BACK_S))


@pytest.mark.parametrize("hub_mps", [5.1, 20.0])
def test_wheels_that_skid_for_five_seconds_do_not_hold_it(hub_mps):
    slid = rolling(1.0 - hub_mps / 2.0, 20.0)
    assert watched(slid) == (Outcome.SLID, pytest.approx(LOOK_BACK_S))
    assert watched(rolling(1.0 - 4.9 / 2.0, 20.0)) is None  # (2 - 4.9) / 4.9 = -0.59


@pytest.mark.parametrize("slip", [-0.5, 0.0, 0.3, 0.58])
def test_wheels_that_still_pull_drive_on(slip):
    assert watched(rolling(slip, 20.0)) is None


def test_wheels_that_take_hold_again_were_not_stuck():
    spun, pulls = rolling(0.95, 4.0), rolling(0.1, 20.0, start_m=0.4)
    assert watched([*spun, *pulls]) is None


def test_wheels_that_stand_have_stalled_and_not_spun():
    drives, stands = rolling(0.1, 10.0), rolling(0.0, 20.0, rim_mps=0.0, start_m=18.0)
    outcome, at_s = watched([*drives, *stands])
    assert outcome is Outcome.STALLED
    assert at_s == pytest.approx(10.0 + LOOK_BACK_S, abs=0.3)


def test_an_engine_far_above_its_no_load_speed_for_a_second_has_run_away():
    limit_rpm = 1.15 * bare_rig().numbers["engine.no_load_rpm"]
    fast = rolling(0.0, 20.0, engine_rpm=limit_rpm + 1.0)
    assert watched(fast) == (Outcome.RAN_AWAY, pytest.approx(1.0, abs=2.1 * PERIOD_S))
    assert watched(rolling(0.0, 20.0, engine_rpm=limit_rpm - 1.0)) is None
    assert watched([*fast[:40], *rolling(0.0, 0.1, start_m=1.6), *fast[40:80]]) is None


def test_on_a_headland_a_tractor_may_be_beside_its_leg():
    near, off = rolling(0.0, 1.0), 2.0 * LEFT_M
    on_line = rolling(0.0, 1.0, left_m=off, start_m=2.0)
    turning = rolling(0.0, 1.0, left_m=off, start_m=2.0, follows=False)
    assert watched([*near, *on_line])[0] is Outcome.LEFT_LINE
    assert watched([*near, *turning]) is None


@pytest.mark.parametrize("outcome", Outcome)
def test_an_end_is_a_sentence_and_plain_values(outcome):
    end = End(outcome=outcome, time_s=12.34, along_m=14.21, left_m=-25.1, measured=0.91)
    plain = end.plain()
    assert plain["outcome"] == outcome
    assert plain["unit"] in ("m", "1", "deg", "rpm")
    assert str(end).startswith(str(outcome))
    assert plain["as_planned"] is str(end).startswith("course driven")
