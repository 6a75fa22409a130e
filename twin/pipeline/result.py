"""What a run, or the estimates of a log, gave: a frozen record that saves and shows itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from twin.io.plain import Plain
from twin.streams import Frames, Setup, Streams, Table
from twin.trajectory.end import End, Outcome

if TYPE_CHECKING:
    import pandas

    from twin.scenario import Scenario


class Measured(Protocol):
    """A scenario of signals without a machine: it gives measurements and truth itself."""

    @property
    def name(self) -> str:
        """What it is called."""

    @property
    def seed(self) -> int:
        """The seed of everything random in it."""

    def measure(self) -> tuple[Setup, Streams, Table]:
        """The estimators' set-up, the streams, and the truth."""


@dataclass(frozen=True)
class Result:
    """Result of `twin.run` and `twin.estimate`.

    A table is a dict of NumPy arrays of equal length; `epoch_ns` is its time [ns].

    Example:
        >>> result = twin.run("plough-25cm", estimators=["ratio"])  # doctest: +SKIP
        >>> result.scores["estimators"]["ratio"]["slip"]["rmse"]  # doctest: +SKIP
    """

    scenario: Scenario | Measured | None
    """The scenario that was driven, with the numbers of its presets filled in; None for a log."""
    setup: Setup
    """The estimators' set-up: nominal values."""
    streams: Streams
    """The samples of the sensors, by sensor."""
    truth: Table
    """The truth of a simulation, the reference of a log; empty where nothing is known."""
    estimates: Mapping[str, Table]
    """Estimator -> its table."""
    wall_s: float = 0.0
    """Time it took [s]."""
    end: End | None = None
    """How, when and where the run ended; None for a log, and for a scenario without a machine."""
    frames: Frames | None = None
    """Some of the camera's frames by number, drawn when asked for."""
    notes: tuple[str, ...] = ()
    """Warnings and assumptions, as sentences."""
    failed: Mapping[str, str] = field(default_factory=dict)
    """Estimator that failed -> why: its table holds NaN."""
    name: str = ""
    """Name of the log; empty for a run, whose name is `scenario.name`."""
    found: Mapping[str, Plain] = field(default_factory=dict)
    """For a log, its spread of slip, and the slip in the rows that the map marks as steady work."""

    @property
    def ended(self) -> str:
        """How the run ended, in words."""
        return str(self.end or Outcome.DRIVEN)

    @cached_property
    def scores(self) -> dict[str, Plain]:
        """Every estimator against the truth, and the bound: what goes into scores.json."""
        from twin.pipeline.scored import log_scores, run_scores

        return log_scores(self) if self.scenario is None else run_scores(self)

    def save(self, directory: Path | str | None = None, *, command: str = "") -> Path:
        """Write the run folder, with report and recording; it appears only when complete.

        Args:
            directory: where; runs/<name>-seed<N> by default. An earlier run folder is replaced.
            command: the command that the report says, if there was one.

        Raises:
            BadInput: the name is taken by something else, or the folder cannot be written.
        """
        from twin.pipeline.saved import save

        return save(self, None if directory is None else Path(directory), command)

    def report(self, path: Path | str, *, command: str = "") -> None:
        """Write the report, one HTML file. Raises BadInput where it cannot be written."""
        from twin.pipeline.saved import report

        report(self, Path(path), command)

    def figures(self, directory: Path | str) -> list[Path]:
        """Write every figure of the report as SVG and PDF, 85 mm wide; the files.

        Args:
            directory: where; files of other names in it stay.

        Raises:
            BadInput: the folder cannot be written.
        """
        from twin.pipeline.saved import figures

        return figures(self, Path(directory))

    def record(self, path: Path | str) -> None:
        """Write the recording for the rerun viewer. Raises BadInput where it cannot be written."""
        from twin.pipeline.saved import record

        record(self, Path(path))

    def csv(self, path: Path | str) -> str:
        """Write the estimates of all estimators as one CSV file; how its time is written.

        Every column has its unit in its name; slip is in percent.

        Raises:
            BadInput: the file cannot be written.
        """
        from twin.io.estimates_csv import write

        return write(self.estimates, Path(path))

    def to_dataframe(self) -> pandas.DataFrame:
        """The estimates of all estimators below each other, column `estimator` first.

        Raises:
            BadInput: pandas is not installed.
        """
        from twin.pipeline.saved import dataframe

        return dataframe(self)
