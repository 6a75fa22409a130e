import math

import numpy as np
import pytest
from nmea_lines import checksum, sentence

from twin.errors import BadInput
from twin.logs import read


def write(tmp_path, *bodies):
    path = tmp_path / "drive.nmea"
    path.write_text("\r\n".join(map(sentence, bodies)) + "\r\n")
    return path


def refusal(path, **options):
    with pytest.raises(BadInput) as caught:
        read(path, **options)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def gga(time, quality=4, minutes="21.0570600"):
    return f"GNGGA,{time},45{minutes},N,01157.0840174,E,{quality},12,0.8,75.2,M,45.0,M,,"


def test_a_published_sentence():
    # the example of the NMEA 0183 RMC sentence found in receiver manuals
    assert checksum("GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W") == 0x6A


def test_sentences_of_one_time_are_one_epoch(tmp_path):
    path = write(
        tmp_path,
        gga("101500.00"),
        "GNRMC,101500.00,A,4521.0570600,N,01157.0840174,E,4.0,180.0,231023,,,R",
        "GNVTG,90.0,T,,M,4.0,N,7.2,K,R",
        "GNHDT,45.0,T",
        gga("101500.20"),
        "GNRMC,101500.20,A,4521.0570600,N,01157.0840174,E,4.0,180.0,231023,,,R",
    )
    log = read(path)
    gnss = log.streams["gnss"]  # 2023-10-23 10:15
    assert gnss["epoch_ns"].tolist() == [
        1_698_056_100_000_000_000,
        1_698_056_100_200_000_000,
    ]
    # 7.2 km/h east from VTG, which is finer than the knots of RMC; then 4 knots south
    np.testing.assert_allclose(gnss["v_east_mps"], [2.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(gnss["v_north_mps"], [0.0, -4 * 1852 / 3600], atol=1e-12)
    assert gnss["heading_rad"][0] == pytest.approx(math.pi / 4)
    assert np.isnan(gnss["heading_rad"][1])
    assert gnss["quality"].tolist() == [4, 4]
    assert log.setup.origin[0] == pytest.approx(45.350951)
    assert log.setup.origin[1] == pytest.approx(11.95140029)
    assert log.setup.origin[2] == pytest.approx(75.2)


def test_midnight_rolls_over_with_and_without_a_date(tmp_path):
    log = read(write(tmp_path, gga("235959.50"), gga("000000.50"), gga("000001.50")))
    assert np.diff(log.streams["gnss"]["epoch_ns"]).tolist() == [10**9, 10**9]
    rmc = "GNRMC,{},A,4521.0570600,N,01157.0840174,E,0.0,,{},,,R"
    log = read(write(tmp_path, rmc.format("120000", "281223"), rmc.format("120001", "010124")))
    assert np.diff(log.streams["gnss"]["epoch_ns"])[0] == (4 * 86400 + 1) * 10**9


def test_a_wrong_checksum_is_left_out_and_told(tmp_path):
    path = write(tmp_path, gga("101500.00"), gga("101501.00"), gga("101502.00"))
    path.write_text(path.read_text().replace("101501.00", "101501.01"))
    log = read(path)
    assert len(log.streams["gnss"]["epoch_ns"]) == 2
    note = "1 of 3 rows left out: lines with a wrong checksum (first at line 2)"
    assert note in log.notes


@pytest.mark.parametrize(
    ("bodies", "says"),
    [
        ([gga("101501.00"), gga("101500.00")], ["row 2", "out of order"]),
        ([gga("251500.00")], ["line 1", "time"]),
        ([gga("101500.00", minutes="61.0")], ["line 1", "61.0"]),
        ([gga("101500.00").replace("0.8,75.2", "0.8,abc")], ["line 1", "abc"]),
        (["GNVTG,90.0,T,,M,4.0,N,7.2,K,R"], ["no GGA or RMC"]),
        (["GNGGA,101500.00,45"], ["line 1", "GGA"]),
    ],
)
def test_what_is_wrong_and_where(tmp_path, bodies, says):
    message = refusal(write(tmp_path, *bodies), strict=True)
    for part in says:
        assert part in message, message


def test_no_fix_is_not_a_position(tmp_path):
    log = read(write(tmp_path, "GNGGA,101459.00,,,,,0,00,,,M,,M,,", gga("101500.00")))
    assert np.isnan(log.streams["gnss"]["east_m"]).tolist() == [True, False]
    assert log.streams["gnss"]["quality"].tolist() == [0, 4]


def test_a_time_out_of_order_is_told_once(tmp_path):
    times = [f"1015{s:02d}.00" for s in (*range(30), 12, *range(30, 59))]
    log = read(write(tmp_path, *map(gga, times)))
    said = [note for note in log.notes if "out of order" in note]
    assert len(said) == 1
    assert said[0].startswith("1 of 60 rows left out")
