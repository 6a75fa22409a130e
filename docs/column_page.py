"""Write `columns.md` from `twin.columns` and the flags of the estimators.

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
from twin.columns import ESTIMATES, STAMPS, STREAMS, TRUTH, Columns  # noqa: E402

HEAD = """# Columns

<!-- Written by `python docs/column_page.py` from `twin/columns.py`; edit that. -->

Every column of streams, truth and estimates. A name ends in its unit. [Concepts](concepts.md)
defines slip, sideslip and the frames.

| frame | axes |
|---|---|
| world | east, north, up from the start of the course |
| body | forward, left, up from the rear-axle centre |
| ground | the plane of the ground: x is the body's x axis projected on it, y is to the left |
| - | the number has no direction |

Angles are counter-clockwise. Numbers are `float64` unless the table says another type. A value that
is not known is NaN.
"""

SENSORS = {
    "gnss": "RTK receiver with two antennas.",
    "imu": "Three gyroscopes and three accelerometers.",
    "wheels": "Encoders, or speeds from the machine's bus. A single wheel-based vehicle speed "
    "stands in the columns of both driven wheels.",
    "depth": "Laser and inclinometer on the plough. Depth is `zero_m - laser_m "
    "cos(inclination_rad)`, with `zero_m` from the set-up.",
    "machine": "The tractor's own bus, and transducers that are read through it.",
    "camera": "A camera that looks down, with odometry on board. NaN where a frame was not `used`.",
}

FLAGS = (
    (
        layout,
        "OUT_OF_ORDER",
        "a sample was no newer than the last one of its sensor and was left out",
    ),
    (layout, "NO_GROUND_SPEED", "the ground speed is unknown or older than 5 s"),
    (layout, "RESTARTED", "the filter started again after a gap of more than 5 s"),
    (slip_ekf, "GATED", "a speed was outside its gate and was refused"),
    (slip_ekf, "RAISED", "the plough is out of the ground, so the axle is taken to slip hardly"),
    (slip_ekf, "NO_FRONT", "no towed wheel was counted for a second"),
    (slip_ekf, "NO_IMU", "no acceleration came for a second"),
    (slip_ekf, "ONE_WHEEL", "the driven wheels disagree; one of them stands for the axle"),
    (layout, "REPEATED", "the GNSS receiver gave its last velocity and heading again, to the bit"),
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
        "`truth.parquet` holds a row each 20 ms. Powers are counted positive when they leave the "
        "machine, except that of the engine.\n",
        table(TRUTH),
        "\n## Estimates\n",
        "An estimator gives `epoch_ns` and whichever of the others it knows. `estimates.parquet` "
        "has a column `estimator` before them.\n",
        table(ESTIMATES),
        "\n### Flags\n",
        "`flags` is a sum of these numbers:\n",
        "| flag | name | meaning |\n|---|---|---|",
        *(f"| {getattr(where, name)} | `{name}` | {text} |" for where, name, text in FLAGS),
    ]
    return "\n".join(parts) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
