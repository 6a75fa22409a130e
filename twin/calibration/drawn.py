"""Runs of machines that are drawn from a posterior: every figure with its band."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from twin.calibration.applied import machine_with, soil_with
from twin.calibration.posterior import Posterior, beside, read
from twin.errors import BadInput, TwinError
from twin.scenario import Scenario

SOIL_ENDING = ".soil.toml"


def posterior_of(machine: str) -> Posterior:
    """The posterior beside a machine's file. Raises BadInput where there is none."""
    if not machine.endswith(".toml"):
        raise BadInput(
            f"machine = {machine} has no posterior; the .calibrated.toml that twin calibrate "
            "writes would do"
        )
    return read(beside(Path(machine)))


def drawn(scenario: Scenario, count: int, seed: int = 0) -> Iterator[Scenario]:
    """The scenario with machines drawn from the posterior beside its machine's file.

    The soil is drawn, too, where it is the file that was written with the machine. A draw that a
    machine's file could not hold is left out, so that there may be fewer.
    """
    posterior = posterior_of(scenario.machine)
    own_soil = str(Path(scenario.machine).with_suffix(SOIL_ENDING))
    with_soil = Path(scenario.soil.preset) == Path(own_soil)
    base = scenario.machine_file
    for values in posterior.draw(count, seed):
        try:
            machine = machine_with(base, values)
            soil = soil_with(scenario.soil, values) if with_soil else scenario.soil
            made = replace(scenario, machine=machine.name, machine_numbers=machine, soil=soil)
        except TwinError:
            continue
        yield made


def bands(truths: list[Mapping[str, float | None]]) -> dict[str, tuple[float, float, float]]:
    """Median, 2.5 and 97.5 % of every figure that all runs have."""
    names = [n for n in truths[0] if all(isinstance(t.get(n), float) for t in truths)]
    ends = {n: np.quantile([t[n] for t in truths], (0.5, 0.025, 0.975)) for n in names}
    return {n: (float(m), float(low), float(high)) for n, (m, low, high) in ends.items()}
