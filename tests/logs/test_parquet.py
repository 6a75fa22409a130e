import datetime

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from example_log import HEADER, MAP, rows, write, write_map

from twin.errors import BadInput
from twin.logs import read


def table(**changed):
    columns = dict(zip(HEADER.split(","), zip(*rows(), strict=True), strict=True))
    arrays = {k: list(v) if k == "state" else [float(c) for c in v] for k, v in columns.items()}
    return pa.table({**arrays, **changed})


def write_parquet(tmp_path, content):
    path = tmp_path / "log.parquet"
    pq.write_table(content, path)
    return path


def refusal(path, column_map, **options):
    with pytest.raises(BadInput) as caught:
        read(path, column_map, **options)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_parquet_reads_as_csv_does(tmp_path):
    column_map = write_map(tmp_path)
    ours = read(write_parquet(tmp_path, table()), column_map)
    theirs = read(write(tmp_path), column_map)
    for name, expected in theirs.streams.tables.items():
        for column, values in expected.items():
            np.testing.assert_array_equal(ours.streams[name][column], values)
    assert ours.rows["state"].tolist() == theirs.rows["state"].tolist()


def test_timestamps_and_nulls(tmp_path):
    start = datetime.datetime(2023, 10, 23, 8, tzinfo=datetime.UTC)
    stamps = [start + datetime.timedelta(seconds=i) for i in range(30)]
    content = table(t=stamps, v=[None, *[2.0] * 29])
    column_map = write_map(tmp_path, MAP.replace('"t", unit = "s"', '"t", unit = "timestamp"'))
    gnss = read(write_parquet(tmp_path, content), column_map).streams["gnss"]
    assert gnss["epoch_ns"][1] == 1_698_048_001 * 10**9
    assert np.isnan(gnss["v_east_mps"][0])


def test_what_is_wrong_and_where(tmp_path):
    column_map = write_map(tmp_path)
    lists = write_parquet(tmp_path, table(v=[[1.0]] * 30))
    assert "'v'" in refusal(lists, column_map)
    text = write_parquet(tmp_path, table(v=["2.0"] * 29 + ["x"]))
    assert "row 30" in refusal(text, column_map, strict=True)
    absent = write_parquet(tmp_path, table().drop_columns(["wheel"]))
    assert "no column is called 'wheel'" in refusal(absent, column_map)
    none = write_parquet(tmp_path, table().slice(0, 0))
    assert "no rows" in refusal(none, column_map)
    missing = write_parquet(tmp_path, table(t=[None, *map(float, range(1, 30))]))
    assert "row 1: no time" in refusal(missing, column_map, strict=True)


def test_every_truncation_is_refused(tmp_path):
    column_map = write_map(tmp_path)
    path = write_parquet(tmp_path, table())
    whole = path.read_bytes()
    for length in (0, 3, 4, 8, 100, len(whole) // 2, len(whole) - 9, len(whole) - 1):
        path.write_bytes(whole[:length])
        refusal(path, column_map)
