import numpy as np
import pytest
from example_log import HEADER, MAP, rows, write, write_map

from twin import cli
from twin.errors import BadInput
from twin.logs import read
from twin.streams import check


def refusal(path, column_map=None, **options):
    with pytest.raises(BadInput) as caught:
        read(path, column_map, **options)
    message = str(caught.value)
    assert "\n" not in message
    return message


def bent(tmp_path, row, column, cell):
    cells = rows()
    cells[row - 1][HEADER.split(",").index(column)] = cell
    return write(tmp_path, cells)


def test_values_units_and_frames(tmp_path):
    log = read(write(tmp_path), write_map(tmp_path))
    check(log.streams)
    gnss, wheels = log.streams["gnss"], log.streams["wheels"]
    np.testing.assert_allclose(wheels["speed_rl_mps"], 7.5 / 3.6)
    np.testing.assert_allclose(wheels["speed_rr_mps"], 7.5 / 3.6)
    np.testing.assert_allclose(gnss["v_east_mps"], 2.0)  # compass 90 degrees is east
    np.testing.assert_allclose(gnss["v_north_mps"], 0.0, atol=1e-12)
    np.testing.assert_allclose(gnss["heading_rad"], 0.0, atol=1e-12)
    # one degree of longitude at 45 degrees north is 78.847 km (WGS 84)
    np.testing.assert_allclose(np.diff(gnss["east_m"]), 78846.8 * 2.5e-5, rtol=1e-4)
    assert gnss["epoch_ns"].tolist() == [i * 10**9 for i in range(30)]
    assert log.setup.origin == (45.0, 11.0, 0.0)
    assert log.setup.wheelbase_m == 2.5
    assert log.rows["state"].tolist() == ["M"] * 15 + ["W"] * 15
    assert log.rules["steady"].max_speed_change_kmhps == 0.15
    assert any("assumed" in note and "track_rear_m" in note for note in log.notes)


def test_east_convention_turns_the_other_way(tmp_path):
    text = MAP.replace('convention = "compass"', 'convention = "east"')
    log = read(write(tmp_path), write_map(tmp_path, text))
    np.testing.assert_allclose(log.streams["gnss"]["v_north_mps"], 2.0)


@pytest.mark.parametrize(
    ("row", "column", "cell", "says"),
    [
        (7, "t", "6.0x", ["'t'", "row 7", "'6.0x'"]),
        (7, "t", "", ["'t'", "row 7", "no time"]),
        (7, "t", "nan", ["'t'", "row 7", "no time"]),
        (7, "t", "inf", ["'t'", "row 7", "'inf' is not a number"]),
        (7, "t", "1e12", ["'t'", "row 7", "unit"]),
        (7, "t", "9" * 400, ["'t'", "row 7"]),
        (7, "t", "5", ["'t'", "row 7", "repeated"]),
        (7, "t", "4.5", ["'t'", "row 7", "out of order"]),
        (7, "v", "fast", ["'v'", "row 7", "'fast'"]),
        (7, "v", '"2,5"', ["'v'", "row 7", "decimal"]),
        (7, "v", "inf", ["'v'", "row 7", "'inf' is not a number"]),
        (7, "v", "1e308", ["'v'", "row 7", "1e+308"]),
        (7, "v", "200", ["'v'", "row 7", "200 m/s", "unit right"]),
        (7, "lat", "95", ["'lat'", "row 7", "95 deg", "unit right"]),
        (7, "lat", "46.5", ["row 7", "km from the first fix"]),
    ],
)
def test_a_bad_cell_is_left_out_and_named_and_refused_where_that_is_asked(
    tmp_path, row, column, cell, says
):
    path, column_map = bent(tmp_path, row, column, cell), write_map(tmp_path)
    message = refusal(path, column_map, strict=True)
    for part in ["log.csv", *says]:
        assert part in message, message
    log = read(path, column_map)
    note = next(note for note in log.notes if note.startswith("1 of 30 rows left out: "))
    for part in says:
        assert part in note, note
    for table in log.streams.tables.values():
        for values in table.values():
            assert not np.any(np.abs(np.nan_to_num(values[:, None][:-1])) == np.inf)
    np.testing.assert_allclose(np.nanmedian(log.streams["gnss"]["v_east_mps"]), 2.0)


@pytest.mark.parametrize(("bad", "of", "taken"), [(3, 30, True), (4, 30, False), (9, 900, True)])
def test_bad_rows_are_left_out_up_to_three_and_up_to_one_percent(tmp_path, bad, of, taken):
    cells = rows(of)
    for i in range(bad):
        cells[2 * i + 1][3] = "fast"
    path, column_map = write(tmp_path, cells), write_map(tmp_path)
    if taken:
        assert any(
            n.startswith(f"{bad} of {of} rows left out") for n in read(path, column_map).notes
        )
        return
    message = refusal(path, column_map)
    assert "row 2: 'fast' is not a number; 4 of 30 rows are bad, 1% may be" in message
    text = MAP.replace("[log]", "[log]\nbad_rows = 0.2")
    assert read(path, write_map(tmp_path, text)).streams


