"""NMEA as it comes: sentences of other makers, prefixes, bursts, days, binary between."""

import math
import zlib

import numpy as np
import pytest
from nmea_lines import sentence

from twin.errors import BadInput
from twin.logs import READERS, found_in, read
from twin.logs.readers.nmea_sentences import unicore_crc


def gga(second, quality=4, north=0.0, talker="GN"):
    minutes = 30.0 + north / 1852.0
    place = f"52{minutes:011.8f},N,01315.00000000,E"
    return f"{talker}GGA,1000{second:05.2f},{place},{quality},17,0.7,52.1,M,39,M,,"


def vtg(kmh, course=0.0):
    return f"GNVTG,{course:.2f},T,,M,{kmh / 1.852:.4f},N,{kmh:.4f},K,R"


def log_of(tmp_path, lines, binary=b""):
    path = tmp_path / "gnss.nmea"
    path.write_bytes(binary.join(line.encode() + b"\r\n" for line in lines))
    return read(path)


@pytest.mark.parametrize(
    ("body", "heading_deg"),
    [
        ("GNHDT,123.4,T", 123.4),
        ("GNTHS,123.4,A", 123.4),
        ("GNTHS,123.4,V", None),
        ("PASHR,100000.00,123.40,T,1.0,2.0,0.0,0.1,0.1,0.2,2,1", 123.4),
        ("PASHR,100000.00,123.40,T,1.0,2.0,0.0,0.1,0.1,0.2,0,1", None),
        ("GNHDT,,T", None),
        ("GNTRA,100000.00,123.4,0.1,0.2,4,12,1.0,0001", 123.4),
        ("GNHPR,100000.00,123.4,0.1,0.2,4,12,1.0,0001", 123.4),
        ("GNHPR,100000.00,0.0,0.0,0.0,0,12,1.0,0001", None),
        ("PTNL,AVR,100000.00,+123.4,Yaw,+0.1,Tilt,,,1.2,3,2.5,6", 123.4),
    ],
)
def test_headings(tmp_path, body, heading_deg):
    log = log_of(tmp_path, [sentence(b) for s in range(9) for b in (gga(s), vtg(7.2), body)])
    heading = log.streams["gnss"].get("heading_rad")
    if heading_deg is None:
        assert heading is None
    else:
        np.testing.assert_allclose(heading, math.radians(90.0 - heading_deg))


def test_boards_and_receivers_that_say_all_at_once(tmp_path):
    place = "5230.0000000,N,01315.0000000,E,4,17,0.7,52.1,1.0,3.8877"
    paogi = [sentence(f"PAOGI,1000{s:05.2f},{place},123.4,1,2,3") for s in range(9)]
    panda = [sentence(f"PANDA,1000{s:05.2f},{place},1234,1,2,3") for s in range(9)]
    none = [sentence(f"PANDA,1000{s:05.2f},{place},65535,1,2,3") for s in range(9)]
    for lines, heading in ((paogi, 123.4), (panda, 123.4), (none, None)):
        gnss = log_of(tmp_path, lines).streams["gnss"]
        assert np.hypot(gnss["v_east_mps"], gnss["v_north_mps"])[3] == pytest.approx(2.0, abs=1e-4)
        if heading is not None:
            assert gnss["heading_rad"][0] == pytest.approx(math.radians(90.0 - heading))


