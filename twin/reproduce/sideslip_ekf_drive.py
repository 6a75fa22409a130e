"""One drive for `sideslip-ekf`: a calibration on level ground, then a run that slides."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from estimators.bounds import total_sd_m
from twin.pipeline.named import load
from twin.pipeline.run import run
from twin.scenario import Scenario
from twin.scores import scores
from twin.streams import Setup, Streams, Table

STEP_S = 1.0
"""Totals are compared with the truth in such steps."""


@dataclass(frozen=True, kw_only=True)
class Drive:
    """Errors of one run: of the total within the scored window, and of all that is stated.

    The stated sd of a total is that since the run's start, where the estimator begins anew.
    """

    total_m: float
    """What the centre of gravity slides by within the window; positive to the left."""
    error_m: float
    """Estimated less true."""
    bound_m: float
    """Least sd of it; NaN with a camera."""
    run_error_m: float
    """Error of the total of the whole run."""
    run_sd_m: float
    """Its stated sd."""
    total_covered: float
    """Share of time in which the total since the run's start is within 2 sd of the truth."""
    angle_rms_rad: float
    """Error of the sideslip angle within the window, while it drives."""
    angle_covered: float
    """Share of its samples within 2 sd."""


def drive(scenario: Scenario, seed: int) -> Drive:
    """Drive a scenario, estimate, compare. Raises BadInput, Diverged."""
    done = run(replace(scenario, seed=seed), estimators={})
    lean_rad = math.radians(scenario.field.cross_slope_deg)
    return compared(done.setup, done.streams, done.truth, lean_rad)


def compared(setup: Setup, streams: Streams, truth: Table, lean_rad: float) -> Drive:
    """Estimates of a drive against its truth, which begins with the run.

    Args:
        setup, streams, truth: of the drive.
        lean_rad: how the ground leans across the run.

    Raises:
        ValueError: fewer than 200 samples of driving.
    """
    own = load("estimator", "sideslip-ekf")
    _, table = own.run(own.init(setup), streams)
    told = np.isfinite(table["sideslip_m"]) & (table["epoch_ns"] >= truth["epoch_ns"][0])
    part = {name: column[told] for name, column in table.items()}
    window_s = scores.window_s(truth)
    off, sd = scores.errors(truth, part, "sideslip_m"), part["sideslip_sd_m"]
    off -= off[0]
    known = np.isfinite(off)  # to the truth's end
    off, sd, part = off[known], sd[known], {name: column[known] for name, column in part.items()}
    scored = part["epoch_ns"] >= round(window_s[0] * 1e9)
    angle = scores.errors(truth, part, "sideslip_rad")
    driven = scored & np.isfinite(angle) & ~scores.is_slow(truth, part["epoch_ns"])
    within = np.abs(angle[driven]) <= 2.0 * part["sideslip_sd_rad"][driven]
    true_m = scores.at(truth, "sideslip_m", part["epoch_ns"])[scored]
    bound_m = math.nan
    if "camera" not in streams:
        bound_m = total_sd_m(setup, streams, truth, window_s, lean_rad)
    every = max(round(STEP_S / float(np.median(np.diff(part["epoch_ns"]) * 1e-9))), 1)
    return Drive(
        total_m=float(true_m[-1] - true_m[0]),
        error_m=float(off[-1] - off[scored][0]),
        bound_m=bound_m,
        run_error_m=float(off[-1]),
        run_sd_m=float(sd[-1]),
        total_covered=float(np.mean((np.abs(off) <= 2.0 * sd)[every::every])),
        angle_rms_rad=float(np.sqrt(np.mean(angle[driven] ** 2))),
        angle_covered=float(np.mean(within)),
    )
