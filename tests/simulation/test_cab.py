"""The driver's hands and feet, a decision at a time."""

import math

import pytest

from twin.physics.block import Key
from twin.simulation.cab import SHIFT_S, Cab, Felt, Gears, Orders, operate

DT_S = 0.02
GEARS = Gears(
    kind="powershift", ratios=(100.0, 80.0, 64.0), idle_rpm=800.0, no_load_rpm=2400.0, rim_m=0.8,
    pedal_per_mps2=0.15, reaction_s=0.5, pause_s=0.0, shifts=False,
)  # fmt: skip
DRIVES = Cab(ratio=80.0, throttle=0.5)
AHEAD = Orders(ratio=80.0, throttle=0.5)
STEADY = Felt(engine_rpm=1600.0, speed_mps=1.7, load=0.5)


def after(gears, orders, cab, felt, seconds):
    """The cab after some time in which what is felt does not change."""
    for _ in range(round(seconds / DT_S)):
        cab = operate(gears, orders, cab, felt, DT_S)
    return cab


def test_who_drives_steadily_changes_nothing():
    assert after(GEARS, AHEAD, DRIVES, STEADY, 5.0) == DRIVES


@pytest.mark.parametrize(("wanted", "next_ratio"), [(100.0, 100.0), (64.0, 64.0)])
def test_a_powershift_takes_the_next_gear_at_once_with_its_clutch_slipping(wanted, next_ratio):
    cab = operate(GEARS, AHEAD._replace(ratio=wanted), DRIVES, STEADY, DT_S)
    assert cab.ratio == next_ratio
    assert 0.0 < cab.grip < 1.0
    assert after(GEARS, AHEAD._replace(ratio=wanted), cab, STEADY, 2.0).grip == 1.0


def test_a_powershift_goes_through_the_gears_one_by_one():
    orders, cab = AHEAD._replace(ratio=64.0), DRIVES._replace(ratio=100.0)
    cab = operate(GEARS, orders, cab, STEADY, DT_S)
    assert cab.ratio == 80.0
    assert after(GEARS, orders, cab, STEADY, 0.9 * SHIFT_S).ratio == 80.0
    assert after(GEARS, orders, cab, STEADY, 1.2 * SHIFT_S).ratio == 64.0


def test_a_synchronised_gear_goes_in_with_the_clutch_open():
    gears, orders, cab = GEARS._replace(kind="synchronised"), AHEAD._replace(ratio=64.0), DRIVES
    for _ in range(200):
        new = operate(gears, orders, cab, STEADY, DT_S)
        if new.ratio != cab.ratio:
            assert cab.grip == new.grip == 0.0
        cab = new
    assert cab.ratio == 64.0
    assert cab.grip == 1.0


def test_a_stepless_ratio_moves_without_a_step_and_back_where_the_engine_lugs():
    gears = GEARS._replace(kind="cvt", ratios=(400.0, 20.0))
    cab = after(gears, AHEAD._replace(ratio=40.0), DRIVES, STEADY, 1.0)
    assert cab.ratio == pytest.approx(80.0 * math.exp(-0.35), rel=1e-6)
    lugs = Felt(engine_rpm=1200.0, speed_mps=1.7, load=1.0)
    assert operate(gears, AHEAD._replace(ratio=40.0), cab, lugs, DT_S).ratio > cab.ratio


def test_the_direction_is_changed_at_a_stand_and_nowhere_else():
    back = AHEAD._replace(way=-1)
    cab = after(GEARS, back, DRIVES, STEADY, 3.0)
    assert cab.ratio > 0.0
    assert cab.brake > 0.2
    rest = Felt(engine_rpm=800.0, speed_mps=0.0, load=0.0)
    cab = after(GEARS, back, cab, rest, 1.0)
    assert cab.ratio == -80.0


def test_the_clutch_is_opened_before_the_engine_stalls():
    stalls = Felt(engine_rpm=600.0, speed_mps=0.2, load=1.0)
    assert after(GEARS, AHEAD, DRIVES, stalls, 0.5).grip < 0.2


def test_an_engine_that_has_died_is_started_with_the_clutch_open():
    dead = Felt(engine_rpm=0.0, speed_mps=0.0, load=0.0)
    cab = operate(GEARS, AHEAD, DRIVES, dead, DT_S)
    assert (cab.key, cab.grip) == (Key.START, 0.0)
    runs = Felt(engine_rpm=790.0, speed_mps=0.0, load=0.0)
    assert operate(GEARS, AHEAD, cab, runs, DT_S).key == Key.RUN


def test_the_key_is_turned_off_at_a_stand():
    orders = AHEAD._replace(stands=True, off=True)
    assert after(GEARS, orders, DRIVES, STEADY, 3.0).key == Key.RUN
    rest = Felt(engine_rpm=800.0, speed_mps=0.0, load=0.0)
    assert after(GEARS, orders, DRIVES, rest, 2.0).key == Key.OFF


def test_who_shifts_goes_down_where_the_engine_lugs_and_up_again():
    gears = GEARS._replace(shifts=True)
    lugs = Felt(engine_rpm=1100.0, speed_mps=1.0, load=1.0)
    assert after(gears, AHEAD, DRIVES, lugs, 0.4).fewer == 0
    cab = after(gears, AHEAD, DRIVES, lugs, 0.7)
    assert (cab.fewer, cab.ratio) == (1, 100.0)
    easy = Felt(engine_rpm=1590.0, speed_mps=1.5, load=0.3)
    cab = after(gears, AHEAD, cab, easy, 3.0)
    assert (cab.fewer, cab.ratio) == (0, 80.0)


def test_a_pause_is_kept_where_the_direction_changes():
    gears, back = GEARS._replace(pause_s=1.0), AHEAD._replace(way=-1)
    rest = Felt(engine_rpm=800.0, speed_mps=0.0, load=0.0)
    assert after(gears, back, DRIVES, rest, 1.0).ratio > 0.0
    assert after(gears, back, DRIVES, rest, 1.5).ratio < 0.0
