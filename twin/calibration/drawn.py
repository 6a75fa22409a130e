"""Runs of machines that are drawn from a posterior: every figure with its band."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from twin.calibration.applied import machine_with, soil_with
from twin.calibration.written import read_posterior
from twin.errors import BadInput
from twin.scenario import Scenario


def posterior_of(machine: str) -> dict[str, Any]:
    """The posterior beside a machine's file. Raises BadInput where there is none."""
    if not machine.endswith(".toml"):
        raise BadInput(
            f"machine = {machine} has no posterior; the .calibrated.toml that twin calibrate "
            "writes would do"
        )
    return read_posterior(Path(machine))


def drawn(scenario: Scenario, count: int, seed: int = 0) -> Iterator[Scenario]:
    """The scenario with machines drawn from the posterior beside its machine's file.

    The soil is drawn, too, where its preset and its law are those that were calibrated.
    """
    posterior = posterior_of(scenario.machine)
    own = posterior.get("soil") or {}
    same = (own.get("preset"), own.get("law")) == (scenario.soil.preset, scenario.soil.law)
    base, generator = scenario.machine_file, np.random.default_rng(seed)
    draws = generator.multivariate_normal(posterior["mean"], posterior["cov"], count)
    for row in np.exp(draws).tolist():
        values = dict(zip(posterior["names"], row, strict=True))
        machine = machine_with(base, values)
        soil = soil_with(scenario.soil, values) if same else scenario.soil
        yield replace(scenario, machine=machine.name, machine_numbers=machine, soil=soil)


def bands(truths: list[Mapping[str, Any]]) -> dict[str, tuple[float, float, float]]:
    """Median, 2.5 and 97.5 % of every figure that all runs have."""
    names = [n for n in truths[0] if all(isinstance(t.get(n), float) for t in truths)]
    ends = {n: np.quantile([t[n] for t in truths], (0.5, 0.025, 0.975)) for n in names}
    return {n: (float(m), float(low), float(high)) for n, (m, low, high) in ends.items()}
