"""The scores of a run on the terminal: a table, and above it what was driven and how it ended."""

from __future__ import annotations

from collections.abc import Mapping

from twin.commands.tables import Column, print_table
from twin.commands.terminal import say
from twin.io.plain import Plain
from twin.scores.table import (
    HIDDEN_PHASE_RANKS,
    HIDDEN_RANKS,
    PHASE_RANKS,
    RANKS,
    end_lines,
    hidden_notes,
    hidden_phase_rows,
    hidden_rows,
    left_out_lines,
    phase_rows,
    score_rows,
    zero_line,
)


def print_scores(scores: Mapping[str, Plain]) -> None:
    """Print how the run ended if not as planned, what was driven, and the scores."""
    for line in end_lines(scores):
        say(line, style="bold red")
    rows = score_rows(scores)
    if not rows:
        return
    say(_title(scores), style="italic")
    _print(rows, RANKS)
    by_phase = phase_rows(scores)
    if by_phase:
        say(f"while driving, by phase: {scores['phase_rule']}", style="italic")
        _print(by_phase, PHASE_RANKS)
    for line in left_out_lines(scores):
        say(f"note: {line}", style="dim", indent=2)


def print_hidden(scores: Mapping[str, Plain]) -> None:
    """Print how well each estimator predicted the receiver's speed, where GNSS was hidden."""
    rows = hidden_rows(scores)
    if rows:
        say("GNSS hidden at regular places while driving, scored at their ends", style="italic")
        _print(rows, HIDDEN_RANKS)
        by_phase = hidden_phase_rows(scores)
        if by_phase:
            say("the same by what was driven there, as the log's activities say", style="italic")
            _print(by_phase, HIDDEN_PHASE_RANKS)
        for line in hidden_notes(scores):
            say(f"note: {line}", style="dim", indent=2)


def _print(rows: list[list[str]], ranks: Mapping[str, int]) -> None:
    print_table(
        [
            Column(heading=heading, cells=cells, rank=ranks[heading], text=i == 0)
            for i, (heading, cells) in enumerate(zip(ranks, zip(*rows, strict=True), strict=True))
        ]
    )


def _title(scores: Mapping[str, Plain]) -> str:
    truth, window = scores.get("truth") or {}, scores.get("window_s") or (0.0, 0.0)
    said = [str(scores.get("scenario"))]
    if scores.get("seed") is not None:
        said.append(f"seed {scores['seed']}")
    said.append(f"scored {window[0]:.1f} to {window[1]:.1f} s")
    for key, form in (
        ("mean_speed_kmh", "{:.2f} km/h"),
        ("slip_mean", "slip {:.2%}"),
        ("draft_mean_kn", "draft {:.1f} kN"),
    ):
        if truth.get(key) is not None:
            said.append(form.format(truth[key]))
    if (zero := zero_line(scores)) is not None:
        said.append(zero)
    return ", ".join(said)
