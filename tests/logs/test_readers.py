"""One interface of all readers of logs, and a reader of one's own behind it."""

import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

from twin import cli
from twin.errors import BadInput, UnknownName
from twin.logs import READERS, Found, Reader, Signal, read, reader
from twin.logs.losses import Loss

EXAMPLES = Path(__file__).parents[2] / "examples"
MAP = """
[gnss]
speed = {column = "v_gnss", unit = "m/s"}
course = {column = "course", unit = "deg"}
quality = {column = "fix", unit = "1"}
[wheels]
driven_speed = {column = "v_wheel", unit = "km/h"}
[rows]
gear = {column = "gear"}
"""


def signals():
    """A course through north, at other times than the speed; wheels and gear slower still."""
    step = 100_000_000
    gnss_ns = step * np.arange(20, dtype=np.int64)
    course_ns = gnss_ns + step // 2
    wheel_ns = 2 * step * np.arange(10, dtype=np.int64)
    turned = np.mod(360.0 + np.arange(20) - 10.0, 360.0)
    return {
        "v_gnss": Signal(np.full(20, 2.0), gnss_ns),
        "course": Signal(turned, course_ns),
        "fix": Signal(np.where(np.arange(10) < 5, 4, 5), wheel_ns),
        "v_wheel": Signal(np.full(10, 8.0), wheel_ns),
        "gear": Signal(["M"] * 5 + ["W"] * 5, wheel_ns + 1),
    }


class Own(Reader):
    name = "own"

    def __init__(self, **changed):
        self.changed = changed

    def signals(self, path):
        return signals() | self.changed


class Fails(Own):
    def signals(self, path):
        return {"v": path.read_text()["v"]}


class Knows(Own):
    own_map = tomllib.loads(MAP.partition("quality")[0])


def write(folder, text=MAP):
    (folder / "drive.log").write_text("nothing")
    (folder / "map.toml").write_text(text)
    return folder / "drive.log", folder / "map.toml"


def test_signals_with_times_of_their_own_are_brought_together(tmp_path):
    log = read(*write(tmp_path), Own())
    gnss, wheels = log.streams["gnss"], log.streams["wheels"]
    assert len(gnss["epoch_ns"]) == 20
    assert len(wheels["epoch_ns"]) == 10
    assert wheels["speed_rl_mps"] == pytest.approx(8.0 / 3.6)
    compass = np.arange(1, 20) - 10.5  # half a step before each course, through 360
    east, north = np.sin(np.radians(compass)), np.cos(np.radians(compass))
    np.testing.assert_allclose(gnss["v_east_mps"][1:], 2.0 * east, atol=1e-9)
    np.testing.assert_allclose(gnss["v_north_mps"][1:], 2.0 * north, atol=1e-9)
    np.testing.assert_array_equal(gnss["quality"], np.repeat([4.0, 5.0], 10))
    assert log.rows["gear"].tolist() == [""] + ["M"] * 5 + ["W"] * 4
    assert "gnss: course, quality brought to the times of speed" in log.notes


def test_a_gap_of_a_signal_is_not_bridged(tmp_path):
    course = signals()["course"]
    kept = np.r_[0:5, 15:20]
    log = read(*write(tmp_path), Own(course=Signal(course.values[kept], course.epoch_ns[kept])))
    lost = np.isnan(log.streams["gnss"]["v_east_mps"])
    assert np.flatnonzero(lost).tolist() == [0, *range(5, 16)]


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"v_gnss": np.zeros(3)}, "'v_gnss' is ndarray, not a twin.logs.Signal"),
        ({"v_gnss": Signal(np.zeros((3, 2)))}, r"'v_gnss' has shape \(3, 2\)"),
        ({"v_gnss": Signal(np.zeros(3), np.arange(3.0))}, "epoch_ns is float64"),
        ({"v_gnss": Signal(np.zeros(3), np.arange(2))}, r"int64 of shape \(3,\) will do"),
        ({"v_gnss": Signal(np.zeros(9), np.arange(9)[::-1].copy())}, "out of order"),
        ({"v_gnss": Signal(np.zeros(3), np.array([0, 1, 2**62 + 1]))}, "146 years"),
        ({"v_gnss": Signal(np.zeros(3))}, r"has no \[log\] time"),
        ({"v_gnss": Signal(np.full(20, 99.0), signals()["v_gnss"].epoch_ns)}, "no tractor's speed"),
    ],
)
def test_what_a_reader_gives_wrong_is_told_by_name(tmp_path, changed, says):
    with pytest.raises(BadInput, match=says) as caught:
        read(*write(tmp_path), Own(**changed))
    assert str(caught.value).startswith(str(tmp_path / "drive.log"))


@pytest.mark.parametrize(
    ("fastest", "says"),
    [
        ("", r"356.4 km/h\), no tractor's speed; .*fastest_kmh = 360 in \[log\]"),
        ("[log]\nfastest_kmh = 130", r"says fastest_kmh = 130; .*fastest_kmh = 360 in \[log\]"),
        ("[log]\nfastest_kmh = 360", None),
    ],
)
def test_a_map_says_how_fast_a_vehicle_is_that_is_no_tractor(tmp_path, fastest, says):
    fast = Own(v_gnss=Signal(np.full(20, 99.0), signals()["v_gnss"].epoch_ns))
    written = write(tmp_path, fastest + MAP.partition("[wheels]")[0])
    if says is None:
        log = read(*written, fast)
        assert np.hypot(log.streams["gnss"]["v_east_mps"], log.streams["gnss"]["v_north_mps"])[
            5
        ] == pytest.approx(99.0)
        return
    with pytest.raises(BadInput, match=says):
        read(*written, fast)


