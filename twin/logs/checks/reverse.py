"""Driving backward in a log: machines often report the size of a speed without its sign.

The sign of the wheels' speeds comes from a column of its own, `[wheels] direction`; else from where
the antennas say that the ground's velocity points against their heading.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.logs.gaps import between
from twin.streams import Array, Table

BACKWARD_MPS = 0.3
"""A machine goes backward where the ground passes faster than this against its heading [m/s]."""
UNSIGNED_MPS = 0.02
"""Speeds that never go below minus this have no sign [m/s]: noise about zero may be below it."""
LEAST_ROWS, MOST = 3, 0.5
"""Backward rows that are no chance, and the share of all driving above which the heading is wrong
rather than the machine in reverse."""


def signed(tables: dict[str, Table], mount_rad: float) -> tuple[dict[str, Table], list[str]]:
    """The tables with signs on the speeds of the wheels, and notes that say what was done.

    Args:
        tables: of the streams, `wheels` perhaps with a column `direction`.
        mount_rad: from the body to the antenna baseline, whose heading is measured.
    """
    wheels = dict(tables.get("wheels", {}))
    told = wheels.pop("direction", None)
    speeds = [k for k in wheels if k.startswith("speed_") and k != "speed_sd_mps"]
    out = {**tables, "wheels": wheels} if wheels else dict(tables)
    along = _along(tables.get("gnss", {}), mount_rad)
    if told is not None:
        backward = _backward(told)
        out["wheels"] = wheels | {k: _turned(np.abs(wheels[k]), backward) for k in speeds}
        out["wheels"] |= {
            k: _counted(v, backward) for k, v in wheels.items() if k.startswith("ticks_")
        }
        note = f"wheels: {int(backward.sum())} rows are driven backward, as wheels.direction says"
        out, more = _ground(out, backward, along)
        return out, [note, *more] if backward.any() else []
    if not speeds:
        return out, []
    if any(np.nanmin(wheels[k], initial=0.0) < -UNSIGNED_MPS for k in speeds) or along is None:
        return out, []
    at_s, own_s = _seconds(tables)
    ground = between(at_s, own_s, along)
    backward, driven = ground < -BACKWARD_MPS, np.abs(ground) > BACKWARD_MPS
    if backward.sum() < LEAST_ROWS:
        return out, []
    if backward.sum() > MOST * driven.sum():
        return out, [
            "gnss: the ground's velocity points against the heading in most driving; is"
            " heading_mount_rad in [setup.gnss] off by pi?"
        ]
    backward |= (ground < 0.0) & _beside(backward, at_s)
    out["wheels"] = wheels | {k: _turned(wheels[k], backward) for k in speeds}
    return out, [
        f"wheels: {int(backward.sum())} speeds without a sign are taken as backward, where the"
        " ground's velocity points against the heading"
    ]


def _backward(told: Array) -> NDArray[np.bool_]:
    """Rows of backward driving: negative, or 0 where nothing is negative (ISO 11783: 0, 1)."""
    return np.asarray(told < 0.0 if np.nanmin(told, initial=0.0) < 0.0 else told == 0.0)


def _turned(speed: Array, backward: NDArray[np.bool_]) -> Array:
    return np.where(backward, -speed, speed)


def _counted(ticks: Array, backward: NDArray[np.bool_]) -> Array:
    """Counts that go down backward, of a sensor of one channel that counts up both ways."""
    step = np.diff(ticks, prepend=ticks[:1])
    if np.any(step < 0):
        return ticks
    return np.asarray(ticks[:1] + np.cumsum(np.where(backward, -step, step)), ticks.dtype)


def _along(gnss: Table, mount_rad: float) -> Array | None:
    """Ground speed along the heading, v_east cos h + v_north sin h; None without a heading."""
    if not {"heading_rad", "v_east_mps", "v_north_mps"} <= set(gnss):
        return None
    heading = gnss["heading_rad"] - mount_rad
    along: Array = gnss["v_east_mps"] * np.cos(heading) + gnss["v_north_mps"] * np.sin(heading)
    return along if np.isfinite(along).any() else None


def _seconds(tables: dict[str, Table]) -> tuple[Array, Array]:
    """Times of the wheels and of the receiver from one start [s]."""
    start_ns = tables["gnss"]["epoch_ns"][0]
    at_s, own_s = ((tables[s]["epoch_ns"] - start_ns) * 1e-9 for s in ("wheels", "gnss"))
    return at_s, own_s


def _beside(chosen: NDArray[np.bool_], at_s: Array) -> NDArray[np.bool_]:
    """Rows within a second of a chosen one: the slow ends of backward driving."""
    own = at_s[chosen]
    right = np.minimum(np.searchsorted(own, at_s), len(own) - 1)
    nearest = np.minimum(np.abs(own[right] - at_s), np.abs(own[np.maximum(right - 1, 0)] - at_s))
    return np.asarray(nearest <= 1.0)


def _ground(
    tables: dict[str, Table], backward: NDArray[np.bool_], along: Array | None
) -> tuple[dict[str, Table], list[str]]:
    """The ground's velocity turned where it points along the heading while the wheels go backward.

    A speed without a course was laid along the heading, whichever way the machine went.
    """
    if along is None or not backward.any():
        return tables, []
    at_s, own_s = _seconds(tables)
    near = np.clip(np.searchsorted(at_s, own_s), 0, len(at_s) - 1)
    behind = backward[near] & (along > 0.0)
    if (
        not (behind & (along > BACKWARD_MPS)).sum()
        > MOST * (backward[near] & (np.abs(along) > BACKWARD_MPS)).sum()
    ):
        return tables, []
    gnss = dict(tables["gnss"])
    for axis in ("v_east_mps", "v_north_mps"):
        gnss[axis] = np.where(behind, -gnss[axis], gnss[axis])
    note = "gnss: there the velocity lay along the heading, and is turned to point backward"
    return {**tables, "gnss": gnss}, [note]
