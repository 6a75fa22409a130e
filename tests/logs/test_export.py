"""A run as the files of a real machine, and back within what each format resolves."""

import numpy as np
import pytest
from made_drive import SLIP, drive

from twin import cli
from twin.commands.run import load_estimators
from twin.errors import BadInput, UnknownName
from twin.logs import read
from twin.logs.export import WRITERS, export
from twin.logs.setup_block import setup_from
from twin.pipeline.log import estimate
from twin.streams import WHEELS, Streams

CM_S = 0.01
RADII = (0.6, 0.6, 0.8, 0.8)
RESOLUTION = {
    "csv": {},
    "nmea": {"east_m": 2e-5, "north_m": 2e-5, "up_m": 1e-4, "v_east_mps": 5e-5,
             "v_north_mps": 5e-5, "heading_rad": 2e-6},
    "candump": {"east_m": 1e-6, "north_m": 1e-6, "up_m": 1e-5, "v_east_mps": 0.6 * CM_S,
                "v_north_mps": 0.6 * CM_S, "heading_rad": 6e-5, "gyro_z_radps": 2e-8,
                "engine_radps": 0.07 * np.pi / 30, "engine_load": 0.006, "fuel_lph": 0.03,
                "draft_pin_n": 5.1},
    "mcap": {"east_m": 1e-6, "north_m": 1e-6, "up_m": 1e-6, "heading_rad": 1e-12},
}  # fmt: skip
"""Half a step of each format, and what its rounding of times and angles adds."""


NEEDS = {"candump": "can", "mcap": "rosbags"}


def setup():
    raw = {
        "machine": "made", "wheelbase_m": 2.5, "origin": [48.0, 9.0, 420.0],
        "wheels": {"counts_per_turn": 4000, "radius_m": dict(zip(WHEELS, RADII, strict=True))},
        "gnss": {}, "imu": {}, "depth": {},
    }  # fmt: skip
    return setup_from(raw, assume=True)


def streams(seed=0):
    columns = drive(60.0, 20.0, seed)
    generator = np.random.default_rng(seed)
    epoch_ns = np.round(columns["t"] * 1e9).astype(np.int64)
    stamps = {"epoch_ns": epoch_ns, "arrival_ns": epoch_ns}
    angle = np.radians(90.0 - columns["course"])
    n = len(epoch_ns)
    hole = np.where(generator.random(n) < 0.05, np.nan, 0.0)
    turn = np.cumsum(columns["wheel"] / 3.6) / 20.0 / (2 * np.pi)
    return Streams({
        "gnss": {
            **stamps, "east_m": 300.0 * np.sin(columns["t"] / 90.0),
            "north_m": 200.0 * np.cos(columns["t"] / 70.0), "up_m": 0.1 * columns["t"],
            "v_east_mps": columns["v"] * np.cos(angle), "v_north_mps": columns["v"] * np.sin(angle),
            "v_up_mps": 0.01 * generator.normal(size=n),
            "heading_rad": np.angle(np.exp(1j * (angle + 0.01))) + hole,
            "quality": np.full(n, 4), "satellites_main": np.full(n, 21),
        },
        "imu": {**stamps, **{f"gyro_{a}_radps": 0.1 * generator.normal(size=n) for a in "xyz"},
                **{f"accel_{a}_mps2": generator.normal(size=n) for a in "xyz"}},
        "wheels": {**stamps, **{f"ticks_{w}": np.round(turn / r * 4000).astype(np.int64)
                                for w, r in zip(WHEELS, RADII, strict=True)}},
        "machine": {**stamps, "engine_radps": 150.0 + 5.0 * generator.normal(size=n),
                    "engine_load": generator.uniform(0.1, 1.0, n) + hole,
                    "fuel_lph": generator.uniform(5.0, 20.0, n),
                    "draft_pin_n": generator.uniform(-500.0, 3e4, n),
                    "steer_rad": 0.1 * generator.normal(size=n)},
        "depth": {**stamps, "laser_m": generator.uniform(0.5, 1.0, n)},
    })  # fmt: skip


def files_of(folder, kind):
    if kind == "mcap":
        return folder / "bag"
    return sorted(p for p in folder.iterdir() if p.suffix != ".toml")


