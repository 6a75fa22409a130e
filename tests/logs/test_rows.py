"""Rows are not sacred: what is left out, what is a hole, and that the rest stays right."""

import codecs
import time
import tracemalloc

import numpy as np
import pytest
from made_drive import MAP, SLIP, as_text, drive, mapped, written

from twin import cli
from twin.errors import BadInput
from twin.logs import paired_speeds, read


def slip(log):
    ground, wheel = paired_speeds(log.streams)
    return float(np.nanmedian(1.0 - ground / wheel))


def right(log):
    return slip(log) == pytest.approx(SLIP, abs=0.004)


@pytest.mark.parametrize("mark", ["NaN", "n/a", "-", "#N/A", "NULL", "", " ", "1.#QNAN", "?"])
def test_what_tables_write_for_a_hole(tmp_path, mark):
    text = as_text(drive()).split("\n")
    for row in range(20, 220):
        cells = text[row].split(",")
        cells[3] = mark
        text[row] = ",".join(cells)
    path = tmp_path / "log.csv"
    path.write_text("\n".join(text))
    log = read(path, mapped(tmp_path), strict=True)
    assert np.isnan(log.streams["gnss"]["v_east_mps"]).sum() == 200
    assert right(log)


@pytest.mark.parametrize(
    ("column", "code", "unit"),
    [
        ("wheel", 65535 / 256, "km/h"), ("wheel", 254.004, "km/h"), ("v", 65.535, "m/s"),
        ("v", -1.0, "m/s"), ("v", 655.35, "m/s"), ("v", 9999.0, "m/s"), ("course", 360.0, "deg"),
        ("course", 511.992, "deg"), ("wheel", 999.99, "km/h"), ("wheel", -9999.0, "km/h"),
    ],
)  # fmt: skip
def test_codes_are_holes_however_many_there_are(tmp_path, column, code, unit):
    columns = drive()
    columns[column] = np.where(np.arange(600) % 4 == 1, code, columns[column])
    log = read(written(tmp_path, columns), mapped(tmp_path), strict=True)
    assert any("are holes" in note for note in log.notes)
    assert right(log)


def test_a_position_of_zero_and_one_of_another_continent(tmp_path):
    columns = drive()
    columns["lat"][:5] = columns["lon"][:5] = 0.0
    columns["lat"][100], columns["lon"][100] = -33.0, 151.0
    log = read(written(tmp_path, columns), mapped(tmp_path))
    east = log.streams["gnss"]["east_m"]
    assert np.isnan(east).sum() == 6
    assert np.nanmax(np.abs(east)) < 500.0
    assert "gnss: 5 positions without a fix left out" in log.notes
    assert any("km from the first fix" in note for note in log.notes)


def test_missing_of_the_map(tmp_path):
    columns = drive()
    columns["wheel"][::3] = 7.777
    text = MAP.replace('unit = "km/h"}', 'unit = "km/h", missing = [7.777, -5]}')
    log = read(written(tmp_path, columns), mapped(tmp_path, text), strict=True)
    assert len(log.streams["wheels"]["epoch_ns"]) == 400
    assert right(log)


def test_scale_offset_and_sign(tmp_path):
    columns = drive()
    columns["wheel"] = -(columns["wheel"] - 3.0) / 0.25
    more = 'unit = "km/h", scale = 0.25, offset = -3.0, sign = -1}'
    text = MAP.replace('unit = "km/h"}', more)
    assert right(read(written(tmp_path, columns), mapped(tmp_path, text)))


@pytest.mark.parametrize(("unit", "factor"), [("rpm", 30 / np.pi), ("rad/s", 1.0)])
def test_wheel_speeds_by_their_radius(tmp_path, unit, factor):
    columns = drive()
    columns["wheel"] = columns["wheel"] / 3.6 / 0.75 * factor
    text = MAP.replace('unit = "km/h"', f'unit = "{unit}"')
    with pytest.raises(BadInput, match=r"needs the wheel's radius"):
        read(written(tmp_path, columns), mapped(tmp_path, text))
    text += "[setup.wheels]\nradius_m = {rl = 0.75, rr = 0.75}\n"
    assert right(read(written(tmp_path, columns), mapped(tmp_path, text)))


