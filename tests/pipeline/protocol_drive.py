"""A made-up drive that holds every part of the recording protocol, with what it should give."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from twin.logs import Log
from twin.streams import Setup, Streams, WheelsSetup

STEP_S = 0.02
IDLE, WORK = 89.0, 170.0  # rad/s
COUNTS, RADIUS_M = 4000, 0.8


@dataclass(frozen=True, kw_only=True)
class Truth:
    scale: float = 0.974
    """Ground speed over logged wheel speed without pull."""
    towed_scale: float = 0.979
    lag_s: float = 0.31
    gyro_bias_radps: float = 0.004
    rolling: float = 0.035
    grade: float = 0.008
    """Uphill to the east."""


def legs(truth: Truth) -> list[tuple[str, float, float, float]]:
    """Name, seconds, speed at the end [m/s], yaw rate [rad/s] of each leg."""
    pulse = [("go", 3.0, 2.0, 0.0), ("go", 2.0, 0.0, 0.0), ("stand", 6.0, 0.0, 0.0)]
    there = [("go", 6.0, 2.0, 0.0), ("pass", 60.0, 2.0, 0.0), ("go", 4.0, 1.5, 0.0)]
    turn = [("go", 12.0, 1.5, np.pi / 12.0)]
    g = 9.81
    up, down = (g * (truth.rolling + sign * truth.grade) for sign in (1.0, -1.0))
    rolls = [
        [("go", 12.0, 5.5, 0.0), ("coast", 10.0, 5.5 - 10.0 * rate, 0.0), ("go", 4.0, 1.5, 0.0)]
        for rate in (up, down)
    ]
    towed = [("go", 6.0, 1.8, 0.0), ("towed", 60.0, 1.8, 0.0), ("go", 3.0, 0.0, 0.0)]
    return [
        ("stand", 60.0, 0.0, 0.0), *pulse, *pulse, *pulse, ("stand", 10.0, 0.0, 0.0),
        *there, *turn, *there, *turn, *rolls[0], *turn, *rolls[1], ("go", 3.0, 0.0, 0.0),
        ("stand", 20.0, 0.0, 0.0), *towed, ("stand", 40.0, 0.0, 0.0),
    ]  # fmt: skip


def drive(
    truth: Truth = Truth(),  # frozen
    *,
    leave_out: tuple[str, ...] = (),
    ticks: bool = False,
    engine: bool = True,
    seed: int = 1,
) -> Log:
    """The drive as a log: GNSS at 10 Hz, wheels, gyro and engine at 50 Hz."""
    rng = np.random.default_rng(seed)
    speed, kind, yaw_rate = [0.0], ["stand"], [0.0]
    for name, seconds, end, turning in legs(truth):
        count = round(seconds / STEP_S)
        speed += list(np.linspace(speed[-1], end, count + 1)[1:])
        kind += ["go" if name in leave_out else name] * count
        yaw_rate += [turning] * count
    v, name, rate = np.array(speed), np.array(kind), np.array(yaw_rate)
    if "pulse" in leave_out:  # no standing between
        first = int(60.0 / STEP_S)
        keep = np.ones(len(v), bool)
        keep[first : first + int(33.0 / STEP_S)] = False
        v, name, rate = v[keep], name[keep], rate[keep]
    t = np.arange(len(v)) * STEP_S
    heading = np.cumsum(rate) * STEP_S
    east, north = (np.cumsum(v * f(heading)) * STEP_S for f in (np.cos, np.sin))
    scale = np.where(np.isin(name, ["towed", "coast"]), truth.towed_scale, truth.scale)
    wheel = v / scale
    fast = (t * 1e9).round().astype(np.int64)
    slow = slice(None, None, 5)
    late_ns = round(truth.lag_s * 1e9)
    noise = 0.01 * rng.standard_normal((2, len(v[slow])))
    gnss = {
        "epoch_ns": fast[slow] + late_ns, "arrival_ns": fast[slow] + late_ns,
        "east_m": east[slow], "north_m": north[slow],
        "v_east_mps": (v * np.cos(heading))[slow] + noise[0],
        "v_north_mps": (v * np.sin(heading))[slow] + noise[1],
    }  # fmt: skip
    stamps = {"epoch_ns": fast, "arrival_ns": fast}
    wheels = {**stamps, "speed_rl_mps": wheel, "speed_rr_mps": wheel}
    if ticks:
        turned = np.cumsum(wheel) * STEP_S / (2.0 * np.pi * RADIUS_M) * COUNTS
        wheels = {**stamps, "ticks_rl": turned.astype(int), "ticks_rr": turned.astype(int)}
    gyro = rate + truth.gyro_bias_radps + 1e-3 * rng.standard_normal(len(v))
    free = np.isin(name, ["stand", "coast", "towed"])
    tables = {"gnss": gnss, "wheels": wheels, "imu": {**stamps, "gyro_z_radps": gyro}}
    if engine:
        tables["machine"] = {**stamps, "engine_radps": np.where(free, IDLE, WORK)}
    setup = Setup(
        machine="made up", wheelbase_m=2.5, track_front_m=1.8, track_rear_m=1.8, cg_x_m=1.0,
        wheels=WheelsSetup(
            rate_hz=50.0, radius_m=dict.fromkeys(("fl", "fr", "rl", "rr"), RADIUS_M),
            counts_per_turn=COUNTS if ticks else None,
        ),
    )  # fmt: skip
    return Log(streams=Streams(tables), setup=setup)
