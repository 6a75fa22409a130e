"""What `import twin` offers of scenarios, runs and logs. Heavy modules are imported when called."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from twin.errors import BadInput

if TYPE_CHECKING:
    from twin.logs import Reader
    from twin.pipeline.estimating import Estimator
    from twin.pipeline.result import Measured, Result
    from twin.pipeline.run import Progress
    from twin.scenario import Scenario
    from twin.simulation.levers import Controlled

DEFAULT_ESTIMATORS = ("ratio", "four-state")


def load(name: str | Path, overrides: Mapping[str, object] | None = None) -> Scenario | Measured:
    """A scenario by name, with some of its fields replaced.

    `Measured` is a scenario without a machine: it gives signals and their truth itself.

    Args:
        name: a name that `twin list` shows, `module:Name` of your own, or the folder of a run.
        overrides: field by dotted path -> its value: `{"soil.friction": 0.8, "seed": 3}`.

    Raises:
        UnknownName: there is no such scenario, or no such field.
        BadInput, OutOfRange: a value is not one that the field takes.

    Example:
        >>> twin.load("plough-25cm", {"plough.depth_m": 0.2}).plough.depth_m
        0.2
    """
    from twin.pipeline.named import load as named
    from twin.scenario.fields import replaced

    scenario: Scenario | Measured = named("scenario", str(name))
    changed: Scenario | Measured = replaced(scenario, overrides or {})
    return changed


def run(
    scenario: Scenario | Measured | str | Path,
    estimators: Iterable[str | Estimator] | Mapping[str, Estimator] = DEFAULT_ESTIMATORS,
    *,
    seed: int | None = None,
    progress: Progress | None = None,
    frames: Path | None = None,
    controlled: Controlled | None = None,
) -> Result:
    """Drive a scenario, sense it, run the estimators, and score them against the truth.

    Args:
        scenario: a scenario, or what `twin.load` takes.
        estimators: names, your own objects with `init` and `run`, or both; or a mapping by name.
        seed: of everything random, in place of the scenario's.
        progress: called with the share of the course driven, 0 to 1, and the time driven [s].
        frames: folder where the camera's frames are saved as PNG.
        controlled: who sets throttle and hitch in work, by
            `twin.control.on_machine.controlled_by`.

    Raises:
        UnknownName: there is no such scenario, estimator, machine or implement.
        BadInput: a field is set that has no effect in this run, or two estimators have one name.
        OutOfRange: a number that the machine, the implement or the course does not allow.
        Diverged: a value of the simulation became NaN or too large.

    An estimator that fails stops nothing: its estimates are NaN, and `Result.failed` says why.

    Example:
        >>> twin.run("plough-25cm", ["ratio"]).scores["estimators"]["ratio"]  # doctest: +SKIP
    """
    import dataclasses

    from twin.pipeline.run import run as driven

    chosen: Any = load(scenario) if isinstance(scenario, str | Path) else scenario
    if seed is not None:
        chosen = dataclasses.replace(chosen, seed=seed)
    return driven(
        chosen,
        estimators=by_name(estimators),
        progress=progress,
        frames=frames,
        controlled=controlled,
    )


def estimate(
    log: str | Path | Iterable[str | Path],
    column_map: str | Path | None = None,
    estimators: Iterable[str | Estimator] | Mapping[str, Estimator] = DEFAULT_ESTIMATORS,
    reader: str | Reader | None = None,
    *,
    strict: bool = False,
    offset_s: Mapping[str, float] | None = None,
    hide_s: Iterable[float] = (),
    tuning: str | Path | None = None,
) -> Result:
    """Run the estimators on a recorded drive.

    Args:
        log: a run folder, a table, NMEA, CAN, UBX, a bag, or what `reader` reads; or several
            files of one drive.
        column_map: TOML that says which column is what, and in which unit.
        estimators: as `run` takes them.
        reader: what reads the log, or its name, as `twin.logs.READERS` has it or `module:Name`.
        strict: refuse a log with a single bad row.
        offset_s: file name -> how far its clock is ahead of the first file's [s]; what is not
            given is found from the speeds.
        hide_s: for how long GNSS is hidden at regular places while driving [s];
            `scores["hidden"]` has the errors of each estimator's predicted speed.
        tuning: file that `twin tune` wrote: other noises of some of the estimators.

    Raises:
        UnknownName: there is no such estimator or reader.
        BadInput: the log, the map or the tuning cannot be used; the message names the value.

    Example:
        >>> twin.estimate("field.csv", "field.toml").estimates["ratio"]["slip"]  # doctest: +SKIP
    """
    from twin import logs
    from twin.pipeline.log import estimate as estimated

    path = None if column_map is None else Path(column_map)
    by = logs.reader(reader) if isinstance(reader, str) else reader
    files = [Path(log)] if isinstance(log, str | Path) else [Path(each) for each in log]
    return estimated(
        files, path, estimators=by_name(estimators), reader=by, strict=strict,
        offset_s=offset_s, hide_s=tuple(hide_s),
        tuning=None if tuning is None else Path(tuning),
    )  # fmt: skip


def by_name(
    estimators: Iterable[str | Estimator] | Mapping[str, Estimator],
) -> dict[str, Estimator]:
    """Estimators by name: a mapping unchanged, names looked up, objects under their class' name.

    Raises:
        UnknownName: there is no such estimator.
        BadInput: there is none at all, or two have one name.
    """
    from twin.pipeline.named import checked
    from twin.pipeline.named import load as named

    if isinstance(estimators, Mapping):
        return {name: checked("estimator", name, each) for name, each in estimators.items()}
    found: dict[str, Estimator] = {}
    for each in [estimators] if isinstance(estimators, str) else estimators:
        name = each if isinstance(each, str) else _class_name(each)
        if name in found:
            raise BadInput(f"two estimators are called '{name}'; a mapping names them apart")
        found[name] = (
            named("estimator", each) if isinstance(each, str) else checked("estimator", name, each)
        )
    return found


def _class_name(thing: object) -> str:
    return thing.__name__ if isinstance(thing, type) else type(thing).__name__
