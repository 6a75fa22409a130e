"""Files of a result: run folder, report, recording; and its data frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from twin.errors import BadInput
from twin.io import run_folder
from twin.io.atomic import written_when_complete
from twin.io.plain import Plain
from twin.pipeline.result import Result
from twin.scenario import Scenario

if TYPE_CHECKING:
    import pandas

    from twin.machine.build import Machine

REPORT, RECORDING = run_folder.REPORT, run_folder.RECORDING


def save(result: Result, directory: Path | None, command: str) -> Path:
    """Write the run folder; see `Result.save`."""
    if directory is None and result.scenario is not None:
        directory = run_folder.default_directory(result.scenario.name, result.scenario.seed)
    target = directory or Path("runs") / (result.name or "log")
    return run_folder.write(result, result.scores, target, pictures=pictures(result, command))


def pictures(result: Result, command: str) -> dict[str, run_folder.Picture]:
    """File name in the run folder -> function that writes the file."""
    from twin.report import write

    return {REPORT: partial(write, command=command), RECORDING: partial(_picture, result)}


def report(result: Result, path: Path, command: str = "") -> None:
    """Write the report of a result."""
    from twin.report import write

    with written_when_complete(path) as partial_path:
        write(result, result.scores, partial_path, command=command)


def figures(result: Result, directory: Path) -> list[Path]:
    """Write the figures of a result for print."""
    from twin.report.page import drawings
    from twin.report.printed import write_print

    return [directory / name for name in write_print(drawings(result, result.scores), directory)]


def record(result: Result, path: Path) -> None:
    """Write the recording of a result."""
    with written_when_complete(path) as partial_path:
        _record(result, partial_path)


def _picture(result: Result, run: object, scores: object, path: Path) -> None:
    _record(result, path)


def _record(result: Result, path: Path) -> None:
    """A run with the machine it was driven with; signals and logs without one."""
    from twin import viz

    if isinstance(result.scenario, Scenario):
        from twin.terrain.maps import ground_maps

        machine, maps = _seen(result.scenario), ground_maps(result.scenario)
        ground = viz.Ground(world_from_ground=machine.world_from_ground, maps=maps)
        turned = _turned(result.scenario)
        viz.record(result, path, model=machine.model, turned=turned, ground=ground)
        return
    notes: Mapping[str, Plain] = {} if result.scenario is not None else {"notes": result.notes}
    viz.log(
        path,
        streams=result.streams,
        setup=result.setup,
        estimates=result.estimates,
        reference=result.truth,
        **notes,
    )


def _seen(scenario: Scenario) -> Machine:
    """The machine as it looks; the heights of its ground, which it does not need, are left out."""
    from twin.machine.build import assemble

    plane = replace(scenario.field, roughness_class="smooth", height_map=None)
    return assemble(replace(scenario, field=plane), looks=True)


def _turned(scenario: Scenario) -> Any:
    """The machine's model as it comes back, its plough turned over; None where it only goes."""
    if scenario.plough is None or scenario.course.passes == 1:
        return None
    from twin.simulation.passes import turned_over

    return _seen(turned_over(scenario)).model


def dataframe(result: Result) -> pandas.DataFrame:
    """Data frame of the estimates; see `Result.to_dataframe`.

    Raises:
        BadInput: pandas is not installed.
    """
    try:
        import pandas
    except ModuleNotFoundError:
        raise BadInput("to_dataframe needs pandas; pip install '.[dataframe]' would do") from None
    return pandas.DataFrame(run_folder.stack(result.estimates))