def test_ksxt_and_uniheading(tmp_path):
    ksxt = [
        sentence(f"KSXT,202406141000{s:06.3f},13.25,52.5,52.1,90.5,0,91.0,7.2,0,3,3,12,17,,,,,,")
        for s in range(9)
    ]
    gnss = log_of(tmp_path, ksxt).streams["gnss"]
    assert gnss["epoch_ns"][0] == 1_718_359_200 * 10**9
    assert gnss["quality"][0] == 4
    assert gnss["heading_rad"][0] == pytest.approx(math.radians(-0.5))
    body = "UNIHEADINGA,92,GPS,FINE,2318,1,0,0,18,5;SOL_COMPUTED,NARROW_INT,1.2,33.5,0.1,0,0.2,0.3"
    line = f"#{body}*{unicore_crc(body.encode()):08x}"
    lines = [x for s in range(9) for x in (sentence(gga(s)), sentence(vtg(7.2)), line)]
    gnss = log_of(tmp_path, lines).streams["gnss"]
    np.testing.assert_allclose(gnss["heading_rad"], math.radians(56.5))


def test_the_crc_of_unicore_is_that_of_its_manual():
    table = [0] * 256
    for i in range(256):
        value = i
        for _ in range(8):
            value = (value >> 1) ^ (0xEDB88320 if value & 1 else 0)
        table[i] = value
    crc = 0
    for byte in b"UNIHEADINGA,92":
        crc = table[(crc ^ byte) & 0xFF] ^ (crc >> 8)
    assert unicore_crc(b"UNIHEADINGA,92") == crc != zlib.crc32(b"UNIHEADINGA,92")


@pytest.mark.parametrize(
    "before",
    ["2024-06-14 10:00:00.123 ", "[12:00:00] RX: ", "\\s:GPS1,c:1718359200*4B\\", "\ufeff"],
)
def test_what_loggers_put_before_a_sentence(tmp_path, before):
    lines = [before + sentence(b) for s in range(9) for b in (gga(s), vtg(7.2))]
    assert len(log_of(tmp_path, lines).streams["gnss"]["epoch_ns"]) == 9


def test_binary_between_sentences(tmp_path):
    ubx = b"\xb5\x62\x01\x35\x04\x00\x01\x02$\x0a\x03\x04\x00\x00"
    lines = [sentence(b) for s in range(9) for b in (gga(s), vtg(7.2))]
    log = log_of(tmp_path, lines, ubx)
    assert len(log.streams["gnss"]["epoch_ns"]) == 9
    np.testing.assert_allclose(log.streams["gnss"]["v_north_mps"], 2.0, atol=1e-4)


@pytest.mark.parametrize("first", ["vtg", "gga"])
@pytest.mark.parametrize("cut", [False, True])
def test_a_burst_in_either_order(tmp_path, first, cut):
    speed = [3.6 * (1.0 + 0.3 * math.sin(s / 2.0)) for s in range(40)]
    north = np.cumsum(
        [0.5 * (v + w) / 3.6 for v, w in zip(speed, [speed[0], *speed], strict=False)]
    )
    pairs = [(sentence(vtg(v)), sentence(gga(s, north=n)))
             for s, (v, n) in enumerate(zip(speed, north, strict=True))]  # fmt: skip
    lines = [x for pair in pairs for x in (pair if first == "vtg" else pair[::-1])]
    gnss = log_of(tmp_path, lines[3:] if cut else lines).streams["gnss"]
    at = np.round(gnss["epoch_ns"] / 1e9 - 36000).astype(int)
    known = np.isfinite(gnss["v_north_mps"])
    np.testing.assert_allclose(
        gnss["v_north_mps"][known], np.array(speed)[at][known] / 3.6, atol=1e-3
    )
    assert known.sum() >= 37


def test_no_fix_for_a_while_is_no_velocity_for_a_while(tmp_path):
    lines = []
    for s in range(20):
        valid = not 5 <= s < 9
        status, mode = ("A", "R") if valid else ("V", "N")
        rmc = f"GNRMC,1000{s:05.2f},{status},5230.0,N,01315.0,E,4.0,0.0,140624,,,{mode}"
        lines += [sentence(rmc), sentence(vtg(7.2) if valid else "GNVTG,,T,,M,,N,,K,N")]
    log = log_of(tmp_path, lines)
    assert len(log.streams["gnss"]["epoch_ns"]) == 16
    assert any("it has no fix" in note for note in log.notes)


