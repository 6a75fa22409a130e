"""A log as one table of seconds: everything that a calibration compares."""

from __future__ import annotations

import math

import numpy as np

from twin.errors import BadInput
from twin.logs import Log
from twin.logs.timeline import brought, timeline
from twin.streams import WHEELS, Setup, Streams, Table

ASKED = {
    "wheel_speed_mps": "wheel speed; map [wheels] driven_speed, or ticks or speeds of the wheels",
    "speed_mps": "ground speed; map the speed or the position of [gnss]",
}
"""What a log must have, and what would do."""
LEAST_S = 60.0
"""A shorter log cannot be fitted [s]."""
LEAST_MOVING_S = 45.0
MOVING_MPS = 0.5


def seconds(log: Log) -> Table:
    """The log in rows of a second, with front wheels and depth beside `timeline`'s columns.

    Raises:
        BadInput: no wheel or ground speed, standing still, or too short.
    """
    streams = with_speeds(log.streams, log.setup)
    rows = timeline(streams)
    for column, what in ASKED.items():
        if column not in rows:
            raise BadInput(f"the log has no {what}")
    lasts_s = float(rows["duration_s"].sum())
    if lasts_s < LEAST_S:
        raise BadInput(
            f"the log lasts {lasts_s:.0f} s, too short to fit and to check; {LEAST_S:.0f} s with "
            "steady work would do"
        )
    moving = rows["speed_mps"] > MOVING_MPS
    if float(rows["duration_s"][moving].sum()) < LEAST_MOVING_S:
        fastest = float(np.nanmax(rows["speed_mps"]))
        raise BadInput(
            f"the log stands still: it moves faster than {MOVING_MPS:g} m/s for "
            f"{rows['duration_s'][moving].sum():.0f} s, at most {fastest:.2f} m/s; "
            f"{LEAST_MOVING_S:.0f} s of driving would do"
        )
    return (
        rows
        | _ground(streams, rows)
        | _front(streams, rows)
        | _depth(log, rows)
        | _torque(streams, rows)
    )


def with_speeds(streams: Streams, setup: Setup) -> Streams:
    """The streams with wheel speeds also where a source gives ticks.

    w R = 2 pi R / counts * d ticks / d t, with the nominal radius R
    """
    wheels, block = streams.tables.get("wheels"), setup.wheels
    if wheels is None or block is None or block.counts_per_turn is None:
        return streams
    if len(wheels["epoch_ns"]) < 3:
        return streams
    time_s = (wheels["epoch_ns"] - wheels["epoch_ns"][0]) * 1e-9
    added: Table = {
        f"speed_{w}_mps": 2.0 * math.pi * block.radius_m[w] / block.counts_per_turn
        * np.gradient(wheels[f"ticks_{w}"].astype(np.float64), time_s)
        for w in WHEELS
        if f"ticks_{w}" in wheels
    }  # fmt: skip
    return Streams({**streams.tables, "wheels": {**wheels, **added}}, streams.frames)


def _ground(streams: Streams, rows: Table) -> Table:
    """Speed of the mean velocity of a second: a mean of |v| would count the antenna's sway."""
    epoch_ns = streams["gnss"]["epoch_ns"]
    east, north = (brought(epoch_ns, streams.column("gnss", f"v_{axis}_mps"), rows["epoch_ns"])
                   for axis in ("east", "north"))  # fmt: skip
    return {"speed_mps": np.hypot(east, north)}


def _front(streams: Streams, rows: Table) -> Table:
    speeds = [streams.column("wheels", f"speed_{w}_mps") for w in ("fl", "fr")]
    front = np.mean(speeds, axis=0)
    if not np.isfinite(front).any():
        return {}
    epoch_ns = streams["wheels"]["epoch_ns"]
    return {"front_speed_mps": brought(epoch_ns, np.abs(front), rows["epoch_ns"])}


def _depth(log: Log, rows: Table) -> Table:
    """depth = zero - laser cos(inclination), of the plough's sole below the ground."""
    block, table = log.setup.depth, log.streams.tables.get("depth")
    if block is None or table is None or "laser_m" not in table:
        return {}
    tilt = table.get("inclination_rad", np.zeros(len(table["laser_m"])))
    depth_m = block.zero_m - table["laser_m"] * np.cos(tilt)
    return {"depth_m": brought(table["epoch_ns"], depth_m, rows["epoch_ns"])}


def _torque(streams: Streams, rows: Table) -> Table:
    share = streams.column("machine", "engine_torque")
    if not len(share) or not np.isfinite(share).any():
        return {}
    return {"engine_torque": brought(streams["machine"]["epoch_ns"], share, rows["epoch_ns"])}
