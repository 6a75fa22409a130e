"""What holds for every estimator where a machine stops, backs up, and has its ignition off.

Each check takes an estimator and raises AssertionError, as those of `twin.testing.checks` do.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from twin.pipeline.estimating import Estimator
from twin.sensors import ignition
from twin.streams import Streams
from twin.testing import drives
from twin.testing.checks import LEAST_COVERAGE, RIGHT, SEEDS, SETUP, run
from twin.testing.drives import Array, Drive, seconds


def _there_and_back(t: Array) -> Array:
    """Forward at 1.6 m/s, a stop at 5 s, backward at 1 m/s from 9 s on, a stop at 13 s [m/s]."""
    at_s, speed_mps = [0.0, 4.0, 5.0, 8.0, 9.0, 12.0, 13.0], [1.6, 1.6, 0.0, 0.0, -1.0, -1.0, 0.0]
    return np.interp(t, at_s, speed_mps)


REVERSING = Drive(
    duration_s=15.0, speed=_there_and_back, slip=lambda t: np.where(t < 6.5, 0.12, -0.12)
)
"""Forward, a stop, backward, a stop. The wheels drive, so the slip has the sign of the speed."""
RESTARTED = Drive(
    duration_s=22.0,
    speed=lambda t: np.interp(t, [0.0, 4.0, 5.0, 15.0, 16.0], [1.6, 1.6, 0.0, 0.0, 1.6]),
    slip=lambda t: 0.12 + 0.0 * t,
)
OFF_S, ON_S = 7.0, 9.0
"""When the ignition is off in that drive [s]; samples are back 2 s later, of the receiver 5 s."""
DRIVEN_BEFORE = 40_000
"""Counts of every wheel before that drive, ten turns."""
FASTEST_MPS = 6.0
"""No speed of that drive is a third of it [m/s]; a filter that goes on with a jerk over the four
seconds without a sample comes to 4, and one that takes the new counters for the old to 15."""
STOPPED_MPS = 0.15
"""Median of an estimated speed that no estimator needs a second after a stop [m/s]."""


def check_reverse(estimator: Estimator) -> None:
    """Through a stop, backward and a stop again slip keeps its sign, and rest is seen as rest."""
    errors, inside = [], []
    for seed in range(SEEDS):
        table, _ = run(estimator, [drives.streams(REVERSING, SETUP, seed)])
        for name, column in table.items():
            assert not np.isinf(column).any(), f"through a stop a value of {name} is infinite"
        t = seconds(table["epoch_ns"])
        for name in ("speed_mps", "wheel_speed_mps"):
            for stopped in ((t > 6.0) & (t < 8.0), t > 14.0):
                found = np.abs(table.get(name, np.zeros(t.shape))[stopped])
                some = found[np.isfinite(found)]
                slow = not len(some) or np.median(some) < STOPPED_MPS
                assert slow, f"a second after a stop {name} is {np.median(some):.2f} m/s"
        back = (t > 9.5) & (t < 12.0)
        errors.append((table["slip"] - REVERSING.slip(t))[back])
        if "slip_sd" in table:
            known = np.isfinite(errors[-1]) & np.isfinite(table["slip_sd"][back])
            inside.append((np.abs(errors[-1]) < 2.0 * table["slip_sd"][back])[known])
    off = float(np.nanmedian(np.abs(np.concatenate(errors))))
    why = "s = (w R - v) / max(|w R|, |v|) is negative where wheels drive backward"
    assert off < RIGHT, f"in reverse slip is off by {off:.3f}; {why}"
    if inside:
        share = float(np.concatenate(inside).mean())
        assert share > LEAST_COVERAGE, f"in reverse {share:.0%} of its errors are within two sd"


def check_restart(estimator: Estimator) -> None:
    """The ignition off and on: counters from zero, a clock that is set, and slip is right again."""
    for clock_s in (-0.3, 0.3):
        table, _ = run(estimator, [_restarted(clock_s)])
        for name, column in table.items():
            assert not np.isinf(column).any(), f"after a restart a value of {name} is infinite"
        for name in ("speed_mps", "wheel_speed_mps"):
            found = np.abs(table.get(name, np.zeros(1)))
            some = found[np.isfinite(found)]
            fast = float(some.max()) if len(some) else 0.0
            assert fast < FASTEST_MPS, (
                f"about a restart {name} is {fast:.1f} m/s: counters begin anew, clocks are set"
            )
        t = seconds(table["epoch_ns"])
        after = t > 17.0
        assert after.sum() > 15, f"after a restart it gives {after.sum()} estimates in 5 s"
        off = float(np.nanmedian(np.abs(table["slip"] - RESTARTED.slip(t))[after]))
        assert off < RIGHT, f"a second after setting off again slip is off by {off:.3f}"


@cache
def _restarted(clock_s: float) -> Streams:
    streams = drives.streams(RESTARTED, SETUP, 1)
    begun_ns = 1_000_000_000
    restart = ignition.Restart(
        off_ns=begun_ns + round(OFF_S * 1e9),
        on_ns=begun_ns + round(ON_S * 1e9),
        clock_ns=round(clock_s * 1e9),
        imu=np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0]),
    )
    told = SETUP.imu
    assert told is not None
    sd = np.repeat([told.gyro_bias_sd_radps, told.accel_bias_sd_mps2], 3)
    tables = dict(streams.tables)
    for name, ticks in tables["wheels"].items():
        if name.startswith("ticks_"):
            tables["wheels"] = {**tables["wheels"], name: ticks + DRIVEN_BEFORE}
    return Streams({n: ignition.switched((restart,), n, t, sd, {})[0] for n, t in tables.items()})
