"""Signs of speeds in logs of machines that tell only their sizes."""

import math

import numpy as np
import pytest

from estimators.ratio import RATIO
from twin.logs import read
from twin.logs.checks.reverse import signed

HZ, SLIP = 10, 0.1
RADIUS_M, COUNTS = 0.8, 1000


def speed(t):
    """Forward at 2 m/s, a stop from 20 s, backward at 1 m/s from 30 to 50 s, a stop."""
    at = [0, 19, 20, 30, 31, 49, 50, 60]
    return np.interp(t, at, [2.0, 2.0, 0.0, 0.0, -1.0, -1.0, 0.0, 0.0])


MAP = """
[log]
time = {column = "t", unit = "s"}
[gnss]
speed = {column = "v", unit = "m/s"}
course = {column = "course", unit = "deg", convention = "east"}
heading = {column = "hdg", unit = "deg", convention = "east"}
[wheels]
driven_speed = {column = "wheel", unit = "m/s"}
[setup]
machine = "test tractor"
wheelbase_m = 2.5
"""
DIRECTION = 'direction = {column = "dir", unit = "1"}\n[setup]'


def columns():
    t = np.arange(60 * HZ) / HZ
    v = speed(t)
    noise = 0.003 * np.random.default_rng(1).standard_normal((2, len(t)))
    return {
        "t": t,
        "v": np.abs(v + noise[0]),
        "course": np.where(v < 0, 210.0 + noise[1], 30.0 + noise[1]),
        "hdg": 30.0 + 10 * noise[1],
        "wheel": np.abs(v) / (1.0 - SLIP) + np.abs(noise[0]),
        "dir": np.where(v < 0, 0, 1),
    }


def log(folder, text, **changed):
    table = {k: v for k, v in (columns() | changed).items() if v is not None}
    rows = zip(*table.values(), strict=True)
    lines = [",".join(table), *(",".join(f"{cell:.5f}" for cell in row) for row in rows)]
    (folder / "log.csv").write_text("\n".join(lines))
    (folder / "map.toml").write_text(text)
    return read(folder / "log.csv", folder / "map.toml")


def slips(made):
    """Median slip of `ratio` forward and backward."""
    _, table = RATIO.run(RATIO.init(made.setup), made.streams)
    t = table["epoch_ns"] * 1e-9
    return [float(np.nanmedian(table["slip"][(t > a) & (t < b)])) for a, b in ((5, 18), (33, 48))]


def both_ways():
    return pytest.approx([SLIP, -SLIP], abs=0.01)


def test_the_heading_tells_the_sign_of_speeds_without_one(tmp_path):
    made = log(tmp_path, MAP)
    assert slips(made) == both_ways()
    assert any("speeds without a sign are taken as backward" in note for note in made.notes)


@pytest.mark.parametrize("codes", [(0, 1), (-1, 1), (-2, 5)])
def test_a_column_of_directions_tells_it_without_a_heading(tmp_path, codes):
    v = speed(columns()["t"])
    told = np.where(v < 0, *codes)
    text = (
        MAP.replace("[setup]", DIRECTION).replace("heading", "# heading").replace("course", "# c")
    )
    made = log(tmp_path, text, dir=told)
    assert slips(made) == both_ways()
    assert any("as wheels.direction says" in note for note in made.notes)


def test_a_speed_laid_along_the_heading_is_turned_with_the_wheels(tmp_path):
    text = MAP.replace("[setup]", DIRECTION).replace("course", "# course")
    made = log(tmp_path, text)
    assert slips(made) == both_ways()
    assert any("is turned to point backward" in note for note in made.notes)


def test_without_any_sign_slip_is_along_the_direction_of_travel(tmp_path):
    made = log(tmp_path, MAP.replace("heading", "# heading"))
    assert slips(made) == pytest.approx([SLIP, SLIP], abs=0.01)


def test_speeds_with_a_sign_are_left_alone(tmp_path):
    wheel = speed(columns()["t"]) / (1.0 - SLIP)
    made = log(tmp_path, MAP, wheel=wheel)
    assert slips(made) == both_ways()
    assert not any("backward" in note for note in made.notes)


def test_a_heading_that_is_the_wrong_way_round_is_noted_and_not_obeyed(tmp_path):
    made = log(tmp_path, MAP, hdg=columns()["hdg"] + 180.0)
    assert any("off by pi" in note for note in made.notes)
    assert made.streams["wheels"]["speed_rl_mps"].min() >= 0.0


def test_counts_of_one_channel_go_down_backward():
    t = np.arange(60 * HZ) / HZ
    up = np.cumsum(np.abs(speed(t))) / HZ / (2 * math.pi * RADIUS_M) * COUNTS
    stamps = np.round(t * 1e9).astype(np.int64)
    wheels = {"epoch_ns": stamps, "arrival_ns": stamps, "ticks_rl": up.astype(np.int64),
              "direction": np.where(speed(t) < 0, 0.0, 1.0)}  # fmt: skip
    tables, _ = signed({"wheels": wheels}, 0.0)
    found = tables["wheels"]["ticks_rl"]
    assert "direction" not in tables["wheels"]
    assert found.dtype == np.int64
    assert found[300] - found[-1] == up.astype(np.int64)[-1] - up.astype(np.int64)[300]


def test_what_has_no_wheels_passes():
    assert signed({}, 0.0) == ({}, [])
