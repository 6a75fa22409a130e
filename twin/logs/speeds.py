"""Ground speed and wheel speed, which define slip, from the streams of a log."""

from __future__ import annotations

import numpy as np

from twin.logs.gaps import between
from twin.streams import Array, Streams


def ground_speed_mps(streams: Streams) -> Array:
    """Horizontal GNSS speed sqrt(v_east^2 + v_north^2) [m/s] at the epochs of `gnss`."""
    east, north = (streams.column("gnss", f"v_{axis}_mps") for axis in ("east", "north"))
    return np.asarray(np.hypot(east, north))


def driven_speed_mps(streams: Streams) -> Array:
    """Absolute value of the mean rear-wheel speed [m/s] at the epochs of `wheels`."""
    rear = [streams.column("wheels", f"speed_{w}_mps") for w in ("rl", "rr")]
    return np.asarray(np.abs(np.mean(rear, axis=0)))


def paired_speeds(streams: Streams) -> tuple[Array, Array]:
    """Ground speed and mean driven-wheel speed [m/s] at the epochs of `wheels`.

    Both have shape (0,) without either sensor; NaN where one was not measured.
    """
    if "gnss" not in streams or "wheels" not in streams:
        return np.empty(0), np.empty(0)
    ground, driven = ground_speed_mps(streams), driven_speed_mps(streams)
    if np.array_equal(streams["gnss"]["epoch_ns"], streams["wheels"]["epoch_ns"]):
        return ground, driven
    start = int(streams["gnss"]["epoch_ns"][0])
    gnss_s, wheels_s = ((streams[s]["epoch_ns"] - start) * 1e-9 for s in ("gnss", "wheels"))
    return between(wheels_s, gnss_s, ground), driven