def test_counts_are_not_interpolated(tmp_path):
    text = '[wheels]\nticks_rl = {column = "v_wheel", unit = "1"}\n' + (
        'ticks_rr = {column = "v_gnss", unit = "1"}\n'
    )
    with pytest.raises(BadInput, match=r"ticks_rr has other times.*not interpolated"):
        read(*write(tmp_path, text), Own())


def test_a_reader_that_fails_is_told_with_its_line(tmp_path):
    with pytest.raises(BadInput, match=r"own logs fails: TypeError.*\(test_readers.py, line"):
        read(*write(tmp_path), Fails())


def test_a_reader_may_bring_its_own_map_and_the_user_the_set_up(tmp_path):
    path, other = write(tmp_path, "[setup]\nwheelbase_m = 3.1\n")
    for log in (read(path, None, Knows()), read(path, other, Knows())):
        assert set(log.streams.tables) == {"gnss"}
    assert log.setup.wheelbase_m == 3.1
    with pytest.raises(BadInput, match="own log needs a column map"):
        read(path, None, Own())


class Whole(Own):
    def whole(self, path):
        return read(*write(path.parent / "inner"), Own())


class Losing(Own):
    def found(self, path, reading):
        loss = Loss("lines", np.array([4, 9]), 200, "line 4 is torn")
        return Found(signals=signals(), losses=(loss,), notes=("read in two passes",))


def test_a_reader_may_give_a_whole_log_or_say_what_it_left_out(tmp_path):
    (tmp_path / "inner").mkdir()
    path, other = write(tmp_path)
    assert set(read(path, None, Whole()).streams.tables) == {"gnss", "wheels"}
    with pytest.raises(BadInput, match="leave the column map out"):
        read(path, other, Whole())
    log = read(path, other, Losing())
    assert {"read in two passes", "2 of 200 rows left out: line 4 is torn"} <= set(log.notes)
    with pytest.raises(BadInput, match="line 4 is torn"):
        read(path, other, Losing(), strict=True)


def test_the_twins_own_stand_in_one_registry(tmp_path):
    assert list(READERS) == [
        "bag",
        "run-folder",
        "parquet",
        "mat",
        "ubx",
        "can",
        "nmea",
        "csv",
    ]
    (tmp_path / "a.csv").write_text("$ is the first column,b\n1,2\n")
    (tmp_path / "map.toml").write_text('[log]\ntime = {column = "t", unit = "s"}\n')
    with pytest.raises(BadInput, match="no GGA or RMC"):
        read(tmp_path / "a.csv", tmp_path / "map.toml", reader("nmea"))
    with pytest.raises(BadInput, match="no column is called 't'"):
        read(tmp_path / "a.csv", tmp_path / "map.toml", reader("csv"))
    with pytest.raises(UnknownName, match="did you mean 'csv'"):
        reader("cvs")
    with pytest.raises(BadInput, match=r"is BadInput; it must be a twin.logs.Reader"):
        reader("twin.errors:BadInput")
    with pytest.raises(BadInput, match=r"'twin.logs:read' is read"):
        reader("twin.logs:read")


def test_the_example_reads_one_value_a_line(tmp_path, monkeypatch):
    monkeypatch.chdir(EXAMPLES)
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    own = reader("data_logger:DataLogger")
    sys.modules.pop("data_logger", None)
    path, other = write(tmp_path, '[gnss]\nspeed = {column = "v", unit = "m/s"}\n')
    path.write_text("0.0 v 1.5\n0.5 c 90\n1.0 v 1.6\n")
    table = own.signals(path)
    assert table["v"].epoch_ns.tolist() == [0, 1_000_000_000]
    path.write_text("0.0 v 1.5\n0.5 v\n")
    with pytest.raises(BadInput, match=r"line 2: '0.5 v' is no TIME NAME VALUE"):
        read(path, other, own)


class SpeedOnly:
    """Knows no slip."""

    def init(self, setup):
        return None

    def run(self, state, chunk):
        epoch_ns = chunk["gnss"]["epoch_ns"]
        return state, {"epoch_ns": epoch_ns, "speed_mps": np.full(len(epoch_ns), 2.0)}


@pytest.mark.slow
def test_the_command_takes_a_reader_and_an_estimator_without_slip(tmp_path, monkeypatch, capsys):
    path, other = write(tmp_path)
    words = ["estimate", str(path), "--map", str(other), "--out", str(tmp_path / "out")]
    own = ["--reader", f"{__name__}:Own", "--estimators", f"{__name__}:SpeedOnly"]
    assert cli.main([*words, *own]) == 0
    assert "no slip estimated" in capsys.readouterr().out
    assert cli.main([*words, "--reader", "cvs"]) == 2
    assert "did you mean 'csv'" in capsys.readouterr().err
