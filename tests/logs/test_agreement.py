"""What does not agree is said: units, signs, columns, values that are no new measurements."""

import re

import numpy as np
import pytest
from made_drive import MAP, SLIP, drive, mapped, written

from twin.commands.run import load_estimators
from twin.errors import BadInput
from twin.logs import paired_speeds, read
from twin.pipeline.log import estimate, slip_warnings

HEADED = MAP.replace("course =", 'heading = {column = "head", unit = "deg"}\ncourse =')
IMU = '[imu]\ngyro_z = {column = "yaw", unit = "rad/s"}\n'


def notes(tmp_path, columns, text=MAP):
    return " ".join(read(written(tmp_path, columns), mapped(tmp_path, text)).notes)


def test_a_drive_that_agrees_says_nothing(tmp_path):
    said = notes(tmp_path, drive(), MAP + IMU)
    assert said.startswith("setup: assumed track_front_m = ")
    assert said.endswith("imu.accel_bias_sd_mps2 = 0.1")


@pytest.mark.parametrize(
    ("column", "factor", "says"),
    [
        ("v", 1.0 / 0.514444, "kn taken for m/s"),
        ("v", 0.44704, "positions and velocity disagree"),
        ("wheel", 1.0 / 1.609344, "mph taken for km/h"),
        ("wheel", 1.4, "median slip of the raw speeds is +0.3"),
        ("t", 1e-3, "s taken for ms"),
        ("t", 60.0, "positions and velocity disagree"),
        ("yaw", -1.0, "gyro_z turns -1 times as far"),
        ("yaw", 57.3, "gyro_z turns 57.3 times as far"),
        ("yaw", 57.3, "(deg/s taken for rad/s)"),
        ("yaw", 1.0 / 57.3, "(rad/s taken for deg/s)"),
    ],
)
def test_a_wrong_unit_or_sign(tmp_path, column, factor, says):
    columns = drive()
    columns[column] = columns[column] * factor
    if column == "v":
        columns["wheel"] = columns["wheel"] * factor
    assert says in notes(tmp_path, columns, MAP + IMU)


@pytest.mark.parametrize(("factor", "says"), [
    (57.3, "deg/s taken for rad/s"), (1.0 / 57.3, "rad/s taken for deg/s"), (1.0, ""),
])  # fmt: skip
def test_a_gyro_on_a_drive_without_a_turn(tmp_path, factor, says):
    generator = np.random.default_rng(0)
    columns = drive()
    t = columns["t"]
    columns["head"] = 40.0 + 3.0 * np.sin(t / 4.0) + 0.1 * generator.normal(size=len(t))
    columns["rate_mradps"] = 1e3 * factor * np.radians(-0.75 * np.cos(t / 4.0))
    text = HEADED
    for name in ("lat", "lon"):
        text = "\n".join(line for line in text.splitlines() if f'"{name}"' not in line)
    rate = '\n[imu]\ngyro_z = {column = "rate_mradps", unit = "mrad/s"}\n'
    said = notes(tmp_path, columns, text + rate)
    assert ("gyro_z turns" in said) == bool(says)
    assert says in said


@pytest.mark.parametrize(("unit", "says"), [
    ("rad/s", ""), ("deg/s", "26.3 rpm at the median on the move, and"),
    ("rpm", "(rad/s taken for rpm would make it 1509 rpm)"),
])  # fmt: skip
def test_an_engine_that_turns_as_none_does(tmp_path, unit, says):
    columns = drive() | {"n": np.full(600, 158.0)}
    machine = f'[machine]\nengine_speed = {{column = "n", unit = "{unit}"}}\n'
    said = notes(tmp_path, columns, MAP + machine)
    assert ("engine_speed" in said) == (unit != "rad/s")
    assert says in said


def test_an_engine_that_stands_is_no_wrong_unit(tmp_path):
    columns = drive() | {"n": np.zeros(600)}
    machine = '[machine]\nengine_speed = {column = "n", unit = "rpm"}\n'
    assert "engine_speed" not in notes(tmp_path, columns, MAP + machine)


