"""The recording of a simulated run, with the machine it was driven with."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from twin.runfolder import RunLike


def record(run: RunLike, scores: Mapping[str, Any], path: Path) -> None:
    """Write run.rrd. The scores are not drawn."""
    from twin import viz

    if hasattr(run.scenario, "machine"):
        machine = _machine(run.scenario)
        ground = viz.Ground(world_from_ground=machine.world_from_ground, maps=machine.maps)
        viz.record(run, path, model=machine.model, turned=_turned(run.scenario), ground=ground)
    else:  # signals without a machine are drawn as a log is
        viz.log(
            path,
            streams=run.streams,
            setup=run.setup,
            estimates=run.estimates,
            reference=run.truth,
        )


def _machine(scenario: Any) -> Any:
    from twin.machine.build import build

    return build(scenario, looks=True, settle=False)


def _turned(scenario: Any) -> Any:
    """The machine as it comes back, its plough turned over; None where it only goes there."""
    if scenario.plough is None or scenario.course.passes == 1:
        return None
    from twin.machine.passes import turned_over

    return _machine(turned_over(scenario)).model
