"""Result of a run, or of estimators on a log: a frozen record that writes its files."""

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
    """Interface of a scenario that gives measurements and truth without a simulated machine."""

    @property
    def name(self) -> str:
        """Name of the scenario."""

    @property
    def seed(self) -> int:
        """Seed of all random numbers of the scenario."""

    def measure(self) -> tuple[Setup, Streams, Table]:
        """Set-up of the sensors, streams of measurements, and truth."""


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
        """End of the run, in words."""
        return str(self.end or Outcome.DRIVEN)

    @cached_property
    def scores(self) -> dict[str, Plain]:
        """Scores of every estimator against the truth, and the bound, as in scores.json."""
        from twin.pipeline.scored import log_scores, run_scores

        return log_scores(self) if self.scenario is None else run_scores(self)

    def save(self, directory: Path | str | None = None, *, command: str = "") -> Path:
        """Write the run folder, with report and recording; the folder appears when complete.

        Args:
            directory: target; default runs/<name>-seed<N>. An earlier run folder is replaced.
            command: command line that the report shows; empty for none.

        Raises:
            BadInput: the target exists and is no run folder, or the folder cannot be written.
        """
        from twin.pipeline.saved import save

        return save(self, None if directory is None else Path(directory), command)

    def report(self, path: Path | str, *, command: str = "") -> None:
        """Write the report, one HTML file. Raises BadInput if the file cannot be written."""
        from twin.pipeline.saved import report

        report(self, Path(path), command)

    def figures(self, directory: Path | str) -> list[Path]:
        """Write every figure of the report as SVG and PDF, 85 mm wide; return the files.

        Args:
            directory: target folder; its files with other names stay.

        Raises:
            BadInput: the folder cannot be written.
        """
        from twin.pipeline.saved import figures

        return figures(self, Path(directory))

    def record(self, path: Path | str) -> None:
        """Write the recording for the rerun viewer. Raises BadInput if writing fails."""
        from twin.pipeline.saved import record

        record(self, Path(path))

    def csv(self, path: Path | str) -> str:
        """Write the estimates of all estimators as one CSV file; return the format of its time.

        Every column has its unit in its name; slip is in percent.

        Raises:
            BadInput: the file cannot be written.
        """
        from twin.io.estimates_csv import write

        return write(self.estimates, Path(path))

    def to_dataframe(self) -> pandas.DataFrame:
        """All estimates, one row for each estimator and epoch; first column `estimator`.

        Raises:
            BadInput: pandas is not installed.
        """
        from twin.pipeline.saved import dataframe

        return dataframe(self)