def test_swapped_columns_and_conventions(tmp_path):
    columns = drive()
    swapped = {**columns, "lat": columns["lon"], "lon": columns["lat"]}
    assert "are latitude and longitude swapped" in notes(tmp_path, swapped)
    east = MAP.replace('"course", unit = "deg"', '"course", unit = "deg", convention = "east"')
    assert "disagree in direction" in notes(tmp_path, columns, east)
    off = {**columns, "head": np.mod(columns["course"] + 90.0, 360.0)}
    text = MAP.replace("course =", 'heading = {column = "head", unit = "deg"}\ncourse =')
    assert "heading and course are 90 deg apart" in notes(tmp_path, off, text)
    assert "apart" not in notes(
        tmp_path, off, text + "[setup.gnss]\nheading_mount_rad = -1.5707963\n"
    )


def across(columns, mount_deg):
    return {**columns, "head": np.mod(columns["course"] - mount_deg, 360.0)}


@pytest.mark.parametrize("mount_deg", [-90.0, 90.0, 70.0, -110.0])
def test_a_heading_across_the_course_is_not_used(tmp_path, mount_deg):
    path = written(tmp_path, across(drive(), mount_deg))
    result = estimate(path, mapped(tmp_path, HEADED), estimators=load_estimators("ratio"))
    assert result.found["slip"]["ratio"]["median"] == pytest.approx(SLIP, abs=0.01)
    (note,) = (n for n in result.notes if "the heading is not used" in n)
    told = float(re.search(r"heading_mount_rad = (\S+) in", note)[1])
    assert told == pytest.approx(np.radians(mount_deg), abs=1e-3)
    log = read(path, mapped(tmp_path, f"{HEADED}[setup.gnss]\nheading_mount_rad = {told}\n"))
    assert np.isfinite(log.streams["gnss"]["heading_rad"]).any()


@pytest.mark.parametrize("mount_deg", [-90.0, 90.0])
def test_driving_in_reverse_hides_no_heading_across_the_course(tmp_path, mount_deg):
    columns = across(drive(), mount_deg)
    columns["course"][400:] = np.mod(columns["course"][400:] + 180.0, 360.0)
    log = read(written(tmp_path, columns), mapped(tmp_path, HEADED))
    assert "heading_rad" not in log.streams["gnss"]
    (note,) = (n for n in log.notes if "the heading is not used" in n)
    assert f"heading_mount_rad = {np.radians(mount_deg):.4f}" in note


@pytest.mark.parametrize("mount_deg", [0.0, 40.0, 180.0])
def test_a_heading_that_is_not_across_is_kept(tmp_path, mount_deg):
    log = read(written(tmp_path, across(drive(), mount_deg)), mapped(tmp_path, HEADED))
    assert np.isfinite(log.streams["gnss"]["heading_rad"]).any()


def test_a_speed_along_a_heading_whose_mount_is_given(tmp_path):
    text = "\n".join(line for line in HEADED.splitlines() if not line.startswith("course"))
    text += "\n[setup.gnss]\nheading_mount_rad = -1.5707963\n"
    log = read(written(tmp_path, across(drive(), -90.0)), mapped(tmp_path, text))
    assert np.isfinite(log.streams["gnss"]["heading_rad"]).any()
    assert not any("disagree" in note or "apart" in note for note in log.notes)


def test_a_slip_beyond_belief_is_said_of_all_rows_and_of_work(tmp_path):
    log = read(written(tmp_path, drive()), mapped(tmp_path))
    epoch_ns = log.streams["wheels"]["epoch_ns"]
    n = len(epoch_ns)
    stands = {"epoch_ns": epoch_ns, "slip": np.ones(n), "speed_mps": np.full(n, 0.01)}
    said = " ".join(slip_warnings(log, {"mine": stands}))
    assert "mine: median slip +100.0 % of all rows is beyond 25 %" in said
    assert "its estimated speed stays at 0.01 m/s" in said
    assert "heading_mount_rad" in said
    fine = {**stands, "slip": np.full(n, 0.05), "speed_mps": np.full(n, 2.0)}
    assert slip_warnings(log, {"mine": fine}, {"mine": {"median": 0.1}}) == []
    (note,) = slip_warnings(log, {"mine": fine}, {"mine": {"median": 0.6}})
    assert "+60.0 % at work is beyond 25 %" in note


