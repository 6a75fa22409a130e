"""`twin rig`: files and refusals."""

import csv

import numpy as np
import pytest

from twin.cli import main
from twin.rig.tyre import Tyre
from twin.rig.wheel import wheel
from twin.scenario import Soil


def rows(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_the_wheel_rig_writes_every_load_angle_and_slip(tmp_path, capsys):
    out = tmp_path / "wheel"
    status = main(
        ["rig", "wheel", "--load-kn", "15", "20", "--slip", "0", "0.1", "0.3",
         "--slip-angle-deg", "0", "5", "--soil.preset", "tilled", "--out", str(out)]
    )  # fmt: skip
    assert status == 0
    written = rows(out / "wheel.csv")
    assert len(written) == 12
    row = next(r for r in written if r["load_n"] == "15000" and r["slip"] == "0.1")
    seen = wheel(Tyre(), Soil(preset="tilled"), slip=0.1, load_n=15e3)
    assert float(row["net_pull_n"]) == pytest.approx(seen.net_pull_n[0], rel=1e-6)
    assert float(row["axle_torque_nm"]) == pytest.approx(seen.axle_torque_nm[0], rel=1e-6)
    assert {r["load_n"] for r in rows(out / "wheel-free.csv")} == {"15000", "20000"}
    assert (out / "wheel.png").read_bytes().startswith(b"\x89PNG")
    assert "net traction ratio" in capsys.readouterr().out


def test_a_rigid_wheel_on_sand_by_one_command(tmp_path, capsys):
    status = main(
        ["rig", "wheel", "--soil.law", "bekker", "--soil.preset", "lete-sand", "--tyre.rigid",
         "--tyre.diameter-m", "0.9", "--tyre.width-m", "0.3", "--load-kn", "2", "5", "10",
         "--slip", "0", "0.2", "0.5", "--slip-angle-deg", "0", "--out", str(tmp_path)]
    )  # fmt: skip
    assert status == 0
    written = rows(tmp_path / "wheel.csv")
    sinkage = np.array([float(r["sinkage_m"]) for r in written]).reshape(3, 3)
    assert np.all(np.diff(sinkage, axis=0) > 0.0)  # deeper with load
    capsys.readouterr()


def test_parking_writes_one_row_a_slope(tmp_path, capsys):
    status = main(
        ["rig", "park", "--cross-slope-deg", "10", "--grade-deg", "8", "--parked-s", "2",
         "--out", str(tmp_path)]
    )  # fmt: skip
    assert status == 0
    assert [r["cross_slope_deg"] for r in rows(tmp_path / "park.csv")] == ["10", "0"]
    capsys.readouterr()


@pytest.mark.slow
def test_the_table_of_gears(tmp_path, capsys):
    arguments = ["rig", "drawbar", "--table", "--gear-kmh", "15", "12", "--soil.preset", "asphalt"]
    assert main([*arguments, "--out", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    for column in ("pull_n", "speed_mps", "slip", "drawbar_power_w", "fuel_lph"):
        assert column.replace("_", " ") in said
    written = rows(tmp_path / "drawbar-gears.csv")
    assert [r["gear_kmh"] for r in written] == ["12", "15"]
    power = [float(r["drawbar_power_w"]) for r in written]
    assert [float(r["pull_n"]) * float(r["speed_mps"]) for r in written] == pytest.approx(
        power, rel=1e-6
    )
    assert (tmp_path / "drawbar.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "needs the name of a rig"),
        (["weel"], "did you mean 'wheel'"),
        (["wheel", "--slip", "2"], "slip = 2 is outside [-0.95, 0.95]"),
        (["wheel", "--load-kn", "-3"], "load_n = -3000"),
        (["wheel", "--load-kn", "90"], "onto its rim"),
        (["wheel", "--tyre.axle", "third"], "no axle is called 'third'"),
        (["wheel", "--tyre.width-m", "0"], "tyre.width_m = 0"),
        (["wheel", "--soil.law", "coulomb"], "no soil law is called 'coulomb'"),
        (["wheel", "--slip", "fast"], "--slip"),
        (["drawbar", "--hitch-m", "9"], "hitch_m = 9"),
        (
            ["drawbar", "--table", "--step-n", "900"],
            "step_n would not be read",
        ),
        (["drawbar", "--gear-kmh", "9"], "gear_kmh would not be read: it needs --table"),
        (["drawbar", "--table", "--gear-kmh", "99"], "speeds_kmh = 99"),
        (["slope", "--cross-slope-deg", "70"], "cross_slope_deg = 70"),
        (["park", "--parked-s", "-1"], "parked_s = -1"),
    ],
)
def test_bad_values_are_refused_in_one_line_and_nothing_is_written(
    arguments, words, tmp_path, capsys, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    assert main(["rig", *arguments]) == 2
    said = capsys.readouterr().err
    assert words in said.splitlines()[-1]
    assert "Traceback" not in said
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_a_file_is_refused_before_the_work(tmp_path, capsys):
    (tmp_path / "taken").write_text("")
    assert main(["rig", "drawbar", "--out", str(tmp_path / "taken")]) == 2
    assert "is a file, not a folder" in capsys.readouterr().err
