"""A long log: rows are chosen, foretold and held back; what cannot be fitted says why."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from twin import cli
from twin.calibration.calibrate import calibrate
from twin.calibration.posterior import beside, read
from twin.calibration.steady import Steady
from twin.calibration.steady_rows import SteadyRows
from twin.scenario import Soil
from twin.vehicle import files

MAP = """
[log]
time = {column = "time_s", unit = "s"}
[gnss]
latitude = {column = "lat", unit = "deg"}
longitude = {column = "lon", unit = "deg"}
speed = {column = "gnss_mps", unit = "m/s"}
heading = {column = "heading_deg", unit = "deg"}
[wheels]
driven_speed = {column = "wheel_mps", unit = "m/s"}
[machine]
engine_speed = {column = "rpm", unit = "rpm"}
engine_torque = {column = "torque_pct", unit = "%"}
fuel_rate = {column = "fuel_lph", unit = "L/h"}
[rows]
state = {column = "state"}
[steady]
where = {state = ["W"]}
[zero_slip]
where = {state = ["M"]}
"""
TRUE = {
    "soil.cone_index_kpa": 1100.0, "soil.friction": 0.88, "transmission.efficiency": 0.87,
    "engine.parasitic_nm": 26.7, "engine.fuel_l_per_kwh": 0.31, "log.reference_torque_nm": 640.0,
    "log.wheel_scale": 0.98, "log.carried_kg": 1200.0,
}  # fmt: skip


def written(folder: Path, minutes: int = 60) -> Path:
    """A log by the laws at TRUE: 50 s of work, 10 s of a faster drive without load, and again."""
    random = np.random.default_rng(0)
    count = 60 * minutes
    time_s = np.arange(count)
    work = time_s % 60 < 50
    wheel = np.where(work, 2.2, 3.2) + 0.002 * random.standard_normal(count)
    level = 0.55 + 0.2 * random.random(minutes)[time_s // 60]
    torque = np.where(work, level, 0.12)
    engine = wheel * 82.0 * (1.0 + 0.002 * random.standard_normal(count))
    rows = SteadyRows(time_s.astype(float), np.ones(count), wheel, engine, torque,
                      torque * engine / wheel, np.ones(count))  # fmt: skip
    model = Steady(files.machine("nh_t7165s"), Soil(preset="tilled"), tuple(TRUE), rows, True)
    empty = TRUE | {"log.carried_kg": 0.0}
    at_work, alone = model.foretold(np.array([list(TRUE.values()), list(empty.values())]))
    ratio, fuel = np.where(work[:, None], at_work, alone).T
    gnss = ratio * wheel + 0.02 * random.standard_normal(count)
    fuel = fuel * (1.0 + 0.01 * random.standard_normal(count))
    north = np.cumsum(gnss)
    path = folder / "field.csv"
    with path.open("w") as out:
        out.write("time_s,lat,lon,gnss_mps,heading_deg,wheel_mps,rpm,torque_pct,fuel_lph,state\n")
        for i in range(count):
            out.write(
                f"{i},{45.0 + north[i] / 111132.0:.8f},11.9,{gnss[i]:.4f},0,{wheel[i]:.4f},"
                f"{engine[i] * 30 / np.pi:.1f},{100 * torque[i]:.1f},{fuel[i]:.2f},"
                f"{'W' if work[i] else 'M'}\n"
            )
    (folder / "map.toml").write_text(MAP)
    return path


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(tmp_path_factory.mktemp("log"))


def test_the_command_finds_what_made_the_log_and_foretells_the_rest(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [str(log), "--map", str(log.with_name("map.toml")), "--machine", "nh_t7165s"]
    assert cli.main(["calibrate", *words, "--out", str(tmp_path), "--starts", "1", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert list(found) == ["schema", "parameters", "holdout"]
    assert list(found["parameters"][0]) == ["name", "value", "low", "high", "verdict"]
    rows = {p["name"]: p for p in found["parameters"]}
    inside = [rows[n]["low"] <= v <= rows[n]["high"] for n, v in TRUE.items()]
    assert sum(inside) >= len(inside) - 1
    assert rows["soil.cone_index_kpa"]["verdict"] != "identified"
    held = found["holdout"]
    assert held["slip_rms"] < 0.006
    assert held["slip_rms"] < 1.05 * held["line_rms"]
    assert held["slip_rms"] < held["constant_rms"]
    assert 0.85 <= held["coverage"] <= 1.0
    assert held["gain_low"] <= held["gain_high"]
    machine = tmp_path / "nh_t7165s.calibrated.toml"
    assert files.machine(str(machine)).engine.fuel_l_per_kwh == pytest.approx(
        rows["engine.fuel_l_per_kwh"]["value"]
    )
    assert set(read(beside(machine)).names) == set(rows)
    page = machine.with_suffix(".html").read_text()
    assert "What is known together" in page
    assert "field.csv" in page
    assert not list(tmp_path.glob(".*calibrating*"))


def test_only_the_asked_parameters_are_fitted_and_the_held_part_changes_nothing(
    log: Path, tmp_path: Path
) -> None:
    def fitted(path: Path) -> list[float]:
        found = calibrate(path, log.with_name("map.toml"), machine="nh_t7165s", starts=1,
                          parameters=["soil.cone_index_kpa"], hold_out_s=(2400.0, 4e3))  # fmt: skip
        names = [p.name for p in found.parameters]
        assert names[0] == "soil.cone_index_kpa"
        assert all(n.startswith("log.") for n in names[1:])
        return [p.value for p in found.parameters]

    lines = log.read_text().splitlines()
    other = tmp_path / "other.csv"
    blank = [",".join([*(c := line.split(","))[:3], "", *c[4:]]) for line in lines[2402:]]
    other.write_text("\n".join([*lines[:2402], *blank]) + "\n")
    assert fitted(log) == pytest.approx(fitted(other), rel=2e-3)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda t: t[:31], "lasts 30 s"),
        (lambda t: [t[0], *(still(line) for line in t[1:])], "stands still"),
    ],
)
def test_a_log_that_cannot_be_fitted_says_what_is_missing(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], change: object, said: str
) -> None:
    bad = tmp_path / "bad.csv"
    bad.write_text("\n".join(change(log.read_text().splitlines())) + "\n")  # type: ignore[operator]
    refused(bad, log.with_name("map.toml"), capsys, said)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["bad.csv"]


@pytest.mark.parametrize(
    ("section", "said"),
    [("wheels", "no wheel speed"), ("machine", "no engine speed")],
)
def test_a_map_that_lacks_a_sensor_is_told(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], section: str, said: str
) -> None:
    lines, kept, inside = MAP.splitlines(), [], False
    for line in lines:
        inside = line == f"[{section}]" if line.startswith("[") else inside
        kept += [] if inside or (section == "wheels" and "where" in line) else [line]
    text = "\n".join(kept).replace("[steady]", "").replace("[zero_slip]", "")
    text = text if section == "wheels" else "\n".join(kept)
    (tmp_path / "map.toml").write_text(text)
    refused(log, tmp_path / "map.toml", capsys, said)


def still(line: str) -> str:
    cells = line.split(",")
    return ",".join([cells[0], "45.0", cells[2], "0.004", cells[4], "0.0", *cells[6:]])


def refused(log: Path, table: Path, capsys: pytest.CaptureFixture[str], said: str) -> None:
    words = ["calibrate", str(log), "--map", str(table), "--machine", "nh_t7165s"]
    assert cli.main([*words, "--out", str(table.parent)]) == 2
    err = capsys.readouterr().err
    assert said in err
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "no log is named"),
        (["LOG"], "--machine is missing"),
        (["absent.csv", "--machine", "nh_t7165s"], "there is no such file"),
        (["LOG", "--machine", "nh_t7165s", "--hold-out", "9,3"], "two rising numbers"),
        (["LOG", "--machine", "nh_t7165s", "--parameters", "mass"], "no parameter is called"),
        (["LOG", "--machine", "nh_t7165s", "--starts", "0"], "1 or more"),
    ],
)
def test_bad_words_are_refused(
    log: Path, capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    assert cli.main(["calibrate", *(str(log) if w == "LOG" else w for w in words)]) == 2
    assert said in capsys.readouterr().err
