"""A calibration of a log with wheel counts, axle torque and depth: the machine itself is driven."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.calibration.applied import believed, can_fit
from twin.calibration.evidence import Evidence, evidence
from twin.calibration.fitting import STEP, Fit, Prior, Remember, fit
from twin.calibration.held_out import BAND_SD, BLOCK_S, Score, gain, line, rms
from twin.calibration.known import KNOWN
from twin.calibration.rollouts import Condition, Drawn, Gear, Rollouts
from twin.calibration.segments import Segment, segments
from twin.errors import BadInput, UnknownName
from twin.logs import Log
from twin.scenario import Soil
from twin.streams import Table
from twin.vehicle import Machine, files
from twin.vehicle.numerics import machine_facts

Array = NDArray[np.float64]

PARAMETERS = (
    "rear.free_rolling_radius_m", "front.free_rolling_radius_m", "transmission.efficiency",
    "soil.cone_index_kpa", "soil.friction", "soil.draft_scale", "soil.mobility_resistance",
    "log.set_rpm", "log.reference_torque_nm",
)  # fmt: skip
"""What such a log may tell of."""
NEEDED = ("front_speed_mps", "axle_torque_nm", "depth_m")
"""Columns without which the machine itself is not driven."""
SET_OVER = 1.02
"""Engine speed that the throttle asks for, over the fastest in the log."""
USUAL_PLOUGH = "plough_1lf435"


@dataclass(frozen=True)
class DriveFit:
    """A fit and its parts."""

    fit: Fit
    score: Score


def can(rows: Table) -> bool:
    """Whether a log has what the machine itself needs to be driven along it."""
    return all(name in rows and np.isfinite(rows[name]).any() for name in NEEDED)


def prior_of(machine: Machine, soil: Soil, names: Sequence[str], rows: Table) -> Prior:
    """What is believed of parameters before the log.

    Raises:
        UnknownName: a parameter such a log tells nothing of.
    """
    for name in names:
        if name not in PARAMETERS:
            raise UnknownName("parameter of a log with depth and axle torque", name, PARAMETERS)
    kept = [name for name in names if can_fit(machine, name)]
    value, spread, grades = zip(*(_belief(machine, soil, n, rows) for n in kept), strict=True)
    high = np.log([KNOWN[n].high for n in kept])
    no_load_rpm = machine_facts(machine).numbers["engine.no_load_rpm"]
    if "log.set_rpm" in kept:
        high[kept.index("log.set_rpm")] = np.log(0.999 * no_load_rpm)
    mean = np.minimum(np.log(value), high)
    low = np.log([KNOWN[n].low for n in kept])
    return Prior(tuple(kept), mean, np.array(spread), low, high, grades)


def _belief(machine: Machine, soil: Soil, name: str, rows: Table) -> tuple[float, float, str]:
    if name == "log.set_rpm":
        fastest = float(np.nanmax(rows["engine_radps"])) * 30.0 / np.pi
        return SET_OVER * fastest, KNOWN[name].spread, "derived"
    if name == "log.reference_torque_nm":
        numbers = machine_facts(machine).numbers
        most_nm = numbers["engine.rated_torque_nm"] * numbers["engine.torque_rise"]
        return most_nm, KNOWN[name].spread, "assumed"
    return believed(machine, soil, name)


def fitted_to(
    machine: Machine, soil: Soil, names: Sequence[str], log: Log, rows: Table, *,
    all_wheel_drive: bool | None, seed: int, starts: int, nthread: int, remember: Remember,
) -> DriveFit:  # fmt: skip
    """The fit to the segments of a log, and how it foretells those that are held back.

    Raises:
        BadInput: too little steady work, or the log does not say which wheels it counts.
    """
    parts = segments(rows)
    implement = files.implement(files.usual_implement(machine) or USUAL_PLOUGH)
    if log.setup.wheels is None:
        raise BadInput("the log has no [wheels] with radii; they tell speeds from counts")
    radii = log.setup.wheels.radius_m
    depth_m = float(np.mean([np.nanmean(rows["depth_m"][s.rows]) for s in parts if s.working]))
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = rows["engine_radps"] * radii["rl"] / rows["wheel_speed_mps"]
    gear = Gear(float(np.nanmedian(ratio[np.isfinite(ratio)])))
    driven = front_drives(rows, parts) if all_wheel_drive is None else all_wheel_drive
    drawn = Drawn(machine, implement, soil, depth_m, driven)
    prior = prior_of(machine, soil, names, rows)
    own, held = (
        evidence(rows, [s for s in parts if s.held_back is back]) for back in (False, True)
    )
    if own.channels != held.channels:
        raise BadInput("the last quarter of the log lacks sensors of the rest; a log with the same "
                       "sensors throughout would do")  # fmt: skip

    def model(of: Evidence) -> Rollouts:
        conditions = tuple(Condition(s.working, gear) for s in of.segments)
        return Rollouts(drawn, prior.names, of, conditions, (radii["fl"], radii["rl"]), nthread)

    found = fit(model(own), prior, seed=seed, starts=starts, remember=remember)
    return DriveFit(found, _scored(model(held), found, own, held, rows, seed))


def front_drives(rows: Table, parts: Sequence[Segment]) -> bool:
    """Whether the front wheels drive: at work they then slip as the rear ones do.

    Driven where their slip is above half of the rear wheels', 1 - v / (w R).
    """
    at = np.concatenate([np.arange(len(rows["speed_mps"]))[s.rows] for s in parts if s.working])
    speed = rows["speed_mps"][at]
    front, rear = (
        np.nanmedian(1.0 - speed / rows[f"{w}_speed_mps"][at]) for w in ("front", "wheel")
    )
    return bool(front > 0.5 * rear)


def _scored(
    model: Rollouts, found: Fit, own: Evidence, held: Evidence, rows: Table, seed: int
) -> Score:
    """Slip of the held-out segments, foretold, beside a line and a constant."""
    beside = found.u + np.vstack([np.zeros(len(found.u)), STEP * np.eye(len(found.u))])
    foretold = model.foretold(np.exp(beside))
    slip_of = [held.channels.index(c) for c in ("speed_mps", "wheel_speed_mps")]
    slips = 1.0 - foretold[..., slip_of[0]] / foretold[..., slip_of[1]]
    slopes = (slips[1:] - slips[0]).T / STEP
    fitted, measured = (_slip(e) for e in (own, held))
    error = measured - slips[0]
    noise = np.std(np.concatenate([_rows_of(rows, s) for s in own.segments if s.working]))
    lasts = np.array([s.rows.stop - s.rows.start for s in held.segments])
    of_parameters = np.einsum("ip,pq,iq->i", slopes, found.cov, slopes)
    band = BAND_SD * np.sqrt(of_parameters + noise**2 / lasts)
    forces = [_force(rows, e.segments) for e in (own, held)]
    off_line, off_constant = measured - line(fitted, *forces), measured - np.median(fitted)
    low, high = gain(error, off_line, held.time_s, seed)
    fuel = "fuel_lph" in held.channels
    at = held.channels.index("fuel_lph") if fuel else 0
    return Score(
        slip_rms=rms(error), slip_mae=float(np.mean(np.abs(error))), bias=float(np.mean(error)),
        coverage=float(np.mean(np.abs(error) <= band)), line_rms=rms(off_line),
        line_mae=float(np.mean(np.abs(off_line))), constant_rms=rms(off_constant),
        gain_low=low, gain_high=high,
        fuel_rms_lph=rms(held.measured[:, at] - foretold[0][:, at]) if fuel else np.nan,
        speed_rms_mps=rms(held.measured[:, slip_of[0]] - foretold[0][:, slip_of[0]]),
        rows=len(error), blocks=len(np.unique(held.time_s // BLOCK_S)),
    )  # fmt: skip


def _slip(of: Evidence) -> Array:
    speed, wheel = (of.measured[:, of.channels.index(c)] for c in ("speed_mps", "wheel_speed_mps"))
    return np.asarray(1.0 - speed / wheel)


def _rows_of(rows: Table, segment: Segment) -> Array:
    """Slip of each second of a segment, about its mean."""
    slip = 1.0 - rows["speed_mps"][segment.rows] / rows["wheel_speed_mps"][segment.rows]
    return np.asarray(slip - np.mean(slip))


def _force(rows: Table, parts: Sequence[Segment]) -> Array:
    """Mean axle torque of each segment [N m]."""
    return np.array([np.nanmean(rows["axle_torque_nm"][s.rows]) for s in parts])
