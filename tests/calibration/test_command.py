"""`twin calibrate` at the command line: one line for what is wrong."""

import numpy as np
import pytest

from tests.calibration.bus_log import MAP, bus_log, write
from twin import cli

MACHINE = ["--machine", "nh_t7165s"]


def without(column):
    return {name: values for name, values in bus_log().items() if name != column}


NO_WHEELS = MAP.replace('[wheels]\ndriven_speed = {column = "wheel_kmh", unit = "km/h"}\n', "")
STANDING = bus_log() | {name: np.zeros(1500) for name in ("x", "v", "wheel_kmh")}
REFUSED = {
    "no wheel speed": (without("wheel_kmh"), NO_WHEELS, (), "no wheel speed; map [wheels]"),
    "no torque": (without("torque_pct"), MAP.replace('engine_torque = {column = "torque_pct", '
                  'unit = "%"}\n', ""), (), "no engine torque; map [machine] engine_torque"),
    "standing": (STANDING, MAP, (), "stands still"),
    "30 s": (bus_log(30), MAP, (), "lasts 30 s, too short"),
    "wrong unit": (bus_log(), MAP.replace('"wheel_kmh", unit = "km/h"',
                   '"wheel_kmh", unit = "m/s"'), (), "is one of the units wrong?"),
    "another machine's map": (bus_log() | {"wheel_kmh": 0.6 * bus_log()["wheel_kmh"]}, MAP, (),
                              "another machine's map, or another unit"),
    "too fast an engine": (bus_log() | {"rpm": bus_log()["rpm"] * 1.6}, MAP, (), "no faster than"),
    "no span": (bus_log(), MAP, ("--hold-out", "half"), "half"),
    "unknown parameter": (bus_log(), MAP, ("--parameters", "soil.colour"), "soil.colour"),
    "unknown soil": (bus_log(), MAP, ("--soil", "porridge"), "porridge"),
}  # fmt: skip
"""Columns, map, more options, and what the one line says."""


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_fitted_is_refused_in_one_line(case, tmp_path, capsys):
    columns, column_map, options, said = REFUSED[case]
    out = tmp_path / "out"
    args = ["calibrate", *write(tmp_path, columns, column_map), *MACHINE, *options,
            "--out", str(out)]  # fmt: skip
    assert cli.main(args) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.startswith("twin: ")
    assert error.count("\n") == 1
    assert not out.exists()


@pytest.mark.parametrize(
    ("args", "said"),
    [
        ((), "no log is named"),
        (("nowhere.csv", *MACHINE), "nowhere.csv: there is no such file"),
        ((__file__,), "--machine is missing"),
    ],
)
def test_what_is_not_named_is_asked_for(args, said, capsys):
    assert cli.main(["calibrate", *args]) == 2
    assert said in capsys.readouterr().err
