"""The recording protocol as the simulated tractor drives it: slip, pitch and brakes included."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.pipeline.machine_drive import BIAS_RADPS, NOMINAL_RADIUS_M, machine_drive
from twin.logs import Log
from twin.pipeline.protocol import GRAVITY_MPS2, applied
from twin.streams import Streams

LOG, DRIVER = machine_drive()
ROWS = np.array(DRIVER.rows)


def parts(log: Log) -> dict[str, dict]:
    _, found = applied(log)
    return {str(part["part"]): part for part in found["protocol"]["parts"]}


def during(name: str) -> list[np.ndarray]:
    return [ROWS[(ROWS[:, 0] >= a) & (ROWS[:, 0] <= b)] for a, b in DRIVER.phases[name]]


def scale(rows: np.ndarray) -> float:
    speed = np.hypot(rows[:, 3], rows[:, 4])
    return float(speed.mean() / (NOMINAL_RADIUS_M * rows[:, 5:7].mean()))


def late(by_s: float) -> Log:
    gnss = LOG.streams["gnss"]
    shift = round(by_s * 1e9)
    moved = {**gnss, **{k: gnss[k] + shift for k in ("epoch_ns", "arrival_ns")}}
    return replace(LOG, streams=Streams({**LOG.streams.tables, "gnss": moved}))


FOUND = parts(LOG)


def test_every_part_is_found() -> None:
    assert [name for name, part in FOUND.items() if not part["found"]] == []


def test_the_zero_slip_scale_is_that_of_the_passes() -> None:
    true = np.mean([scale(rows) for rows in during("pass")])
    assert FOUND["zero-pull passes"]["number"] == pytest.approx(true, abs=5e-4)


def test_towed_wheels_turn_less() -> None:
    true = scale(during("towed")[0][500:])
    assert FOUND["towed-wheel run"]["number"] == pytest.approx(true, abs=1e-3)
    assert FOUND["towed-wheel run"]["number"] > FOUND["zero-pull passes"]["number"]


def test_rolling_resistance_is_the_deceleration() -> None:
    true = []
    for rows in during("coast"):
        speed = np.hypot(rows[:, 3], rows[:, 4])[50:-50]
        true.append((speed[0] - speed[-1]) / (0.02 * (len(speed) - 1)) / GRAVITY_MPS2)
    assert FOUND["coast-down"]["number"] == pytest.approx(np.mean(true), rel=0.03)


def test_the_bias_of_the_gyro() -> None:
    assert FOUND["standing"]["number"] == pytest.approx(BIAS_RADPS, abs=5e-5)


@pytest.mark.parametrize("by_s", [0.0, 0.12, 0.4, -0.25])
def test_the_lag_is_told_apart_from_the_slip_of_starts_and_stops(by_s: float) -> None:
    part = parts(late(by_s))["clock check"]
    assert part["number"] == pytest.approx(by_s, abs=0.02)
    assert (part["used"] == "GNSS moved by it") is (by_s != 0.0)


def test_a_receiver_at_1_hz_tells_the_lag_too() -> None:
    log = late(0.4)
    gnss = {name: column[::10] for name, column in log.streams["gnss"].items()}
    slow = replace(log, streams=Streams({**log.streams.tables, "gnss": gnss}))
    assert parts(slow)["clock check"]["number"] == pytest.approx(0.4, abs=0.1)


def test_wheels_that_lock_tell_no_lag() -> None:
    log, _ = machine_drive(brake=1.0)
    part = parts(log)["clock check"]
    assert part["value"] == "wheels locked or spun; brake more gently"
    assert part["used"] == ""
