"""Whatever is thrown at `read`: a Log that obeys the contract, or one line of BadInput."""

import tempfile
from pathlib import Path

from example_log import HEADER, MAP, rows
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from nmea_lines import checksum

from twin.errors import BadInput
from twin.logs import read
from twin.streams import check

MODEST = settings(
    max_examples=100, deadline=None, suppress_health_check=[HealthCheck.too_slow], derandomize=True
)


def longest_rise(order: list[int]) -> list[int]:
    """A longest strictly rising part, by trying."""
    best: list[list[int]] = [[]]
    for i, value in enumerate(order):
        before = [b for b in best if not b or b[-1] < value]
        best = [*best, [*max(before, key=len), value]] if i < 12 else best
    return max(best, key=len)


def read_or_refuse(log: bytes, column_map: bytes | None, name: str = "log.csv") -> bool:
    """Whether the log was read; fails on anything but a sound Log or a one-line BadInput."""
    with tempfile.TemporaryDirectory() as folder:
        path, map_path = Path(folder) / name, Path(folder) / "map.toml"
        path.write_bytes(log)
        map_path.write_bytes(column_map or b"")
        try:
            found = read(path, None if column_map is None else map_path)
        except BadInput as error:
            message = str(error)
            assert message.isprintable()
            assert len(message) <= 400
            assert message.startswith(folder)
            return False
        check(found.streams)
        assert found.streams.tables
        if found.rows is not None and "wheels" in found.streams:
            assert {len(v) for v in found.rows.values()} == {
                len(found.streams["wheels"]["epoch_ns"])
            }
        return True


good = "\n".join([HEADER, *(",".join(r) for r in rows(12))]).encode()
cells = st.one_of(
    st.sampled_from(
        [
            "",
            "nan",
            "inf",
            "-inf",
            "1e400",
            "-0",
            "1e308",
            "9" * 30,
            "0x10",
            "1,5",
            '"',
            "\x00",
            "é",
        ]
    ),
    st.floats().map(repr),
    st.integers().map(str),
    st.text(max_size=8),
)


@MODEST
@given(st.binary(max_size=400))
def test_random_bytes(content):
    for name in ("log.csv", "log.parquet", "log.nmea"):
        read_or_refuse(content, MAP.encode(), name)
    read_or_refuse(b"PAR1" + content + b"PAR1", MAP.encode())


@MODEST
@given(st.lists(st.tuples(st.integers(0, 11), st.integers(0, 6), cells), min_size=1, max_size=4))
def test_cells_replaced(changes):
    table = rows(12)
    for row, column, cell in changes:
        table[row][column] = cell
    text = "\n".join([HEADER, *(",".join(r) for r in table)])
    read_or_refuse(text.encode("utf-8", "surrogatepass"), MAP.encode())


@MODEST
@given(st.integers(0, len(good)), st.integers(0, 20), st.binary(max_size=20))
def test_bytes_cut_and_put_in(at, cut, put):
    read_or_refuse(good[:at] + put + good[at + cut :], MAP.encode())


@MODEST
@given(st.lists(st.sampled_from(range(12)), min_size=1, max_size=20))
def test_rows_shuffled_repeated_and_left_out(order):
    table = rows(12)
    text = "\n".join([HEADER, *(",".join(table[i]) for i in order)])
    read = read_or_refuse(text.encode(), MAP.encode())
    rising = max(len(kept) for n in range(len(order), -1, -1) for kept in [longest_rise(order)])
    if len(order) > 1:
        assert read == (len(order) - rising <= 3)


@MODEST
@given(st.integers(0, len(MAP)), st.integers(0, 10), st.text(max_size=10))
def test_column_maps_bent(at, cut, put):
    bent = MAP[:at] + put + MAP[at + cut :]
    read_or_refuse(good, bent.encode("utf-8", "surrogatepass"))


toml_values = st.recursive(
    st.one_of(
        st.booleans().map(lambda b: str(b).lower()),
        st.integers().map(str),
        st.sampled_from(["nan", "inf", "-1e999", "1979-05-27", '"M"', '"s"', '"t"', "''"]),
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3).map(lambda v: f"[{', '.join(v)}]"),
        st.dictionaries(st.sampled_from(["column", "unit", "state", "x"]), inner, max_size=2).map(
            lambda d: "{" + ", ".join(f"{k} = {v}" for k, v in d.items()) + "}"
        ),
    ),
    max_leaves=5,
)


@MODEST
@given(
    st.sampled_from(["log", "gnss", "wheels", "rows", "steady", "zero_slip", "setup", "reference"]),
    st.sampled_from(["time", "speed", "driven_speed", "state", "where", "min_speed_kmh", "machine",
                     "wheelbase_m", "driven", "origin", "wheels", "gnss", "slip"]),
    toml_values,
)  # fmt: skip
def test_column_maps_of_any_values(section, key, value):
    read_or_refuse(good, f"[{section}]\n{key} = {value}\n".encode())
    lines = [line for line in MAP.splitlines() if not line.startswith(f"{key} =")]
    at = lines.index(f"[{section}]") + 1 if f"[{section}]" in lines else len(lines)
    read_or_refuse(good, "\n".join([*lines[:at], f"{key} = {value}", *lines[at:]]).encode())


fields = st.lists(
    st.one_of(
        st.sampled_from(["", "A", "V", "N", "S", "E", "W", "4521.05", "01157.08", "101500",
                         "235959", "4", "9999999", "310299", "320199", "1e5", "nan", "٣"]),
        st.text(max_size=6),
    ),
    max_size=14,
)  # fmt: skip


@MODEST
@given(st.lists(st.tuples(st.sampled_from(["GGA", "RMC", "VTG", "HDT"]), fields), max_size=6))
def test_nmea_sentences_of_any_fields(sentences):
    fix = "GPGGA,101459.00,4521.0570600,N,01157.0840174,E,4,12,0.8,75.2,M,45.0,M,,"
    lines = [f"${fix}*{checksum(fix):02X}"]
    for kind, values in sentences:
        body = ",".join([f"GP{kind}", *values])
        sum_ = checksum(body) if body.isascii() else 0
        lines.append(f"${body}*{sum_:02X}")
    read_or_refuse("\n".join(lines).encode("utf-8", "surrogatepass"), None)
