"""Write `columns.md` from `twin.io.columns` and the flags of the estimators.

    python docs/column_page.py

`tests/docs/test_columns.py` compares the page with what this makes.
"""

from __future__ import annotations

import sys
from pathlib import Path

PAGE = Path(__file__).with_name("columns.md")
sys.path.insert(0, str(PAGE.parents[1]))

from estimators import layout  # noqa: E402
from estimators.slip_ekf import layout as slip_ekf  # noqa: E402
from twin.io.columns import ESTIMATES, STAMPS, STREAMS, TRUTH, Columns  # noqa: E402

HEAD = """# Columns

<!-- Written by `python docs/column_page.py` from `twin/io/columns.py`; edit that. -->

Every column of streams, truth and estimates. The name of a quantity with a unit ends in the unit.
[Concepts](concepts.md) defines slip, sideslip and the frames.

| frame | axes |
|---|---|
| world | east, north, up; the origin is the start of the planned line |
| body | forward, left, up from the rear-axle centre |
| ground | the plane of the ground: x is the body's x axis projected on it, y is to the left |
| - | a number without a direction |

Angles about an upward axis are positive counter-clockwise, to the left. Numbers are `float64`, and
`true/false` is `bool`, unless the table names another type. An unknown value is NaN.
"""

SENSORS = {
    "gnss": "RTK receiver with two antennas.",
    "imu": "Three gyroscopes and three accelerometers.",
    "wheels": "Encoders, or speeds from the machine's bus. If a log has one wheel-based vehicle "
    "speed only, the columns of both driven wheels hold it.",
    "depth": "Laser and inclinometer on the plough. Depth is `zero_m - laser_m "
    "cos(inclination_rad)`, with `zero_m` from the set-up.",
    "machine": "The tractor's CAN bus, and transducers that are read through it.",
    "camera": "A camera that looks down and computes visual odometry itself. Velocities are NaN "
    "where `used` is false.",
}

FLAGS = (
    (
        layout,
        "OUT_OF_ORDER",
        "a sample was not newer than the last one of its sensor, or over 5 s old, and was left out",
    ),
    (layout, "NO_GROUND_SPEED", "the ground speed is unknown or older than 5 s"),
    (layout, "RESTARTED", "the filter started again after a gap of more than 5 s"),
    (slip_ekf, "GATED", "a speed was outside its gate and was rejected"),
    (slip_ekf, "RAISED", "the plough is out of the ground, and the filter assumes almost no slip"),
    (slip_ekf, "NO_FRONT", "no count of a towed wheel for a second"),
    (slip_ekf, "NO_IMU", "no acceleration for a second"),
    (
        slip_ekf,
        "ONE_WHEEL",
        "the driven wheels differ by more than turning explains; the filter uses one of them",
    ),
    (layout, "REPEATED", "the GNSS receiver repeated its last velocity and heading exactly"),
)


def table(columns: Columns) -> str:
    """One row for each column."""
    rows = [f"| `{name}` | {c.unit} | {c.frame} | {c.meaning} |" for name, c in columns.items()]
    return "\n".join(["| column | unit | frame | meaning |", "|---|---|---|---|", *rows])


def page() -> str:
    """The page as Markdown."""
    parts = [
        HEAD,
        "## Streams\n",
        "Every stream begins with the same two columns:\n",
        table(STAMPS),
    ]
    for sensor, columns in STREAMS.items():
        parts += [f"\n### {sensor}\n", f"{SENSORS[sensor]}\n", table(columns)]
    parts += [
        "\n## Truth\n",
        "`truth.parquet` has a row every 20 ms. `power_engine_w` is the sum of all other powers "
        "and of the rate of change of `kinetic_j` + `potential_j`.\n",
        table(TRUTH),
        "\n## Estimates\n",
        "An estimator gives `epoch_ns` and the other columns that it knows. The first column of "
        "`estimates.parquet` is the estimator's name, `estimator`.\n",
        table(ESTIMATES),
        "\n### Flags\n",
        "`flags` is a sum of these numbers. `slip-ekf` alone sets 8 to 128; most estimators set "
        "the others.\n",
        "| flag | name | meaning |\n|---|---|---|",
        *(f"| {getattr(where, name)} | `{name}` | {text} |" for where, name, text in FLAGS),
    ]
    return "\n".join(parts) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
