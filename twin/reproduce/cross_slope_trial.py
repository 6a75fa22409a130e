"""One drive of the cross-slope experiment, with the antennas open and masked."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from twin.lookup import attribute
from twin.registry import load
from twin.run import run
from twin.scenario import Scenario
from twin.sensors import Outage
from twin.streams import Setup, Streams, Table

OWN = "sideslip-ekf"
PRINTED = "estimators.cross_slope:"
MASK = Outage(start_s=1.0, duration_s=60.0, kind="mask")


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """A total, told and true, over the same instants."""

    told_m: float
    true_m: float
    sd_m: float = float("nan")

    @property
    def error_m(self) -> float:
        """Told less true."""
        return self.told_m - self.true_m

    @property
    def relative(self) -> float:
        """|error| / |true|"""
        return abs(self.error_m) / abs(self.true_m)


@dataclass(frozen=True, kw_only=True)
class Trial:
    """What one seed gave."""

    total_m: float
    length_m: float
    """Along the slope's contour."""
    time_s: float
    exit_heading_deg: float
    estimates: dict[tuple[str, bool], Estimate]
    """By method and whether the antennas were masked."""


def trial(name: str, seed: int, slope_deg: float, *, papers: bool = True) -> Trial:
    """Drive a scenario once the own way and once the paper's, without a calibration.

    Args:
        name: of the scenario with the antennas open.
        seed: of all chance.
        slope_deg: of the platform, which the paper's chain is told.
        papers: whether the paper's chains are run too.
    """
    named: Scenario = load("scenario", name)
    scenario = replace(named, seed=seed)
    found: dict[tuple[str, bool], Estimate] = {}
    own = load("estimator", OWN)
    true: Table = {}
    for masked, (setup, streams, truth) in _open_and_masked(scenario).items():
        true = truth
        found[OWN, masked] = _estimate(own, setup, streams, truth)
    if papers:
        found |= _papers(scenario, slope_deg)
    heading = np.degrees(2.0 * np.arctan2(true["qz"], true["qw"]))
    return Trial(
        total_m=float(true["sideslip_m"][-1]),
        length_m=float(np.hypot(*(np.ptp(true[c]) for c in ("east_m", "north_m")))),
        time_s=float(np.ptp(true["epoch_ns"])) * 1e-9,
        exit_heading_deg=float(heading[-1] - heading[0]),
        estimates=found,
    )


def _papers(scenario: Scenario, slope_deg: float) -> dict[tuple[str, bool], Estimate]:
    camera = scenario.sensors.camera
    assert camera is not None
    printed = replace(camera, odometry="orb-printed")
    course = replace(scenario.course, calibration_m=0.0)
    sensors = replace(scenario.sensors, camera=printed)
    methods = {
        "GNSS chain as printed": _own("GnssChain", slope_deg=slope_deg, printed=True),
        "GNSS chain put right": _own("GnssChain", slope_deg=slope_deg),
        "camera as printed": _own("CameraChain"),
        "fusion without W": _own("WeightedFusion", slope_deg=slope_deg, weight="none"),
        "fusion as printed": _own("WeightedFusion", slope_deg=slope_deg, weight="both"),
        "fusion, W per sensor": _own("WeightedFusion", slope_deg=slope_deg, weight="sensor"),
    }
    drives = _open_and_masked(replace(scenario, course=course, sensors=sensors))
    return {
        (name, masked): _estimate(method, *drive)
        for masked, drive in drives.items()
        for name, method in methods.items()
    }


def _own(name: str, **settings: Any) -> Any:
    return attribute("estimator", PRINTED + name)(**settings)


def _open_and_masked(scenario: Scenario) -> dict[bool, tuple[Setup, Streams, Table]]:
    """The drive with its sensors, and the same one with another receiver's samples.

    No sensor's chance depends on another's, so the camera need not be drawn twice.
    """
    seen = run(scenario, estimators={})
    sensors = scenario.sensors
    if sensors.gnss is None:
        return {False: (seen.setup, seen.streams, seen.truth)}
    gnss = replace(sensors.gnss, outages=(MASK,))
    blind = replace(scenario, sensors=replace(sensors, gnss=gnss, camera=None))
    masked = run(blind, estimators={}).streams["gnss"]
    streams = Streams({**seen.streams.tables, "gnss": masked})
    return {
        False: (seen.setup, seen.streams, seen.truth),
        True: (seen.setup, streams, seen.truth),
    }


def _estimate(estimator: Any, setup: Setup, streams: Streams, truth: Table) -> Estimate:
    """The change of its total between the run's first and last estimate, and the true one."""
    _, table = estimator.run(estimator.init(setup), streams)
    epoch_ns = table["epoch_ns"]
    inside = (epoch_ns >= truth["epoch_ns"][0]) & (epoch_ns <= truth["epoch_ns"][-1])
    rows = np.flatnonzero(inside & np.isfinite(table["sideslip_m"]))
    ends = rows[[0, -1]]
    start_ns = truth["epoch_ns"][0]
    true = np.interp(
        (epoch_ns[ends] - start_ns).astype(float),
        (truth["epoch_ns"] - start_ns).astype(float),
        truth["sideslip_m"],
    )
    told = table["sideslip_m"][ends]
    sd = table["sideslip_sd_m"][ends[1]] if "sideslip_sd_m" in table else np.nan
    return Estimate(
        told_m=float(told[1] - told[0]), true_m=float(true[1] - true[0]), sd_m=float(sd)
    )
