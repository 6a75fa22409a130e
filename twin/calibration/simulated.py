"""Calibrations of simulated logs whose truth is known: is the posterior what it says it is?

The truth of a log is drawn from the prior, the machine and soil of that truth are driven, and the
log is fitted from the prior alone. Then the place of the truth in the posterior, by logarithms,

    z = (log truth - mean) / sd            rank = Phi(z)

is standard normal, and the rank is uniform, over many logs (Talts et al. 2018, arXiv 1804.06788).
A log that cannot be driven or is refused is left out. The ranks stay uniform, because this depends
on the log alone.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twin.calibration.applied import believed, can_fit, machine_with, reads, soil_with
from twin.calibration.by_rollouts import ROLLOUT_NAMES
from twin.calibration.calibrate import calibrate
from twin.calibration.result import Calibration
from twin.calibration.task import bounds
from twin.calibration.verdicts import IDENTIFIED, NORMAL_95
from twin.errors import TwinError
from twin.io import run_folder
from twin.pipeline.run import run
from twin.scenario import Course, Drive, Field, Plough, Scenario, Soil
from twin.scenario.scenario import usual_plough
from twin.sensors import Bus, Sensors, Wheels
from twin.vehicle import Machine, files
from twin.vehicle.numerics import machine_facts

Array = NDArray[np.float64]

MACHINES = ("jd_4250", "jd_4450", "jd_5055e", "jd_8245r", "mf_275", "nh_t7165s", "taishan_1404a",
            "tym_tx58")  # fmt: skip
"""Those of the catalogue that plough."""
DRAWN = tuple(n for n in ROLLOUT_NAMES if not n.startswith("log."))
EMPTY_M, WORK_M = 80.0, 200.0
"""Driven with the plough up, and ploughed: three minutes."""
DEPTHS_M = (0.15, 0.25)


@dataclass(frozen=True)
class Trial:
    """The posterior of one log, beside its truth."""

    seed: int
    machine: str
    refused: str
    """Why there is no posterior; empty where there is."""
    truth: dict[str, float]
    error: dict[str, float]
    """Logarithm of found over true."""
    sd: dict[str, float]
    """Of the posterior's logarithm."""
    verdict: dict[str, str]
    notes: tuple[str, ...] = ()
    """What the calibration noted."""
    misfit: float = math.nan
    holdout: dict[str, float | None] = field(default_factory=dict)
    """Scores of the part held back."""


def trial(seed: int, law: str = "brixius", fitted_law: str = "brixius") -> Trial:
    """Draw a truth under a soil law, drive it, fit the log under the same law or another."""
    generator = np.random.default_rng(seed)
    name = str(generator.choice(MACHINES))
    machine, soil = files.machine(name), Soil(preset="tilled", law=law)
    truth = drawn_truth(machine, soil, generator)
    none: dict[str, float] = {}
    try:
        scenario = driven(machine, soil, truth, generator, seed)
        with tempfile.TemporaryDirectory() as folder:
            found = _fitted(scenario, name, fitted_law, Path(folder))
    except TwinError as error:
        return Trial(seed, name, str(error), truth, none, none, {})
    names = [n for n in found.posterior.names if n in truth]
    sds = dict(zip(found.posterior.names, np.sqrt(np.diag(found.posterior.cov)), strict=True))
    values = {p.name: p for p in found.parameters}
    return Trial(
        seed, name, "", truth,
        {n: math.log(values[n].value / truth[n]) for n in names},
        {n: float(sds[n]) for n in names}, {n: values[n].verdict for n in names},
        found.notes, found.fit.misfit, found.holdout.scores if found.holdout else {},
    )  # fmt: skip


def drawn_truth(machine: Machine, soil: Soil, generator: np.random.Generator) -> dict[str, float]:
    """Values drawn from the prior of a machine and a soil, within the bounds of a fit."""
    names = [n for n in DRAWN if can_fit(machine, n) and reads(soil, n)]
    mean, sd = np.array([(math.log(v), s) for v, s, _ in
                         (believed(machine, soil, n) for n in names)]).T  # fmt: skip
    low, high = bounds(machine, names)
    while True:
        u = mean + sd * generator.standard_normal(len(names))
        if np.all((u > low) & (u < high)):
            return dict(zip(names, np.exp(u).tolist(), strict=True))


