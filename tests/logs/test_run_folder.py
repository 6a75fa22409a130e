import json

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from example_log import write, write_map

from twin.errors import BadInput
from twin.logs import read
from twin.streams import Setup, check


@pytest.fixture
def run(tmp_path):
    """A run folder written from the example log."""
    log = read(write(tmp_path), write_map(tmp_path))
    folder = tmp_path / "run"
    (folder / "streams").mkdir(parents=True)
    (folder / "streams" / "setup.json").write_text(log.setup.to_json())
    for name, table in log.streams.tables.items():
        pq.write_table(pa.table(table), folder / "streams" / f"{name}.parquet")
    return folder, log


def test_what_was_written_is_read_to_the_bit(run):
    folder, log = run
    back = read(folder)
    check(back.streams)
    assert back.setup == log.setup
    assert set(back.streams.tables) == set(log.streams.tables)
    for name, table in log.streams.tables.items():
        for column, values in table.items():
            assert back.streams[name][column].dtype == values.dtype
            np.testing.assert_array_equal(back.streams[name][column], values)


def bend_setup(folder, **changed):
    path = folder / "streams" / "setup.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), **changed}))


def bend_gnss(folder, **changed):
    path = folder / "streams" / "gnss.parquet"
    columns = {c: np.asarray(pq.read_table(path)[c]) for c in pq.read_schema(path).names}
    pq.write_table(pa.table({**columns, **changed}), path)


@pytest.mark.parametrize(
    ("bend", "says"),
    [
        (lambda f: bend_setup(f, wheelbase_m="long"), "wheelbase_m"),
        (lambda f: bend_setup(f, wheelbase=2.0), "did you mean 'wheelbase_m'?"),
        (lambda f: bend_setup(f, gnss={}), "gnss"),
        (lambda f: (f / "streams" / "setup.json").write_text("{"), "not JSON"),
        (lambda f: (f / "streams" / "setup.json").write_text("[]"), "list"),
        (lambda f: (f / "streams" / "setup.json").unlink(), "run folder"),
        (lambda f: (f / "streams" / "gnss.parquet").write_bytes(b"PAR1"), "Parquet"),
        (
            lambda f: (f / "streams" / "gnss.parquet").rename(f / "streams" / "gns.parquet"),
            "did you mean 'gnss'?",
        ),
        (lambda f: bend_gnss(f, epoch_ns=np.arange(30.0)), "int64"),
        (lambda f: bend_gnss(f, arrival_ns=np.arange(30)[::-1].copy()), "out of order"),
        (lambda f: bend_gnss(f, speed=np.arange(30.0)), "unknown column 'speed'"),
        (lambda f: bend_gnss(f, east_m=np.full(30, np.inf)), "beyond"),
        (lambda f: bend_gnss(f, east_m=["a"] * 30), "numbers"),
    ],
)
def test_a_malformed_folder_is_refused(run, bend, says):
    folder, _ = run
    bend(folder)
    with pytest.raises(BadInput) as caught:
        read(folder)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_column_map_does_not_go_with_a_run_folder(run, tmp_path):
    with pytest.raises(BadInput, match="leave the column map out"):
        read(run[0], write_map(tmp_path))


def test_the_setup_survives_json_with_every_block(tmp_path):
    from twin.logs.setup_block import ASSUMED, setup_from

    raw = {**ASSUMED[""], **{k: ASSUMED[k] for k in ("wheels", "gnss", "imu", "depth")}}
    setup = setup_from(json.loads(json.dumps(raw)), assume=False)
    assert Setup.from_json(setup.to_json()) == setup


def test_the_camera_of_a_run_is_in_its_set_up(run):
    folder, _ = run
    camera = {
        "rate_hz": 30.0, "width_px": 640, "height_px": 400, "focal_px": 500.0,
        "lever_arm_m": [0.4, 0.0, 0.3], "height_m": 0.5,
    }  # fmt: skip
    bend_setup(folder, camera=camera)
    assert read(folder).setup.camera.lever_arm_m == (0.4, 0.0, 0.3)


def test_a_stream_of_a_sensor_of_ones_own_needs_its_block(run):
    folder, _ = run
    radar = {"epoch_ns": [1, 2], "arrival_ns": [1, 2], "speed_mps": [1.0, 1.5]}
    pq.write_table(pa.table(radar), folder / "streams" / "radar.parquet")
    with pytest.raises(BadInput, match="no stream is called 'radar'"):
        read(folder)
    bend_setup(folder, extra={"radar": {"columns": {"speed_mps": ["m/s", "speed"]}}})
    np.testing.assert_array_equal(read(folder).streams["radar"]["speed_mps"], [1.0, 1.5])
    for wrong in ("text", {"radar": 3}, {"radar": {"columns": 3}}, {"radar": {"colums": {}}}):
        bend_setup(folder, extra=wrong)
        with pytest.raises(BadInput, match=r"setup.json.extra"):
            read(folder)