def test_a_missing_value_is_nan_and_a_missing_sensor_row_is_left_out(tmp_path):
    log = read(bent(tmp_path, 7, "v", ""), write_map(tmp_path))
    assert np.flatnonzero(np.isnan(log.streams["gnss"]["v_east_mps"])).tolist() == [6]
    log = read(bent(tmp_path, 7, "wheel", "NaN"), write_map(tmp_path))
    assert len(log.streams["wheels"]["epoch_ns"]) == len(log.rows["state"]) == 29
    assert any(n.startswith("wheels: 1 rows") and "row 7" in n for n in log.notes)


def test_a_gap_is_told_and_not_filled(tmp_path):
    cells = rows()
    for row in cells[20:]:
        row[0] = str(int(row[0]) + 11)
    log = read(write(tmp_path, cells), write_map(tmp_path))
    assert "log: gap of 12.0 s at row 21" in log.notes
    assert len(log.streams["wheels"]["epoch_ns"]) == 30


def test_speeds_no_tractor_has(tmp_path):
    cells = rows()
    for row in cells:
        row[3], row[5] = "15.0", "54.0"
    message = refusal(write(tmp_path, cells), write_map(tmp_path))
    assert "54 km/h" in message
    assert "is the unit right?" in message
    message = refusal(write(tmp_path), write_map(tmp_path, MAP.replace('"km/h"', '"m/s"')))
    assert "one of the units wrong" in message


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "empty"),
        (b" \n\n", "empty"),
        (HEADER.encode() + b"\n", "no rows"),
        (bytes(range(256)) * 20, "not a text file"),
        (b"\xff\xfe" + HEADER.encode("utf-16-le"), "no rows"),
        (b"PAR1" + bytes(100), "Parquet"),
        (b"t,t\n1,2\n", "two columns"),
        (b"x\n1\n2\n", "no column is called 't'"),
    ],
)
def test_files_that_are_no_log(tmp_path, content, says):
    path = tmp_path / "log.csv"
    path.write_bytes(content)
    assert says in refusal(path, write_map(tmp_path))


def test_paths_that_are_no_file(tmp_path):
    assert "no such file" in refusal(tmp_path / "absent.csv", write_map(tmp_path))
    assert "run folder" in refusal(tmp_path)
    assert "column map" in refusal(write(tmp_path))
    assert "absent.toml" in refusal(write(tmp_path), tmp_path / "absent.toml")


def test_no_permission_is_told(tmp_path, monkeypatch):
    path, column_map = write(tmp_path), write_map(tmp_path)

    def denied(*_args, **_kwargs):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(type(path), "open", denied)
    assert "Permission denied" in refusal(path, column_map)


def test_a_missing_column_suggests_the_nearest(tmp_path):
    path = write(tmp_path, header=HEADER.replace("wheel", "wheels"))
    message = refusal(path, write_map(tmp_path))
    assert "wheels.driven_speed" in message
    assert "did you mean 'wheels'?" in message


def test_semicolons_windows_lines_and_a_byte_order_mark(tmp_path):
    path = write(tmp_path)
    text = path.read_text().replace(",", ";").replace("\n", "\r\n")
    path.write_bytes(b"\xef\xbb\xbf" + text.encode())
    assert len(read(path, write_map(tmp_path)).streams["gnss"]["epoch_ns"]) == 30


def test_nanoseconds_and_iso_stamps_are_exact(tmp_path):
    cells = rows()
    for i, row in enumerate(cells):
        row[0] = str(1_700_000_000_123_456_789 + i * 10**9)
    ns = write_map(tmp_path, MAP.replace('column = "t", unit = "s"', 'column = "t", unit = "ns"'))
    log = read(write(tmp_path, cells), ns)
    assert log.streams["gnss"]["epoch_ns"][3] == 1_700_000_003_123_456_789
    for i, row in enumerate(cells):
        row[0] = f"2023-10-23T10:00:{i:02d}+02:00"
    stamp = MAP.replace('column = "t", unit = "s"', 'column = "t", unit = "timestamp"')
    log = read(write(tmp_path, cells), write_map(tmp_path, stamp))
    assert log.streams["gnss"]["epoch_ns"][0] == 1_698_048_000 * 10**9  # 08:00:00 UTC


def test_a_reference_keeps_its_rows(tmp_path):
    text = MAP + '[reference]\nslip = {column = "wheel", unit = "%"}\n'
    log = read(write(tmp_path), write_map(tmp_path, text))
    np.testing.assert_allclose(log.reference["slip"], 0.075)
    assert log.reference["epoch_ns"].dtype == np.int64


def test_the_command_exports_what_it_estimated(tmp_path, capsys):
    path, columns = write(tmp_path), write_map(tmp_path)
    words = ["estimate", str(path), "--map", str(columns), "--estimators", "ratio"]
    out = ["--out", str(tmp_path / "out"), "--csv", str(tmp_path / "estimates.csv")]
    assert cli.main([*words, *out]) == 0
    assert "estimates.csv: time_s is in seconds of the log's own clock" in capsys.readouterr().out
    header, first, *_ = (tmp_path / "estimates.csv").read_text().splitlines()
    assert header.startswith('"time_s","estimator",')
    assert "slip_percent" in header
    assert first.startswith('0,"ratio",')


def test_a_place_that_takes_no_csv_is_refused_before_the_work(tmp_path, capsys):
    path, columns = write(tmp_path), write_map(tmp_path)
    words = ["estimate", str(path), "--map", str(columns), "--out", str(tmp_path / "out")]
    assert cli.main([*words, "--csv", str(tmp_path / "none" / "e.csv")]) == 2
    assert "--csv" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
