"""The recording of a simulated run, with the machine it was driven with."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from twin.io.run_folder import RunLike


def record(run: RunLike, scores: Mapping[str, Any], path: Path) -> None:
    """Write run.rrd. The scores are not drawn."""
    from twin import viz

    if hasattr(run.scenario, "machine"):
        machine = _machine(run.scenario)
        ground = viz.Ground(world_from_ground=machine.world_from_ground, maps=machine.maps)
        viz.record(run, path, model=machine.model, ground=ground)
    else:  # signals without a machine are drawn as a log is
        viz.log(
            path,
            streams=run.streams,
            setup=run.setup,
            estimates=run.estimates,
            reference=run.truth,
        )


def _machine(scenario: Any) -> Any:
    from twin.simulation.build import build

    return build(scenario, looks=True, settle=False)
