"""A calibration of a fast log: the machine itself is driven, many sets of parameters at once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from twin.calibration import gears as found_gears
from twin.calibration.applied import machine_with
from twin.calibration.evidence import evidence
from twin.calibration.fitting import Fit, beside, fit
from twin.calibration.gears import Gear
from twin.calibration.holdout import Holdout, held_out
from twin.calibration.known import known
from twin.calibration.noise import estimated
from twin.calibration.result import Calibration
from twin.calibration.segments import RULE as SEGMENT_RULE
from twin.calibration.segments import Segment, segments
from twin.calibration.steady_rows import steady_rows
from twin.calibration.task import (
    Task,
    fitted_names,
    gears_of,
    held_back,
    peak_torque_nm,
    prior_of,
    result_of,
)
from twin.errors import BadInput
from twin.scenario.scenario import usual_plough
from twin.vehicle import files
from twin.vehicle.derive import RPM
from twin.vehicle.numerics import machine_facts

if TYPE_CHECKING:
    from twin.calibration.rollouts import Rollouts

Array = NDArray[np.float64]

ROLLOUT_NAMES = (
    "rear.free_rolling_radius_m", "front.free_rolling_radius_m", "transmission.efficiency",
    "engine.no_load_rpm", "engine.fuel_l_per_kwh", "soil.cone_index_kpa",
    "soil.k_phi_kn_per_m_n2", "soil.shear_modulus_m", "soil.friction",
    "soil.draft_scale", "soil.mobility_resistance", "log.set_rpm", "log.reference_torque_nm",
    "log.wheel_scale",
)  # fmt: skip
"""Parameters that such a log may determine."""
LOADS = (0.5, 0.8, 1.05, 1.3)
"""Shares of the draft that was found, at which slip is predicted over force; near a stall, which is
not far beyond, slip depends strongly on every parameter."""


def by_rollouts(task: Task) -> Calibration:
    """A short log at a fast rate: the machine itself, rolled out.

    Raises:
        BadInput: the log cannot be fitted.
    """
    from twin.calibration.rollouts import Condition, Drawn, Rollouts
    from twin.calibration.rollouts import Gear as Driven

    gears, ratio, turned = gears_of(task)
    rows = task.rows
    chosen = segments(rows)
    if task.hold_out_s is not None:
        time_s = (rows["epoch_ns"] - rows["epoch_ns"][0]) * 1e-9
        first, last = task.hold_out_s
        chosen = [replace(s, held_back=bool(np.any(
            (time_s[s.rows] >= first) & (time_s[s.rows] <= last)))) for s in chosen]  # fmt: skip
    kept, notes = [], []
    for segment in (s for s in chosen if not s.held_back):
        if (gear := found_gears.gear_of(float(np.nanmedian(ratio[segment.rows])), gears)) is None:
            notes.append("a segment whose gear is not found is left out")
        else:
            kept.append((segment, gear))
    if sum(s.working for s, _ in kept) < 2:
        raise BadInput("fewer than two segments of steady work in a gear are left to fit; drive "
                       "longer in one gear")  # fmt: skip
    driven = list(dict.fromkeys(g for _, g in kept))
    set_names = {g: "log.set_rpm" if i == 0 else f"log.set_rpm.{i + 1}"
                 for i, g in enumerate(driven)}  # fmt: skip
    proof = evidence(rows, [s for s, _ in kept])
    absent = _absent(task, proof.channels, turned)
    names = list(fitted_names(task, ROLLOUT_NAMES, absent))
    names += [n for n in set_names.values() if n not in names]
    if "log.wheel_scale" in names:
        names = [n for n in names if not n.endswith("radius_m")]
    exact = {g: _ratio(task, g) for g in driven}
    own: dict[str, tuple[float, float]] = {
        name: (1.01 * float(max(np.nanmax(rows["engine_radps"][s.rows]) for s, g in kept
                                if set_names[g] == name)) / RPM, known(name).spread)
        for name in set_names.values()
    }  # fmt: skip
    numbers = machine_facts(task.machine).numbers
    own["log.reference_torque_nm"] = peak_torque_nm(task.machine), 0.3
    own["log.wheel_scale"] = 1.0, 0.03
    part = files.implement(task.implement or files.usual_implement(task.machine)
                           or usual_plough(machine_facts(task.machine)))  # fmt: skip
    depth_m = float(np.mean([np.nanmean(rows["depth_m"][s.rows]) for s, _ in kept if s.working])
                    ) if "depth_m" in rows else float(np.mean(part.depths_m))  # fmt: skip
    block = task.log.setup.wheels
    rear_m = numbers["tyre_rear.free_rolling_radius_m"]
    front_m = numbers["tyre_front.free_rolling_radius_m"]
    if block is not None and turned:
        front_m, rear_m = block.radius_m["fl"], block.radius_m["rl"]
    drawn = Drawn(task.machine, part, task.soil, depth_m, "fl" in task.log.setup.driven,
                  depth_by_laser="depth_m" in rows)  # fmt: skip
    conditions = tuple(Condition(s.working, Driven(exact[g], set_names[g])) for s, g in kept)
    prior = prior_of(task, names, own)
    fixed = {n: own[n][0] for n in ("log.reference_torque_nm",) if n not in names}
    model = Rollouts(
        drawn,
        tuple(names),
        proof,
        conditions,
        (front_m, rear_m),
        np.exp(prior.mean),
        task.jobs,
        fixed,
    )
    result = fit(model, prior, seed=task.seed, starts=task.starts, told=task.told,
                 remember=task.memory)  # fmt: skip
    scale = result.values.get("log.wheel_scale", 1.0)
    if turned:
        scale = (
            machine_facts(machine_with(task.machine, result.values)).numbers[
                "tyre_rear.free_rolling_radius_m"
            ]
            / rear_m
        )
    holdout = _slip_ahead(task, model, result, chosen, scale)
    if holdout is None:
        notes.append("the part held back has no rows steady enough to be foretold one by one")
    return result_of(task, result, gears, proof.channels, proof.measured, proof.time_s,
                        holdout, SEGMENT_RULE,
                        notes)  # fmt: skip


def _absent(task: Task, channels: Sequence[str], turned: bool) -> list[str]:
    """Parameters that nothing in the log depends on."""
    needs = {"engine_load": "log.reference_torque_nm", "fuel_lph": "engine.fuel_l_per_kwh",
             "front_speed_mps": "front.free_rolling_radius_m"}  # fmt: skip
    out = [name for channel, name in needs.items() if channel not in channels]
    if "axle_torque_nm" not in channels and "engine_load" not in channels:
        out.append("transmission.efficiency")
    return [*out, "log.wheel_scale"] if turned else out


def _ratio(task: Task, gear: Gear) -> float:
    """The ratio of the machine's file where it has gears, else the log's."""
    known_ratios = machine_facts(task.machine).ratios
    if not known_ratios:
        return gear.ratio
    return min(known_ratios, key=lambda r: abs(math.log(r / gear.ratio)))


def _slip_ahead(
    task: Task, model: Rollouts, result: Fit, chosen: Sequence[Segment], scale: float
) -> Holdout | None:
    """Slip of the rows held back, predicted at their force by the machine's own slip over force.

    The force is engine torque x engine speed / wheel speed. None where the log has no engine load,
    or too few rows.
    """
    if "engine_load" not in model.evidence.channels:
        return None
    try:
        found = steady_rows(task.log, task.rows, task.rows["engine_load"], steady_mps2=math.inf)
    except BadInput:
        return None
    starts = [s.rows.start for s in chosen if s.held_back]
    held = held_back(task, found.time_s) if task.hold_out_s else (
        found.time_s >= min(starts, default=math.inf))  # fmt: skip
    fitted, back = found.chosen(~held & np.isfinite(found.ratio)), found.chosen(held)
    if len(fitted) < 6 or len(back) < 3:
        return None
    gear = next(c.gear for c in model.conditions if c.working)
    curves = model.under_load(np.exp(beside(result.u)), gear, LOADS)
    engine, load, wheel, ground = (
        curves[..., model.evidence.channels.index(c)]
        for c in ("engine_radps", "engine_load", "wheel_speed_mps", "speed_mps")
    )
    force, ratio = load * engine / wheel, ground / wheel
    pulled = np.isfinite(force * ratio).all(axis=0)  # by all: else the slopes would jump
    force, ratio = force[:, pulled], ratio[:, pulled]
    left = fitted.ratio - _read_off(force[0], ratio[0], fitted.force)
    if not np.isfinite(left).all():
        return None
    noise = estimated(left[:, None], fitted.time_s, np.array([0.001]))
    ratios = np.array([_read_off(f, r, back.force) for f, r in zip(force, ratio, strict=True)])
    return held_out(back, fitted, ratios, result.cov, float(noise.sd()[0, 0]), scale, task.seed)


def _read_off(force: Array, ratio: Array, at: Array) -> Array:
    """Ratio of speeds at a force, between the loads that were driven."""
    from scipy.interpolate import PchipInterpolator

    driven = np.isfinite(ratio)
    force, order = np.unique(force[driven], return_index=True)
    ratio = ratio[driven][order]
    if len(force) < 2:
        return np.full(len(at), np.nan)
    return np.asarray(PchipInterpolator(force, ratio)(np.clip(at, force[0], force[-1])))
