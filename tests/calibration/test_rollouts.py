"""Rollouts of a calibration: a machine that works as deep as the log's laser says."""

from __future__ import annotations

import numpy as np
import pytest

from twin.calibration.evidence import Evidence
from twin.calibration.rollouts import Condition, Drawn, Gear, Rollouts
from twin.scenario import Soil
from twin.vehicle import files
from twin.vehicle.numerics import machine_facts

DEPTH_M = 0.2


def rollouts(depth_by_laser: bool) -> Rollouts:
    machine = files.machine("jd_4250")
    facts = machine_facts(machine)
    part = files.implement(files.usual_implement(machine) or "plough_4")
    drawn = Drawn(machine, part, Soil(preset="tilled"), DEPTH_M, False, depth_by_laser)
    none = Evidence(("speed_mps",), (), np.zeros((0, 1)), np.zeros((0, 1, 1)), np.zeros(0),
                    np.zeros(1))  # fmt: skip
    gear = Gear(facts.usual_ratio)
    return Rollouts(drawn, ("log.set_rpm",), none, (Condition(True, gear),), (0.5, 0.8),
                    np.array([facts.usual_rpm]))  # fmt: skip


def test_the_plough_is_as_deep_as_the_laser_reads() -> None:
    _, by_laser = rollouts(True)._start()
    _, by_shares = rollouts(False)._start()
    assert by_laser[True].laser_depth_m == pytest.approx(DEPTH_M, abs=5e-4)
    assert abs(by_shares[True].laser_depth_m - DEPTH_M) > 1e-3
