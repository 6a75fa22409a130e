"""Traces of a bus: what they hold by name, by a DBC, and what is not available in them."""

from pathlib import Path

import numpy as np
import pytest

from twin.errors import BadInput
from twin.logs import Reading, found_in, read
from twin.logs.readers import bus_parameters as bus
from twin.logs.readers.can_bus import joined

can = pytest.importorskip("can")

REAL = Path(__file__).parents[3] / "shared" / "data" / "jd5055e_bus.candump"
DBC = """VERSION ""
BU_: E
BO_ 2566844926 CCVS1: 8 E
 SG_ WheelSpeed : 8|16@1+ (0.00390625,0) [0|250.996] "km/h" E
BO_ 512 Own: 8 E
 SG_ Draft : 0|16@1- (10,0) [-100000|100000] "N" E
 SG_ Depth : 16|8@1+ (0.5,-10) [0|100] "cm" E
"""


def frame(time_s, identifier, data):
    return f"({time_s:.6f}) can0 {identifier:X}#{data}"


def trace(folder, lines, name="bus.candump"):
    path = folder / name
    path.write_text("\n".join(lines) + "\n")
    return path


def ccvs1(time_s, raw):
    return frame(time_s, 0x18FEF103, f"FF{raw & 0xFF:02X}{raw >> 8:02X}FFFFFFFFFF")


@pytest.mark.skipif(not REAL.exists(), reason="the trace is not beside the checkout")
def test_the_bus_of_a_standing_tractor():
    found = found_in(REAL)
    speed = found.signals["EEC1.engine_speed"].values
    assert (np.nanmin(speed), np.nanmax(speed)) == (0.0, 1259.5)
    assert np.all(found.signals["CCVS1.wheel_speed"].values == 0.0)
    assert np.isnan(found.signals["GBSD.speed"].values).all()
    assert found.losses == ()
    log = read(REAL)
    assert log.streams["machine"]["engine_radps"].max() == pytest.approx(1259.5 * np.pi / 30)
    assert any("no ground speed" in note for note in log.notes)


def test_not_available_and_error_are_holes(tmp_path):
    lines = [ccvs1(i / 10, raw) for i, raw in enumerate([2000, 0xFFFF, 0xFE00, 0xFB00, 2100])]
    values = found_in(trace(tmp_path, lines)).signals["CCVS1.wheel_speed"].values
    np.testing.assert_array_equal(np.isnan(values), [False, True, True, True, False])
    assert values[0] == 2000 / 256


@pytest.mark.parametrize("parameter", bus.PARAMETERS, ids=lambda p: f"{p.pgn}.{p.name}")
def test_every_parameter_is_what_its_codes_say(parameter):
    low = parameter.offset if not parameter.signed else -100.0 * parameter.scale
    values = np.array([low, low + 5 * parameter.scale, np.nan, 1e300])
    raw = parameter.coded(values)
    data = np.full((4, 64), 0xFF, np.uint8)
    for i in range(parameter.size):
        data[:, parameter.byte - 1 + i] = (raw >> np.uint64(8 * i)).astype(np.uint8)
    back = parameter.of(data)
    np.testing.assert_allclose(back[:2], values[:2], atol=1e-12, rtol=1e-9)
    assert np.isnan(back[2:]).all()


def test_a_message_of_several_frames_and_one_that_lacks_one():
    body = np.arange(43, dtype=np.uint8)
    frames = [[0x20 | i, *([43] if i == 0 else []), *body[s : s + (6 if i == 0 else 7)]]
              for i, s in enumerate([0, 6, 13, 20, 27, 34, 41])]  # fmt: skip
    rows = np.full((7, 8), 0xFF, np.uint8)
    for row, data in zip(rows, frames, strict=True):
        row[: len(data)] = data
    times = np.arange(14, dtype=np.int64)
    epoch_ns, messages = joined(times, np.concatenate([rows, rows]))
    assert epoch_ns.tolist() == [0, 7]
    np.testing.assert_array_equal(messages[1][:43], body)
    epoch_ns, _ = joined(times[:13], np.concatenate([np.delete(rows, 3, axis=0), rows]))
    assert epoch_ns.tolist() == [6]