def driven(
    machine: Machine, soil: Soil, truth: dict[str, float], generator: np.random.Generator, seed: int
) -> Scenario:
    """The drive of a truth: empty, then ploughing, on rough ground that varies.

    What the driver chooses and the sensors do depends on the prior, never on the truth.
    """
    facts = machine_facts(machine)
    part = files.implement(files.usual_implement(machine) or usual_plough(facts))
    depth_m = float(np.clip(generator.uniform(*DEPTHS_M), *part.depths_m))
    true_machine = machine_with(machine, truth)
    reference_nm = (
        1.02 * facts.numbers["engine.rated_torque_nm"] * facts.numbers["engine.torque_rise"]
    )
    return Scenario(
        name="simulated", machine=true_machine.name, machine_numbers=true_machine,
        implement=part.name, implement_numbers=part, plough=Plough(depth_m=depth_m),
        soil=soil_with(soil, truth), field=Field(roughness_class="C"),
        drive=Drive(gear_ratio=facts.usual_ratio, engine_set_rpm=facts.usual_rpm),
        course=Course(approach_m=EMPTY_M, length_m=WORK_M),
        sensors=Sensors(camera=None, wheels=Wheels(radius_error_sd=0.0),
                        machine=Bus(reference_torque_nm=reference_nm)),
        seed=seed,
    )  # fmt: skip


def _fitted(scenario: Scenario, machine: str, law: str, folder: Path) -> Calibration:
    result = run(scenario, estimators={})
    log = run_folder.write(result, {}, folder / "log")
    return calibrate(log, machine=machine, soil=Soil(preset="tilled", law=law), starts=1)


@dataclass(frozen=True)
class Told:
    """Coverage and errors of one parameter over the trials."""

    name: str
    logs: int
    covered: float
    """Share of the truths within their 95 % interval."""
    covered_low: float
    """Least such share that a right posterior gives, in 95 % of such sets of logs."""
    covered_high: float
    uniform_p: float
    """Chance of ranks that are so far from uniform, Kolmogorov and Smirnov's; of a right one."""
    bias_sd: float
    """Mean of (found - true) / sd."""
    error: float
    """Median of |found / true - 1|."""
    identified: float
    """Share of the logs in which it was called identified."""
    identified_error: float
    """Median error in these; NaN where there are none."""


def told(trials: Sequence[Trial]) -> list[Told]:
    """Coverage, ranks and errors of every parameter over the trials that were not refused."""
    from scipy.stats import binom, kstest, norm

    fitted = [t for t in trials if not t.refused]
    out = []
    for name in (n for n in DRAWN if any(n in t.error for t in fitted)):
        mine = [t for t in fitted if name in t.error]
        error = np.array([t.error[name] for t in mine])
        z = error / np.array([t.sd[name] for t in mine])
        sure = np.array([t.verdict[name] == IDENTIFIED for t in mine])
        low, high = (float(binom.ppf(q, len(mine), 0.95)) / len(mine) for q in (0.025, 0.975))
        size = np.abs(np.expm1(error))
        out.append(Told(
            name, len(mine), float(np.mean(np.abs(z) <= NORMAL_95)), low, high,
            float(kstest(norm.cdf(-z), "uniform").pvalue), float(z.mean()),
            float(np.median(size)), float(sure.mean()),
            float(np.median(size[sure])) if sure.any() else math.nan,
        ))  # fmt: skip
    return out


def table(trials: Sequence[Trial]) -> str:
    """What the trials say, as text."""
    refused = sum(bool(t.refused) for t in trials)
    lines = [f"{len(trials)} logs, {refused} not driven or refused",
             f"{'parameter':28s}{'logs':>5s}{'covered':>9s}{'of':>14s}{'uniform p':>11s}"
             f"{'bias/sd':>9s}{'error':>8s}{'identified':>12s}{'error then':>12s}"]  # fmt: skip
    for t in told(trials):
        lines.append(
            f"{t.name:28s}{t.logs:5d}{t.covered:9.3f}{t.covered_low:8.3f}-{t.covered_high:.3f}"
            f"{t.uniform_p:11.3f}{t.bias_sd:+9.2f}{t.error:8.2%}{t.identified:12.2f}"
            f"{t.identified_error:12.2%}"
        )  # fmt: skip
    return "\n".join(lines)
