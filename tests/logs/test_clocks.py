"""Several files of one drive on one clock."""

from pathlib import Path

import numpy as np
import pytest
from made_drive import MAP, SLIP, drive, mapped, written

from twin.errors import BadInput
from twin.logs import paired_speeds, read
from twin.logs.clocks import Speed, offset
from twin.logs.export import export
from twin.pipeline.log_check import log_lag
from twin.streams import Streams

ROOT = Path(__file__).parents[2]
FIELD_LOG = ROOT.parent / "shared" / "data" / "t7165s_field.csv"


def speeds(offset_s, seconds=600.0, rate=(10.0, 5.0), noise=0.02, seed=0):
    generator = np.random.default_rng(seed)
    coarse = generator.normal(size=round(seconds / 4.0) + 4)
    a, b = (np.arange(0.0, seconds, 1.0 / r) for r in rate)
    way = lambda t: 2.0 + 0.8 * np.interp(t, 4.0 * np.arange(len(coarse)), coarse)  # noqa: E731
    reference = Speed(epoch_ns=np.round(a * 1e9).astype(np.int64), mps=np.abs(way(a)))
    shifted_ns = np.round((b + offset_s) * 1e9).astype(np.int64)
    noisy = 0.93 * way(b) + noise * generator.normal(size=len(b))
    return reference, Speed(epoch_ns=shifted_ns, mps=np.abs(noisy))


@pytest.mark.parametrize("offset_s", [0.0, 3.7, -12.34, 36_000.0, 1_718_359_200.5])
@pytest.mark.parametrize("seconds", [60.0, 600.0])
def test_an_offset_is_found_within_its_sd(offset_s, seconds):
    found = [offset(*speeds(offset_s, seconds, seed=s)) for s in range(4)]
    errors = np.array([(f.offset_s - offset_s) / f.sd_s for f in found])
    assert np.all(np.abs([f.offset_s - offset_s for f in found]) < 0.1)
    assert np.all(np.abs(errors) < 5.0)


def test_speeds_that_say_nothing_of_the_clock_are_refused():
    reference, other = speeds(5.0)
    with pytest.raises(BadInput, match="hardly change"):
        offset(reference, Speed(epoch_ns=other.epoch_ns, mps=np.full(len(other.mps), 2.0)))
    noise = np.abs(np.random.default_rng(0).normal(size=len(other.mps)))
    with pytest.raises(BadInput, match="do not say how far"):
        offset(reference, Speed(epoch_ns=other.epoch_ns, mps=noise))
    beat = 2.0 + np.sin(2 * np.pi * np.arange(3000) / 100.0)
    times = np.arange(3000, dtype=np.int64) * 10**8
    with pytest.raises(BadInput, match="do not say how far"):
        offset(Speed(epoch_ns=times, mps=beat), Speed(epoch_ns=times, mps=beat))


def two_files(tmp_path, offset_s):
    columns = drive(seconds=300.0, rate_hz=5.0)
    gnss = {k: v for k, v in columns.items() if k not in ("wheel", "yaw")}
    gnss["t"] = gnss["t"] + offset_s
    bus = {"t": columns["t"], "wheel": columns["wheel"]}
    return [written(tmp_path, bus, "bus.csv"), written(tmp_path, gnss, "gnss.csv")]


def test_two_tables_of_one_drive(tmp_path):
    files = two_files(tmp_path, 41.5)
    log = read(files, mapped(tmp_path))
    ground, wheel = paired_speeds(log.streams)
    assert np.nanmedian(1.0 - ground / wheel) == pytest.approx(SLIP, abs=0.003)
    said = next(n for n in log.notes if n.startswith("gnss.csv: its clock is +41.5"))
    assert "sd 0.0" in said
    given = read(files, mapped(tmp_path), offset_s={"gnss.csv": 41.5})
    assert "gnss.csv: its clock is +41.500 s ahead, as given" in given.notes
    assert given.streams["gnss"]["epoch_ns"][0] == 0
    text = MAP.replace("[log]", "[log]\noffset_s = {gnss = 41.5}")
    assert read(files, mapped(tmp_path, text)).streams["gnss"]["epoch_ns"][0] == 0
    with pytest.raises(
        BadInput, match=r"offset_s names 'gps.csv'; the files are bus.csv, gnss.csv"
    ):
        read(files, mapped(tmp_path), offset_s={"gps.csv": 1.0})


def test_clocks_that_agree_are_left_alone(tmp_path):
    log = read(two_files(tmp_path, 0.0), mapped(tmp_path))
    assert log.streams["gnss"]["epoch_ns"][0] == 0
    assert any("none is taken off" in note for note in log.notes)


def test_a_column_of_two_files_says_of_which(tmp_path):
    files = two_files(tmp_path, 0.0)
    files[0].write_text(files[0].read_text().replace("wheel", "v", 1))
    with pytest.raises(BadInput, match=r"'v' is in 2 files; name it 'bus.csv:v' or 'gnss.csv:v'"):
        read(files, mapped(tmp_path, MAP.replace('"wheel"', '"v"')))
    text = MAP.replace('"wheel"', '"bus:v"').replace('"v"', '"gnss.csv:v"')
    log = read(files, mapped(tmp_path, text))
    assert set(log.streams.tables) == {"gnss", "wheels"}
    with pytest.raises(BadInput, match="is named twice"):
        read([files[0], files[0]], mapped(tmp_path))


@pytest.mark.skipif(not FIELD_LOG.exists(), reason="the field log is not beside the checkout")
def test_a_real_log_as_bus_and_receiver_with_clocks_apart(tmp_path):
    pytest.importorskip("can")
    log = read(FIELD_LOG, ROOT / "examples" / "t7165s.toml")
    tables = {name: dict(table) for name, table in log.streams.tables.items()}
    gnss = tables.pop("gnss")
    for stamp in ("epoch_ns", "arrival_ns"):
        gnss[stamp] = gnss[stamp] + 3_700_000_000
    export(Streams(tables), log.setup, "candump", tmp_path / "bus")
    export(Streams({"gnss": gnss}), log.setup, "nmea", tmp_path / "gnss")
    files = [tmp_path / "bus" / "bus.candump", tmp_path / "gnss" / "gnss.nmea"]
    back = read(files, tmp_path / "bus" / "map.toml")
    note = next(n for n in back.notes if n.startswith("gnss.nmea: its clock is +"))
    found_s = float(note.split("+")[1].split()[0])
    assert found_s - log_lag(log).lag_s == pytest.approx(3.7, abs=0.1)
    ours, theirs = paired_speeds(back.streams), paired_speeds(log.streams)
    assert len(ours[1]) == len(theirs[1])
    np.testing.assert_allclose(ours[1], theirs[1], atol=6e-4)