@pytest.mark.parametrize(("ratio", "noted"), [(4, True), (10, True), (1, False)])
def test_a_slow_source_in_a_fast_table(tmp_path, ratio, noted):
    columns = drive(rate_hz=20.0)
    held = np.arange(2400) // ratio * ratio
    for name in ("lat", "lon", "v", "course"):
        columns[name] = columns[name][held]
    log = read(written(tmp_path, columns), mapped(tmp_path))
    assert any("carried forward" in note for note in log.notes) == noted
    assert len(log.streams["gnss"]["epoch_ns"]) == 2400 // ratio


def test_a_coarse_value_is_not_taken_for_one_carried_forward(tmp_path):
    columns = drive(rate_hz=20.0)
    ramp = np.arange(2400) // 8 * 0.01
    columns = {"t": columns["t"], "v": ramp, "wheel": 3.6 * ramp / (1 - SLIP)}
    text = "\n".join(
        line for line in MAP.splitlines() if not line.startswith(("lat", "lon", "cou"))
    )
    log = read(written(tmp_path, columns), mapped(tmp_path, text))
    assert len(log.streams["gnss"]["epoch_ns"]) == 2400


@pytest.mark.parametrize("bits", [8, 10, 12, 16, 20])
@pytest.mark.parametrize("signed", [False, True])
def test_counters_of_any_size_wrap(tmp_path, bits, signed):
    columns = drive(rate_hz=20.0)
    turns = np.cumsum(columns["wheel"] / 3.6) / 20.0 / (2 * np.pi * 0.8)
    counts = np.round(turns * (60 if bits == 8 else 720 if bits < 16 else 200_000)).astype(int)
    size = 2**bits
    wrapped = (counts + 77) % size
    columns["n"] = np.where(wrapped >= size // 2, wrapped - size, wrapped) if signed else wrapped
    text = MAP.replace('driven_speed = {column = "wheel", unit = "km/h"}',
                       'ticks_rl = {column = "n", unit = "1"}')  # fmt: skip
    log = read(written(tmp_path, columns), mapped(tmp_path, text))
    found = log.streams["wheels"]["ticks_rl"]
    np.testing.assert_array_equal(np.diff(found), np.diff(counts))
    assert any(f"a counter of {bits} bits unwrapped" in note for note in log.notes)


def test_a_counter_that_begins_anew_and_one_wrong_count(tmp_path):
    columns = drive(rate_hz=20.0)
    counts = np.cumsum(np.round(columns["wheel"])).astype(int)
    counts[1000:] -= counts[1000]
    counts[500] = 60_000_000
    columns["n"] = counts
    text = MAP.replace('driven_speed = {column = "wheel", unit = "km/h"}',
                       'ticks_rl = {column = "n", unit = "counts"}')  # fmt: skip
    log = read(written(tmp_path, columns), mapped(tmp_path, text))
    step = np.diff(log.streams["wheels"]["ticks_rl"])
    assert len(step) == 2398
    assert step.min() >= 0
    assert step.max() < 30
    said = " ".join(log.notes)
    assert "begins anew 1 times" in said
    assert "a single count far from its neighbours" in said
    assert "counts_per_turn" in said


def test_wheels_below_their_cut_off_are_unknown(tmp_path):
    columns = drive()
    columns["wheel"] = np.where(columns["wheel"] < 6.0, 0.0, columns["wheel"])
    log = read(written(tmp_path, columns), mapped(tmp_path))
    ground, wheel = paired_speeds(log.streams)
    assert np.all(wheel > 0.0)
    assert any("below the sensor's cut-off" in note for note in log.notes)
    assert np.nanmedian(1.0 - ground / wheel) == pytest.approx(SLIP, abs=0.005)


def test_speeds_that_are_not_of_one_machine_are_refused(tmp_path):
    columns = drive()
    columns["wheel"] = columns["wheel"] * 3.6
    with pytest.raises(BadInput, match="is one of the units wrong"):
        read(written(tmp_path, columns), mapped(tmp_path))


@pytest.mark.parametrize("column", ["v", "wheel", "lat"])
@pytest.mark.parametrize("at", [0, 1, 300, 598, 599])
def test_a_spike_is_left_out(tmp_path, column, at):
    columns = drive()
    columns[column][at] *= 1.0001 if column == "lat" else 4.0
    log = read(written(tmp_path, columns), mapped(tmp_path))
    assert any("far from its neighbours" in n or "no tractor's speed" in n for n in log.notes)
    ground, wheel = paired_speeds(log.streams)
    slip = 1.0 - ground / wheel
    assert np.nanmax(np.abs(slip - SLIP)) < 0.15


def test_a_speed_without_a_direction_gives_slip(tmp_path):
    columns = drive()
    text = "\n".join(
        line for line in MAP.splitlines() if not line.startswith(("lat", "lon", "cou"))
    )
    log = read(written(tmp_path, columns), mapped(tmp_path, text))
    ground, wheel = paired_speeds(log.streams)
    assert np.nanmedian(1.0 - ground / wheel) == pytest.approx(SLIP, abs=0.005)
    assert any("stands along east" in note for note in log.notes)


@pytest.mark.parametrize("speed_mps", [0.2, 0.35, 0.55])
def test_wheels_that_read_zero_while_the_machine_creeps(tmp_path, speed_mps):
    t = np.arange(120) * 0.5
    columns = {
        "t": t, "lat": 48.0 + speed_mps * t / 111_200.0, "lon": np.full(120, 9.0),
        "v": np.full(120, speed_mps), "course": np.zeros(120), "wheel": np.zeros(120),
    }  # fmt: skip
    log = read(written(tmp_path, columns), mapped(tmp_path))
    assert "wheels" not in log.streams
    assert any("below the sensor's cut-off" in note for note in log.notes)


def test_a_machine_that_stands_has_wheels_that_stand(tmp_path):
    columns = drive()
    for name in ("v", "wheel"):
        columns[name][200:260] = 0.0
    columns["v"][200:260] = 0.02
    for name in ("lat", "lon"):
        columns[name][200:260] = columns[name][200]
    log = read(written(tmp_path, columns), mapped(tmp_path))
    assert len(log.streams["wheels"]["epoch_ns"]) == 600


def test_a_time_that_is_a_thousand_times_too_long(tmp_path):
    columns = drive(rate_hz=1.0)
    columns["t"] = columns["t"] * 1000.0
    assert "ms taken for s" in notes(tmp_path, columns)


def test_a_velocity_that_turns_is_no_spike_and_one_that_leaps_is(tmp_path):
    columns = drive(rate_hz=1.0)
    turn = np.cumsum(np.where(np.arange(120) % 17 == 0, 1.5, 0.1))
    columns["ve"], columns["vn"] = columns["v"] * np.cos(turn), columns["v"] * np.sin(turn)
    columns["ve"][60] = 25.0
    text = (
        '[log]\ntime = {column = "t", unit = "s"}\n[gnss]\nv_east = {column = "ve", unit = "m/s"}\n'
    )
    text += 'v_north = {column = "vn", unit = "m/s"}\n'
    log = read(written(tmp_path, columns), mapped(tmp_path, text))
    assert np.flatnonzero(np.isnan(log.streams["gnss"]["v_north_mps"])).tolist() in ([60], [])
    assert len(log.streams["gnss"]["epoch_ns"]) == 119
    assert any(n.startswith("1 of 120 rows left out: column 've', row 61") for n in log.notes)