@pytest.mark.parametrize("kind", WRITERS)
@pytest.mark.parametrize("seed", [0, 1])
def test_out_and_in_again(tmp_path, kind, seed):
    if kind in NEEDS:
        pytest.importorskip(NEEDS[kind])
    ours = streams(seed)
    lost = export(ours, setup(), kind, tmp_path / kind)
    back = read(files_of(tmp_path / kind, kind), tmp_path / kind / "map.toml", strict=True)
    assert back.setup.origin == (48.0, 9.0, 420.0)
    compared = 0
    for sensor, table in back.streams.tables.items():
        if sensor == "wheels" and kind == "candump":
            continue
        np.testing.assert_array_equal(table["epoch_ns"], ours[sensor]["epoch_ns"])
        for column in set(table) - {"epoch_ns", "arrival_ns"}:
            assert f"{sensor}.{column}" not in lost
            step = RESOLUTION[kind].get(column, 0.0)
            theirs, own = table[column].astype(float), ours[sensor][column].astype(float)
            if column == "heading_rad":
                theirs = own + np.angle(np.exp(1j * (theirs - own)))
            np.testing.assert_allclose(theirs, own, atol=step + 1e-15, rtol=1e-12, err_msg=column)
            compared += 1
    held = sum(len(t) - 2 for t in ours.tables.values()) - len(lost)
    assert compared + (4 if kind == "candump" else 0) == held


def test_the_first_map_of_an_exported_run_gives_its_slip(tmp_path):
    export(streams(), setup(), "csv", tmp_path / "csv")
    files, own = files_of(tmp_path / "csv", "csv"), tmp_path / "csv" / "map.toml"
    assert cli.main(["map", *map(str, files), "--out", str(tmp_path / "m.toml"), "--quiet"]) == 0
    text = (tmp_path / "m.toml").read_text()
    assert "# ?" not in text.partition("\n")[2]
    made = (tmp_path / "edited.toml").write_text(
        text.partition("[setup]")[0] + own.read_text()[own.read_text().index("[setup]") :]
    )
    assert made
    slips = {}
    for each in (own, tmp_path / "edited.toml"):
        result = estimate(files, each, estimators=load_estimators("ratio"))
        slips[each.name] = result.found["slip"]["ratio"]["median"]
    assert slips["edited.toml"] == pytest.approx(slips["map.toml"], abs=1e-3)
    assert slips["map.toml"] == pytest.approx(SLIP, abs=0.01)


def test_wheels_on_a_bus_are_speeds_each_tenth_of_a_second(tmp_path):
    pytest.importorskip("can")
    ours = streams()
    export(ours, setup(), "candump", tmp_path / "out")
    log = read(tmp_path / "out" / "bus.candump", tmp_path / "out" / "map.toml")
    wheels = log.streams["wheels"]
    assert np.median(np.diff(wheels["epoch_ns"])) == 1e8
    true = np.interp(wheels["epoch_ns"] * 1e-9, drive(60.0, 20.0)["t"], drive(60.0, 20.0)["wheel"])
    for wheel, step in (("rl", 1 / 16), ("fr", 1 / 16)):
        counted = 3.6 * 2 * np.pi * 0.8 / 4000 / 0.1  # a count in a tenth of a second
        error = wheels[f"speed_{wheel}_mps"] * 3.6 - true
        assert np.nanmax(np.abs(error)) < step + counted + 0.12


@pytest.mark.parametrize("kind", WRITERS)
def test_nothing_to_write_writes_nothing(tmp_path, kind):
    if kind == "mcap":
        pytest.importorskip("rosbags")
    with pytest.raises(BadInput):
        export(Streams({}), setup(), kind, tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


def test_a_format_that_is_none(tmp_path):
    with pytest.raises(UnknownName, match="did you mean 'nmea'"):
        export(streams(), setup(), "nmeaa", tmp_path / "out")


def test_the_command(tmp_path, capsys):
    from twin.io.run_folder import write_parquet

    run = tmp_path / "run"
    (run / "streams").mkdir(parents=True)
    (run / "streams" / "setup.json").write_text(setup().to_json())
    for name, table in streams().tables.items():
        write_parquet(table, run / "streams" / f"{name}.parquet")
    assert cli.main(["export", str(run), "--as", "nmea"]) == 0
    assert (tmp_path / "run-nmea" / "gnss.nmea").exists()
    assert "nmea does not hold" in capsys.readouterr().out
    assert cli.main(["export", str(run), "--as", "nmea"]) == 2
    assert "exists; name another folder" in capsys.readouterr().err
    assert cli.main(["export", str(run), "--as", "gpx", "--out", str(tmp_path / "g")]) == 2
    assert cli.main(["export", str(tmp_path / "none"), "--as", "nmea"]) == 2
