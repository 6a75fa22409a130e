"""One drive of the cross-slope experiment, with the antennas open and masked."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.camera import tracking
from twin.camera.tracking import Tracker
from twin.pipeline.estimating import Estimator
from twin.pipeline.named import load
from twin.pipeline.run import run
from twin.plugins.lookup import attribute
from twin.scenario import Scenario
from twin.sensors import Outage
from twin.streams import Setup, Streams, Table

OWN = "sideslip-ekf"
PRINTED = "estimators.cross_slope:"
MASK = Outage(start_s=1.0, duration_s=60.0, kind="mask")


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """A total, estimated and true, over the same instants."""

    told_m: float
    true_m: float
    sd_m: float = float("nan")

    @property
    def error_m(self) -> float:
        """Estimated less true."""
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


@dataclass(frozen=True, kw_only=True)
class Calibrated:
    """What a calibration left behind, for the next drive that begins with the same."""

    seen: Streams
    """Its samples, frames not yet tracked."""
    tracker: Tracker | None
    camera: Table
    state: mujoco.MjData
    """Of the own estimator."""


def trial(
    name: str,
    seed: int,
    slope_deg: float,
    *,
    papers: bool = True,
    before: Calibrated | None = None,
) -> tuple[Trial, Calibrated]:
    """Drive a scenario once the own way and once the paper's, without a calibration.

    Args:
        name: of the scenario with the antennas open.
        seed: of all chance.
        slope_deg: of the platform; the paper's chain gets it.
        papers: whether the paper's chains are run too.
        before: of another drive; its frames are not tracked again where all samples are the same.

    Returns:
        The trial, and its calibration.
    """
    named: Scenario = load("scenario", name)
    scenario = replace(named, seed=seed)
    found: dict[tuple[str, bool], Estimate] = {}
    own = load("estimator", OWN)
    drives, calibrated = _own_drives(scenario, own, before)
    for masked, (streams, truth) in drives.items():
        _, table = own.run(calibrated.state, streams)
        found[OWN, masked] = _change(table, truth)
    true = drives[False][1]
    if papers:
        found |= _papers(scenario, slope_deg)
    heading = np.degrees(2.0 * np.arctan2(true["qz"], true["qw"]))
    made = Trial(
        total_m=float(true["sideslip_m"][-1]),
        length_m=float(np.hypot(*(np.ptp(true[c]) for c in ("east_m", "north_m")))),
        time_s=float(np.ptp(true["epoch_ns"])) * 1e-9,
        exit_heading_deg=float(heading[-1] - heading[0]),
        estimates=found,
    )
    return made, calibrated


def _own_drives(
    scenario: Scenario, own: Estimator, before: Calibrated | None
) -> tuple[dict[bool, tuple[Streams, Table]], Calibrated]:
    """The run's samples and truth, antennas open and masked, and the calibration before it.

    Odometry's result does not depend on how a drive is cut, nor does the estimator's.
    """
    camera = scenario.sensors.camera
    assert camera is not None
    raw = replace(scenario.sensors, camera=replace(camera, odometry="none"))
    drives = _open_and_masked(replace(scenario, sensors=raw))
    setup, streams, truth = drives[False]
    start_ns = int(truth["epoch_ns"][0])
    first = _cut(streams, lambda epoch_ns: epoch_ns < start_ns)
    with ThreadPoolExecutor(1) as pool:
        if before is None or not _same(before.seen, first):
            tracker = tracking.tracker(setup, camera.odometry, camera.processing_s)
            tracked = first
            if tracker is not None:
                tracker, tracked = tracker.track(first, pool)
            state, _ = own.run(own.init(setup), tracked)
            before = Calibrated(seen=Streams(first.tables), tracker=tracker,
                                camera=tracked["camera"], state=state)  # fmt: skip
        after = _cut(streams, lambda epoch_ns: epoch_ns >= start_ns)
        if before.tracker is not None:
            _, after = before.tracker.track(after, pool)
    rows = {masked: drive[1]["gnss"] for masked, drive in drives.items() if "gnss" in drive[1]}
    late = {m: _cut(Streams({"gnss": g}), lambda e: e >= start_ns)["gnss"] for m, g in rows.items()}
    runs = {m: Streams({**after.tables, "gnss": late[m]}) if m in late else after for m in drives}
    return {masked: (streams, truth) for masked, streams in runs.items()}, before


def _cut(streams: Streams, chosen: Callable[[NDArray[np.int64]], NDArray[np.bool_]]) -> Streams:
    """The samples of some epochs."""
    tables = {}
    for name, table in streams.tables.items():
        rows = chosen(table["epoch_ns"])
        tables[name] = {column: values[rows] for column, values in table.items()}
    return Streams(tables, streams.frames)


def _same(one: Streams, other: Streams) -> bool:
    """Whether all samples are the same to the bit."""
    return one.tables.keys() == other.tables.keys() and all(
        table.keys() == other[name].keys()
        and all(values.tobytes() == other[name][c].tobytes() for c, values in table.items())
        for name, table in one.tables.items()
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


def _own(name: str, **settings: Any) -> Estimator:
    made: Estimator = attribute("estimator", PRINTED + name)(**settings)
    return made


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


def _estimate(estimator: Estimator, setup: Setup, streams: Streams, truth: Table) -> Estimate:
    return _change(estimator.run(estimator.init(setup), streams)[1], truth)


def _change(table: Table, truth: Table) -> Estimate:
    """The change of a total between the run's first and last estimate, and the true one."""
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