def test_body_velocity_and_axes(tmp_path):
    columns = drive()
    columns["left"] = np.full(600, 0.1)
    columns["down"] = -columns["yaw"]
    text = MAP.replace('speed = {column = "v"', 'v_left = {column = "left", unit = "m/s"}\n'
                       'v_forward = {column = "v"').replace("course = ", "heading = ")  # fmt: skip
    text += '[imu]\naxes = "FRD"\ngyro_z = {column = "down", unit = "rad/s"}\n'
    log = read(written(tmp_path, columns), mapped(tmp_path, text))
    gnss = log.streams["gnss"]
    drift = np.arctan2(gnss["v_north_mps"], gnss["v_east_mps"]) - gnss["heading_rad"]
    np.testing.assert_allclose(np.sin(drift) * np.hypot(gnss["v_east_mps"], gnss["v_north_mps"]),
                               0.1, atol=1e-6)  # fmt: skip
    np.testing.assert_allclose(log.streams["imu"]["gyro_z_radps"], columns["yaw"], atol=1e-4)
    assert not any("turns" in note for note in log.notes)


@pytest.mark.parametrize("delimiter", [",", ";", "\t", "|"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252", "utf-16-le"])
@pytest.mark.parametrize("decimal", [".", ","])
def test_however_a_table_is_written(tmp_path, delimiter, encoding, decimal):
    if decimal == delimiter:
        return
    columns = drive()
    text = as_text({**columns, "Öl °C": np.ones(600)}, delimiter, decimal)
    path = tmp_path / "log.csv"
    path.write_bytes(text.replace("\n", "\r\n").encode(encoding))
    assert right(read(path, mapped(tmp_path)))


@pytest.mark.parametrize(
    "before",
    ["sep=;\n", '"sep=;"\r\n', "Logger 7; tractor 12\nserial;17\n\n", "# made by hand\n"],
)
def test_lines_before_the_header(tmp_path, before):
    path = tmp_path / "log.csv"
    path.write_text(before + as_text(drive(), ";"))
    assert right(read(path, mapped(tmp_path)))


def test_a_row_of_units_below_the_header_and_a_delimiter_at_the_end(tmp_path):
    lines = as_text(drive()).strip().split("\n")
    lines.insert(1, "s,deg,deg,m/s,deg,km/h,rad/s")
    path = tmp_path / "log.csv"
    path.write_text("\n".join(line + ("," if i else "") for i, line in enumerate(lines)))
    log = read(path, mapped(tmp_path))
    assert right(log)
    assert any("row 1: 's' is not a number" in note for note in log.notes)


def test_a_table_without_names_has_numbers_for_them(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(as_text(drive()).partition("\n")[2])
    text = MAP
    for number, name in enumerate(("t", "lat", "lon", "v", "course", "wheel"), 1):
        text = text.replace(f'column = "{name}"', f'column = "{number}"')
    assert right(read(path, mapped(tmp_path, text)))


@pytest.mark.parametrize(
    "end",
    [b"\0" * 500, b"\0\0\0\n", b"600.0,48.0", b",,,,,,\n,,,,,,\n,,,,,,\n,,,,,,\n,,,,,,\n", b'1,"2'],
)
def test_what_a_power_cut_leaves_at_the_end(tmp_path, end):
    path = written(tmp_path, drive())
    path.write_bytes(path.read_bytes() + end)
    log = read(path, mapped(tmp_path))
    assert len(log.streams["wheels"]["epoch_ns"]) == 600
    assert right(log)


@pytest.mark.parametrize("where", [0, 300, 599])
def test_a_byte_that_is_no_text(tmp_path, where):
    path = written(tmp_path, drive())
    lines = path.read_bytes().split(b"\n")
    lines[where + 1] = lines[where + 1][:10] + b"\xff\xfe" + lines[where + 1][12:]
    path.write_bytes(b"\n".join(lines))
    assert right(read(path, mapped(tmp_path)))


@pytest.mark.parametrize(
    ("change", "left"),
    [
        (lambda t: np.r_[t[:300], t[299:300], t[300:]], 600),
        (lambda t: np.r_[t[:300], t[301:302], t[300:301], t[302:]], 599),
        (lambda t: np.r_[t[:300], 9e5, t[301:]], 599),
        (lambda t: np.r_[t[:300], -1.0, t[301:]], 599),
    ],
)
def test_stamps_repeated_and_out_of_order(tmp_path, change, left):
    columns = drive()
    times = change(columns["t"])
    columns = {k: np.resize(np.r_[v, v[-1:]], len(times)) for k, v in columns.items()}
    columns["t"] = times
    log = read(written(tmp_path, columns), mapped(tmp_path))
    assert len(log.streams["wheels"]["epoch_ns"]) == left
    with pytest.raises(BadInput, match=r"time .* s (is repeated|beside .*: out of order)"):
        read(tmp_path / "log.csv", mapped(tmp_path), strict=True)


def test_many_bad_stamps_say_what_to_do(tmp_path):
    columns = drive()
    columns["t"] = np.floor(columns["t"])
    with pytest.raises(BadInput, match="each stamp stands on 5 rows: give finer stamps"):
        read(written(tmp_path, columns), mapped(tmp_path))
    columns = drive()
    columns["t"][200:] -= 30.0
    with pytest.raises(BadInput, match="the clock goes back at row 201: cut the log there"):
        read(written(tmp_path, columns), mapped(tmp_path))


@pytest.mark.parametrize("by_s", [0.45, 4.0])
def test_a_clock_that_is_set_back_once_costs_the_rows_until_it_has_caught_up(tmp_path, by_s):
    columns = drive()
    columns["t"][200:] -= by_s
    log = read(written(tmp_path, columns), mapped(tmp_path))
    left = len(log.streams["wheels"]["epoch_ns"])
    lost = len(columns["t"]) - left
    assert lost == pytest.approx(by_s * 5, abs=1.1)
    assert np.all(np.diff(log.streams["wheels"]["epoch_ns"]) > 0)
    assert any(f"row 201: the clock is set back by {by_s:g} s" in note for note in log.notes)
    with pytest.raises(BadInput, match="the clock is set back by"):
        read(tmp_path / "log.csv", mapped(tmp_path), strict=True)


def test_a_clock_that_is_set_ahead_is_a_gap(tmp_path):
    columns = drive()
    columns["t"][200:] += 3600.0
    log = read(written(tmp_path, columns), mapped(tmp_path))
    assert len(log.streams["wheels"]["epoch_ns"]) == len(columns["t"])
    assert any("gap of 3600.2 s at row 201" in note for note in log.notes)


def test_nanoseconds_in_a_table_stay_whole_and_days_are_known(tmp_path):
    columns = drive()
    start = 1_718_359_200_123_456_789
    columns["t"] = np.array([str(start + 200_000_000 * i) for i in range(600)], dtype=object)
    text = MAP.replace('"t", unit = "s"', '"t", unit = "ns"')
    log = read(written(tmp_path, columns), mapped(tmp_path, text))
    assert log.streams["wheels"]["epoch_ns"][7] == start + 1_400_000_000
    columns["t"] = np.array([f"{45000 + 0.2 * i / 86400:.10f}" for i in range(600)], dtype=object)
    text = MAP.replace('"t", unit = "s"', '"t", unit = "days"')
    log = read(written(tmp_path, columns), mapped(tmp_path, text))
    assert np.median(np.diff(log.streams["wheels"]["epoch_ns"])) == pytest.approx(2e8, rel=1e-3)


def test_stamps_in_a_format_of_their_own(tmp_path):
    columns = drive()
    cells = [f"14.06.2024 10:{i // 300:02d}:{i / 5 % 60:06.3f}" for i in range(600)]
    columns["t"] = np.array(cells, dtype=object)
    text = MAP.replace('unit = "s"', 'unit = "timestamp"')
    with pytest.raises(BadInput, match=r'say it as format = "%d.%m.%Y %H:%M:%S"'):
        read(written(tmp_path, columns), mapped(tmp_path, text))
    text = text.replace('"timestamp"', '"timestamp", format = "%d.%m.%Y %H:%M:%S.%f"')
    log = read(tmp_path / "log.csv", mapped(tmp_path, text))
    assert log.streams["wheels"]["epoch_ns"][0] == 1_718_359_200 * 10**9
    assert right(log)


def test_a_section_with_times_of_its_own(tmp_path):
    columns = drive()
    columns["t_wheel"] = columns["t"] + 0.05
    text = MAP.replace("[wheels]", '[wheels]\ntime = {column = "t_wheel", unit = "s"}')
    log = read(written(tmp_path, columns), mapped(tmp_path, text))
    assert log.streams["wheels"]["epoch_ns"][0] == 50_000_000
    assert log.streams["gnss"]["epoch_ns"][0] == 0


def test_of_two_columns_of_one_name_the_map_says_which(tmp_path):
    text = as_text(drive()).replace(",yaw\n", ",v\n", 1)
    path = tmp_path / "log.csv"
    path.write_text(text)
    with pytest.raises(BadInput, match=r"two columns are called 'v'; say 'v \(1\)'"):
        read(path, mapped(tmp_path))
    assert right(read(path, mapped(tmp_path, MAP.replace('"v"', '"v (1)"'))))


@pytest.mark.parametrize("end", [b"\0", b"\0\0\0", b"1\0", b"\xff"])
def test_utf_16_that_is_cut(tmp_path, end):
    path = tmp_path / "log.csv"
    path.write_bytes(as_text(drive()).encode("utf-16") + end)
    assert right(read(path, mapped(tmp_path)))


def test_a_byte_order_mark_before_text_that_is_no_utf_8(tmp_path):
    path = tmp_path / "log.csv"
    path.write_bytes(codecs.BOM_UTF8 + as_text({**drive(), "°C": np.ones(600)}).encode("cp1252"))
    assert right(read(path, mapped(tmp_path)))


def test_a_refused_log_leaves_nothing(tmp_path, capsys):
    columns = drive()
    columns["v"][5] = 300.0
    path, out = written(tmp_path, columns), tmp_path / "out"
    words = ["estimate", str(path), "--map", str(mapped(tmp_path)), "--out", str(out)]
    assert cli.main([*words, "--strict", "--quiet"]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "row 6: 300 m/s is 1080 km/h" in said
    assert not out.exists()


@pytest.mark.slow
def test_a_long_table_takes_little_time_and_memory(tmp_path):
    columns = drive(seconds=40_000.0, rate_hz=5.0)
    path, column_map = written(tmp_path, columns), mapped(tmp_path)
    read(path, column_map)  # imports
    tracemalloc.start()
    start_s = time.process_time()
    log = read(path, column_map)
    used_s = time.process_time() - start_s
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(log.streams["gnss"]["epoch_ns"]) == 200_000
    assert used_s < 0.6  # 3 s for 1e6 rows; tracing costs some
    assert peak < 4 * path.stat().st_size


@pytest.mark.parametrize(
    ("date", "layout"), [("2024-06-14", ""), ("14.06.2024", "%d.%m.%Y %H:%M:%S.%f"),
                         ("20240614", "%Y%m%d %H:%M:%S.%f")],
)  # fmt: skip
def test_a_date_and_a_time_of_day_in_two_columns(tmp_path, date, layout):
    columns = drive()
    columns["date"] = np.full(600, date, dtype=object)
    clock = [f"10:{i // 300:02d}:{i / 5 % 60:06.3f}" for i in range(600)]
    columns["t"] = np.array(clock, dtype=object)
    more = f', format = "{layout}"' if layout else ""
    text = MAP.replace('{column = "t", unit = "s"}',
                       f'{{column = ["date", "t"], unit = "timestamp"{more}}}')  # fmt: skip
    log = read(written(tmp_path, columns), mapped(tmp_path, text))
    assert log.streams["wheels"]["epoch_ns"][0] == 1_718_359_200 * 10**9
    assert right(log)