def test_two_sentences_of_one_time_count_as_the_better_says(tmp_path):
    lines = [sentence(b) for s in range(9) for b in (
        gga(s, 4, 0.0), gga(s, 1, 30.0, "GP"), vtg(7.2))]  # fmt: skip
    gnss = log_of(tmp_path, lines).streams["gnss"]
    assert gnss["quality"].tolist() == [4.0] * 9
    assert np.ptp(gnss["north_m"]) < 0.01


def test_a_sentence_that_cannot_be_read_is_left_out(tmp_path):
    lines = [sentence(b) for s in range(40) for b in (gga(s), vtg(7.2))]
    lines[10] = sentence("GNGGA,100005.00,5261.0,N,01315.0,E,4,17,0.7,52.1,M,39,M,,")
    log = log_of(tmp_path, lines)
    assert any("line 11: GGA cannot be read ('5261.0' is not an angle)" in n for n in log.notes)
    with pytest.raises(BadInput, match="is not an angle"):
        read(tmp_path / "gnss.nmea", strict=True)


def test_ubx_messages_and_their_headings(tmp_path):
    ubx = pytest.importorskip("pyubx2")
    content = b""
    for i in range(20):
        tow_ms = 5 * 86_400_000 + 36_018_000 + 100 * i  # 18 leap seconds ahead of UTC
        content += ubx.UBXMessage(
            "NAV", "NAV-PVT", 0, iTOW=tow_ms, year=2024, month=6, day=14, hour=10, min=0,
            second=i // 10, nano=100_000_000 * (i % 10) - 210, validDate=1, validTime=1, fixType=3,
            gnssFixOk=1, carrSoln=2, numSV=17, lon=13.25, lat=52.5 + i * 1.8e-6, hMSL=52100,
            gSpeed=2000, headMot=0.0,
        ).serialize()  # fmt: skip
        content += ubx.UBXMessage(
            "NAV", "NAV-RELPOSNED", 0, version=1, iTOW=tow_ms, relPosHeading=30.0,
            relPosHeadingValid=1,
        ).serialize()  # fmt: skip
    path = tmp_path / "log.bin"
    path.write_bytes(content[:-3])
    assert found_in(path).own_map["gnss"]["heading"]["unit"] == "deg"
    gnss = read(path).streams["gnss"]
    assert np.diff(gnss["epoch_ns"]).tolist() == [10**8] * 19
    np.testing.assert_allclose(gnss["v_north_mps"], 2.0)
    np.testing.assert_allclose(gnss["heading_rad"][:19], math.radians(60.0), atol=1e-6)
    assert READERS["ubx"].fits(path, content[:64])


@pytest.mark.parametrize(
    "body", ["GPVTG,0.0,,,,4.0,,7.4,", "GPVTG,0.0,,4.0,7.4", "GPVTG,0.0,T,,M,4.0,N,7.4,K"]
)
def test_old_and_blank_forms_of_vtg(tmp_path, body):
    gnss = log_of(tmp_path, [sentence(b) for s in range(9) for b in (gga(s), body)]).streams["gnss"]
    np.testing.assert_allclose(gnss["v_north_mps"], 7.4 / 3.6)


def test_gll_and_a_date_from_zda(tmp_path):
    lines = [
        sentence(body)
        for s in range(20)
        for body in (
            f"GNZDA,1000{s:05.2f},14,06,2024,00,00",
            f"GNGLL,52{30 + 2 * s / 1852:011.8f},N,01315.0,E,1000{s:05.2f},A,A",
        )
    ]
    gnss = log_of(tmp_path, lines).streams["gnss"]
    assert gnss["epoch_ns"][0] == 1_718_359_200 * 10**9
    assert len(gnss["epoch_ns"]) == 20
    np.testing.assert_allclose(gnss["v_north_mps"][1:-1], 2.0, atol=0.01)