def test_two_senders_of_one_group_are_two_signals(tmp_path):
    lines = [frame(i / 10, 0x0CF00400, f"FFFFFF{20 + i:02X}20FFFFFF") for i in range(9)]
    lines += [frame(i / 10, 0x0CF00417, "FFFFFF0010FFFFFF") for i in range(3)]
    found = found_in(trace(tmp_path, lines))
    assert len(found.signals["EEC1.engine_speed"].values) == 9
    assert np.all(found.signals["EEC1.engine_speed@17"].values == 512.0)


def test_lines_that_are_no_frame_are_left_out_and_other_ways_to_write_one_are_read(tmp_path):
    lines = [ccvs1(i / 10, 2000) for i in range(50)]
    lines[7] = lines[7][:20]
    lines[9] = "(0.9)  can0  18FEF103   [8]  FF D0 07 FF FF FF FF FF"
    found = found_in(trace(tmp_path, [*lines, "\0\0\0"]))
    assert len(found.signals["CCVS1.wheel_speed"].values) == 49
    assert found.losses[0].rows.tolist() == [8]
    assert np.all(found.signals["CCVS1.wheel_speed"].values == 2000 / 256)


def test_a_dbc_says_what_is_in_frames(tmp_path):
    (tmp_path / "own.dbc").write_text(DBC)
    lines = [ccvs1(i / 10, 2000 + i if i != 4 else 0xFFFF) for i in range(9)]
    lines += [frame(i / 10 + 0.01, 0x200, "18FC50FFFFFFFFFF") for i in range(9)]
    path = trace(tmp_path, lines)
    found = found_in(path, Reading(dbc=(tmp_path / "own.dbc",)))
    np.testing.assert_allclose(found.signals["Own.Draft"].values, -10_000.0)
    np.testing.assert_allclose(found.signals["Own.Depth"].values, 30.0)
    speed = found.signals["CCVS1.WheelSpeed"].values
    np.testing.assert_array_equal(np.isnan(speed), np.arange(9) == 4)
    (tmp_path / "m.toml").write_text(
        '[log]\ndbc = "own.dbc"\n[machine]\ndraft_pin = {column = "Own.Draft", unit = "N"}\n'
    )
    log = read(path, tmp_path / "m.toml")
    assert set(log.streams.tables) == {"wheels", "machine"}
    (tmp_path / "own.dbc").write_text("BO_ nonsense")
    with pytest.raises(BadInput, match="no DBC that can be read"):
        read(path, tmp_path / "m.toml")


@pytest.mark.parametrize("suffix", ["asc", "blf", "trc"])
def test_other_kinds_of_traces(tmp_path, suffix):
    path = tmp_path / f"bus.{suffix}"
    with can.Logger(str(path)) as logger:
        for i in range(9):
            logger(can.Message(timestamp=1.7e9 + i / 10, arbitration_id=0x18FEF103,
                               data=bytes.fromhex("FFD007FFFFFFFFFF")))  # fmt: skip
    signal = found_in(path).signals["CCVS1.wheel_speed"]
    assert np.all(signal.values == 2000 / 256)
    np.testing.assert_allclose(np.diff(signal.epoch_ns), 1e8, atol=2e6)


def test_frames_that_nobody_knows_ask_for_a_dbc(tmp_path):
    path = trace(tmp_path, [frame(i / 10, 0x18FF0103, "00") for i in range(9)])
    with pytest.raises(BadInput, match=r"9 frames of 1 groups, and none .* dbc = "):
        read(path)


def test_an_absent_extra_says_what_to_install(tmp_path, monkeypatch):
    import builtins

    real = builtins.__import__

    def without(name, *args, **kwargs):
        if name in ("can", "rosbags.highlevel", "pyubx2"):
            raise ImportError(name)
        return real(name, *args, **kwargs)

    monkeypatch.setattr("twin.plugins.extras.import_module", lambda name: without(name))
    (tmp_path / "a.mcap").write_bytes(b"\x89MCAP0\r\n")
    (tmp_path / "a.ubx").write_bytes(b"\xb5\x62\x01\x07")
    for path, extra in (
        (trace(tmp_path, [ccvs1(0.1, 1)]), "can"),
        (tmp_path / "a.mcap", "ros"),
        (tmp_path / "a.ubx", "ubx"),
    ):
        with pytest.raises(BadInput, match=rf"pip install '\.\[{extra}\]' in a checkout"):
            read(path)
