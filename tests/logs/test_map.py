"""A first map of logs that nobody has described."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from made_drive import SLIP, drive, written

from twin import cli
from twin.logs import found_in, paired_speeds, read
from twin.logs.mapping.guess import guesses
from twin.logs.mapping.names import quantity_of, unit_of
from twin.logs.quantities import QUANTITIES
from twin.logs.signals import Found, Signal
from twin.logs.units import UNITS

DATA = Path(__file__).parents[3] / "shared" / "data"


@pytest.mark.parametrize(
    ("name", "quantity"),
    [
        ("Latitude [deg]", "gnss.latitude"), ("lon", "gnss.longitude"), ("GPS_Speed", "gnss.speed"),
        ("SOG (kn)", "gnss.speed"), ("WheelBasedVehicleSpeed", "wheels.driven_speed"),
        ("wheel_speed_rl", "wheels.speed_rl"), ("Rear right wheel speed", "wheels.speed_rr"),
        ("Motordrehzahl", "machine.engine_speed"), ("engine_speed_rpm", "machine.engine_speed"),
        ("RPM", "machine.engine_speed"),
        ("Fuel rate [l/h]", "machine.fuel_rate"), ("YawRate", "imu.gyro_z"), ("gz", "imu.gyro_z"),
        ("heading_deg", "gnss.heading"), ("COG", "gnss.course"), ("AccX", "imu.accel_x"),
        ("draft_kN", "machine.draft_pin"), ("Zugkraft", "machine.draft_pin"),
        ("ticks_rl", "wheels.ticks_rl"), ("reference_sideslip_deg", "reference.sideslip_angle"),
        ("east_m", "gnss.east"), ("temperature", ""), ("battery_V", ""),
        ("satellites", "gnss.satellites"), ("engine_rpm", "machine.engine_speed"),
        ("GPS speed km/h", "gnss.speed"), ("v_n", "gnss.v_north"), ("yaw_rate_degps", "imu.gyro_z"),
    ],
)  # fmt: skip
def test_names(name, quantity):
    assert quantity_of(name) == quantity


@pytest.mark.parametrize(
    ("name", "kind", "unit"),
    [
        ("speed_kmh", "speed", "km/h"), ("Speed [m/s]", "speed", "m/s"), ("v_mps", "speed", "m/s"),
        ("sog (knots)", "speed", "kn"), ("yaw_rate_dps", "angular rate", "deg/s"),
        ("draft_kN", "force", "kN"), ("draft [N]", "force", "N"), ("load_pct", "ratio", "%"),
        ("heading", "angle", ""), ("gyro_x_radps", "angular rate", "rad/s"),
        ("heading_rad", "angle", "rad"), ("heading degrees_rad", "angle", "rad"),
        ("course [deg]", "angle", "deg"), ("yaw_rate_degps", "angular rate", "deg/s"),
        ("yaw rate deg/s", "angular rate", "deg/s"),
        ("v (kmh)", "speed", "km/h"), ("sog_kn", "speed", "kn"), ("draft_kn", "force", "kN"),
        ("pull_n", "force", "N"), ("axle_torque_nm", "torque", "Nm"),
        ("engine_rpm", "angular rate", "rpm"), ("fuel_lph", "fuel rate", "L/h"),
        ("hitch_m", "length", "m"), ("t_s", "time", "s"), ("t_ms", "time", "ms"),
        ("speed_ms", "speed", "m/s"), ("accel_x_mps2", "acceleration", "m/s2"),
    ],
)  # fmt: skip
def test_units_of_names(name, kind, unit):
    assert unit_of(name, tuple(UNITS[kind])) == unit


def mapped(tmp_path, path):
    out = tmp_path / "made.toml"
    assert cli.main(["map", str(path), "--out", str(out), "--quiet"]) == 0
    return read(path, out), out.read_text()


@pytest.mark.parametrize(
    ("factors", "unit"),
    [({"v": 3.6}, "km/h"), ({"v": 1 / 0.44704}, "mph"), ({"v": 1.0}, "m/s")],
)
def test_units_that_no_name_says_come_of_the_positions(tmp_path, factors, unit):
    columns = drive()
    for name, factor in factors.items():
        columns[name] = columns[name] * factor
    columns["wheel"] = columns["wheel"] / 3.6
    log, text = mapped(tmp_path, written(tmp_path, columns))
    assert f'speed = {{column = "v", unit = "{unit}"}}' in text
    ground, wheel = paired_speeds(log.streams)
    assert np.nanmedian(1.0 - ground / wheel) == pytest.approx(SLIP, abs=0.005)


def test_a_unit_that_the_name_says_stands_and_a_doubt_is_marked(tmp_path):
    columns = drive(rate_hz=10.0)
    columns["v_kmh"] = columns.pop("v")
    columns["course_rad"] = columns.pop("course")
    columns["yaw_rate_degps"] = columns.pop("yaw")
    text = text_of(written(tmp_path, columns))
    for column, unit in (("v_kmh", "km/h"), ("course_rad", "rad"), ("yaw_rate_degps", "deg/s")):
        line = next(line for line in text.splitlines() if f'"{column}"' in line)
        assert f'unit = "{unit}"' in line
        assert "# ? by its name" in line


def text_of(path):
    out = path.with_suffix(".toml")
    assert cli.main(["map", str(path), "--out", str(out), "--quiet"]) == 0
    return out.read_text()


@pytest.mark.parametrize(("mount_deg", "written_rad"), [(-90.0, -1.5708), (86.0, 1.5708)])
def test_antennas_side_by_side_are_found_and_marked(tmp_path, mount_deg, written_rad):
    columns = {name: values for name, values in drive().items() if name != "yaw"}
    columns["heading [deg]"] = np.mod(columns["course"] - mount_deg, 360.0)
    log, text = mapped(tmp_path, written(tmp_path, columns))
    line = next(line for line in text.splitlines() if line.startswith("heading_mount_rad"))
    assert "# ? " in line
    assert log.setup.gnss.heading_mount_rad == pytest.approx(written_rad, abs=1e-4)
    assert np.isfinite(log.streams["gnss"]["heading_rad"]).any()
    columns["heading [deg]"] = columns["course"]
    assert "heading_mount_rad" not in text_of(written(tmp_path, columns, "along.csv"))


@pytest.mark.parametrize(("turns", "unit"), [(157.0, "rad/s"), (1500.0, "rpm")])
def test_an_engine_speed_without_a_unit(tmp_path, turns, unit):
    columns = drive() | {"engine speed": np.linspace(0.5, 1.0, 600) * turns}
    line = next(a for a in text_of(written(tmp_path, columns)).splitlines() if "engine" in a)
    assert f'unit = "{unit}"' in line
    assert "# ? " in line


def test_the_commented_set_up_names_what_ticks_need(tmp_path):
    text = text_of(written(tmp_path, drive()))
    below = text.partition("# [setup.wheels]\n")[2]
    assert "# radius_m = " in below
    assert "# counts_per_turn = " in below
    uncommented = text.partition("[setup]")[2].replace("\n# ", "\n")
    wheels = tomllib.loads("[setup]" + uncommented)["setup"]["wheels"]
    assert wheels["counts_per_turn"] == 100


def test_every_column_of_a_stream_is_known_with_its_unit():
    for section, keys in QUANTITIES.items():
        for key, quantity in keys.items():
            name = f"{section}_{quantity.column}"
            values = np.linspace(0.1, 400.0, 50)
            signals = {"epoch_ns": Signal(np.arange(50) * 10**9), name: Signal(values)}
            made = guesses(Found(signals=signals)).quantities
            if not made:  # a map does not take one axis of a pair alone
                assert key in ("east", "north", "latitude", "longitude", "v_east", "v_north")
                continue
            assert (made[0].section, made[0].key, made[0].sure) == (section, key, True)
            assert UNITS[quantity.dimension][made[0].unit] == 1.0


def test_senses_of_angles_and_rates_come_of_the_track(tmp_path):
    columns = drive(rate_hz=10.0)
    columns["heading"] = np.angle(np.exp(1j * np.radians(90.0 - columns.pop("course"))))
    columns["yaw_rate"] = np.degrees(-columns.pop("yaw"))
    _, text = mapped(tmp_path, written(tmp_path, columns))
    assert 'heading = {column = "heading", unit = "rad", convention = "east"}' in text
    assert 'gyro_z = {column = "yaw_rate", unit = "deg/s", sign = -1}  # ?' in text


@pytest.mark.parametrize(
    ("start", "step", "unit"),
    [(0.0, 0.2, "s"), (0, 200, "ms"), (1.7e9, 0.2, "s"), (1.7e12, 200, "ms"), (1.7e15, 2e5, "us")],
)
def test_the_unit_of_time(tmp_path, start, step, unit):
    columns = drive()
    columns["t"] = start + step * np.arange(600)
    if unit != "s":
        columns["t"] = columns["t"].astype(np.int64).astype(str).astype(object)
    assert guesses(found_in(written(tmp_path, columns))).time.unit == unit


@pytest.mark.skipif(not DATA.exists(), reason="the logs are not beside the checkout")
@pytest.mark.parametrize("name", ["t7165s_field.csv", "jd5055e_bus.candump"])
def test_real_logs_run_with_the_first_map(tmp_path, name):
    if name.endswith("candump"):
        pytest.importorskip("can")
    log, text = mapped(tmp_path, DATA / name)
    assert "# ?" not in text.partition("\n")[2]
    assert "wheels" in log.streams


def test_the_list_and_refusals(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = written(tmp_path, drive())
    assert cli.main(["map", str(path)]) == 0
    out = capsys.readouterr().out
    assert "gnss.latitude [deg]" in out
    assert "log.toml: " in out
    assert cli.main(["map", str(path)]) == 2
    assert "log.toml exists" in capsys.readouterr().err
    assert cli.main(["map", "none.csv", "--out", "x.toml"]) == 2
    assert not (tmp_path / "x.toml").exists()
