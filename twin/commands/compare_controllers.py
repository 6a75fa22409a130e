"""`twin compare-controllers`: compare controllers on the same held-out grounds."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from twin.commands.output import Output, check_files, deliver
from twin.commands.parse import parse
from twin.commands.tables import Column, print_table
from twin.commands.terminal import progress, say
from twin.errors import UnknownName, check_range
from twin.io.plain import Plain

OBSERVATIONS = ("estimate", "truth")


@dataclass(frozen=True, kw_only=True)
class CompareControllers(Output):
    """Compare slip controllers: each drives over the same held-out grounds."""

    env: str = "Plough-v0"
    """Environment: Plough-v1, WheelSlip-v1, Plough-v0 or WheelSlip-v0."""
    episodes: int = 50
    """How many held-out grounds each controller drives over."""
    controllers: str = ""
    """Controllers, separated by commas: baselines by name, module:Name of your own, and policies
    saved by stable-baselines3, FILE.zip. Without it, all baselines. Loading a policy can run any
    code in its file."""
    duration_s: float = 20.0
    """Length of an episode [s]; what is scored begins 5 s after its start."""
    observation: str = "estimate"
    """What the controllers observe: estimate or truth."""
    report: Path | None = None
    """File for an HTML page with means and intervals, as a table and as figures."""


def main(args: Sequence[str]) -> int:
    """Compare, print, and write the rows where asked."""
    options = parse(CompareControllers, args, prog="twin compare-controllers")
    check_range("episodes", options.episodes, 2, 10000)
    check_range("duration_s", options.duration_s, 6.0, 600.0)
    if options.observation not in OBSERVATIONS:
        raise UnknownName("observation", options.observation, OBSERVATIONS)
    check_files(json=options.json, report=options.report)
    from twin.control import chosen, compare, front, trials

    if options.env not in trials.ENVIRONMENTS:
        raise UnknownName("environment", options.env, trials.ENVIRONMENTS)
    setup = trials.setup(options.env, options.observation)
    wanted = options.controllers or ",".join(trials.ENVIRONMENTS[options.env][1])
    controllers = chosen.by_name(wanted, setup)
    controllers = compare.with_oracle(
        controllers, options.env, options.episodes, options.duration_s
    )
    with progress("comparing", shown=options.talks) as report:
        done = compare.compare(
            controllers,
            options.episodes,
            options.duration_s,
            options.observation,
            report,
            options.env,
        )
    found = compare.rows(done.measured, against=_against(done.measured))
    shares = [*compare.regrets(done), *front.front_rows(options.env, done.measured)]
    if options.talks and done.measured:
        print_comparison(found, list(done.measured), options.episodes)
        print_shares(shares)
    found = [*found, *shares]
    for why in done.failed.values():
        print(f"twin: {why}", file=sys.stderr)
    deliver(found, options.json)
    if options.report is not None:
        _report(found, options)
    return 1 if done.failed else 0


def _against(names: Collection[str]) -> list[str]:
    """Whom the others are compared with, ground by ground: the PI, or else the first."""
    return ["pi"] if "pi" in names else list(names)[:1]


def _report(found: Sequence[Mapping[str, Plain]], options: CompareControllers) -> None:
    from twin.report import rows

    about = (
        f"{options.env}, {options.episodes} held-out grounds of {options.duration_s:g} s, the same "
        f"for all; controllers observe the {options.observation}. Means and their 95 % intervals."
    )
    chosen = f" --controllers {shlex.quote(options.controllers)}" if options.controllers else ""
    command = (
        f"twin compare-controllers --env {options.env} --episodes {options.episodes} --duration-s "
        f"{options.duration_s:g} --observation {options.observation}{chosen}"
    )
    assert options.report is not None
    rows.write_intervals(options.report, "Slip controllers", about, found, command)


def print_comparison(
    found: Sequence[Mapping[str, Plain]], names: Sequence[str], count: int
) -> None:
    """A line for each controller, a column for each quantity, mean and half its interval.

    Of the paired differences the reward's alone; the rows hold all.
    """
    named = dict.fromkeys(row["quantity"] for row in found)
    quantities = [n for n in named if "paired" not in n or n.startswith("reward")]
    cells = {(row["case"], row["quantity"]): row for row in found}
    columns = [Column(heading="controller", cells=names, text=True)]
    for rank, quantity in enumerate(quantities):
        unit = next(row["unit"] for row in found if row["quantity"] == quantity)
        name = quantity.replace("_", " ")
        columns.append(
            Column(
                heading=name if unit == "1" else f"{name} [{unit}]",
                cells=[_cell(cells.get((controller, quantity))) for controller in names],
                rank=rank,
            )
        )
    say(
        f"{count} held-out grounds, the same for all; mean ± half the 95 % interval",
        style="italic",
    )
    print_table(columns)


def print_shares(found: Sequence[Mapping[str, Plain]]) -> None:
    """The oracle's headroom over the PI, each controller's share of it by tier, and the front."""
    from twin.control import front

    on = [row["case"] for row in found if row["quantity"] == front.ON_FRONT and row["ours"]]
    for row in found:
        if "high" in row:
            half = 0.5 * (row["high"] - row["low"])
            say(f"{row['case']}: {row['quantity']} = {row['ours']:.3f} ± {half:.3f}")
    if on:
        say(f"{front.ON_FRONT}: {', '.join(on)}")


def _cell(row: Mapping[str, Plain] | None) -> str:
    return "" if row is None else f"{row['ours']:.3f} ± {0.5 * (row['high'] - row['low']):.3f}"
