"""Calibration by simulation: the truths that are drawn, and what is said of many trials."""

from __future__ import annotations

import math

import numpy as np
import pytest

from twin.calibration.applied import believed
from twin.calibration.simulated import MACHINES, Trial, drawn_truth, driven, table, told
from twin.scenario import Soil
from twin.vehicle import files

NAME = "soil.draft_scale"


def trials(count: int, shift: float = 0.0, spread: float = 1.0) -> list[Trial]:
    z = shift + spread * np.random.default_rng(0).standard_normal(count)
    return [Trial(i, "a", "", {NAME: 1.0}, {NAME: 0.02 * float(each)}, {NAME: 0.02},
                  {NAME: "identified"}) for i, each in enumerate(z)]  # fmt: skip


def test_a_right_posterior_is_told_from_a_wrong_one() -> None:
    right, wide, narrow, biased = (
        told(trials(200, *each))[0] for each in ((), (0.0, 0.5), (0.0, 2.0), (1.0,))
    )
    assert right.covered_low <= right.covered <= right.covered_high
    assert right.uniform_p > 0.05
    assert right.error == pytest.approx(0.0135, rel=0.2)  # 0.6745 sd
    assert wide.covered > wide.covered_high
    assert narrow.covered < narrow.covered_low
    assert biased.bias_sd == pytest.approx(1.0, abs=0.15)
    assert max(wide.uniform_p, narrow.uniform_p, biased.uniform_p) < 0.01


def test_what_was_refused_is_counted_and_says_nothing() -> None:
    refused = Trial(9, "a", "too short", {NAME: 1.0}, {}, {}, {})
    assert told([*trials(20), refused]) == told(trials(20))
    assert table([*trials(20), refused]).startswith("21 logs, 1 not driven or refused")


@pytest.mark.parametrize("name", MACHINES)
def test_truths_are_drawn_from_what_is_believed_and_can_be_driven(name: str) -> None:
    machine, soil = files.machine(name), Soil(preset="tilled")
    generator = np.random.default_rng(1)
    drawn = [drawn_truth(machine, soil, generator) for _ in range(30)]
    value, sd, _ = believed(machine, soil, NAME)
    logs = [math.log(d[NAME] / value) for d in drawn]
    assert np.std(logs) == pytest.approx(sd, rel=0.4)
    scenario = driven(machine, soil, drawn[0], generator, seed=3)
    assert scenario.soil.resolved.draft_scale == pytest.approx(drawn[0][NAME])
    key = "tyre_rear.free_rolling_radius_m"
    assert scenario.facts.numbers[key] == pytest.approx(drawn[0]["rear.free_rolling_radius_m"])
