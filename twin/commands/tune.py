"""`twin tune LOG`: find an estimator's noises from a recorded drive."""

from __future__ import annotations

import json
import math
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from twin.commands.output import check_files
from twin.commands.parse import parse
from twin.commands.run import load_estimators
from twin.commands.tables import Column, print_table
from twin.commands.terminal import counting, say
from twin.errors import BadInput

if TYPE_CHECKING:
    from twin.tuning.held_out import Gain
    from twin.tuning.result import Tuning, Value


LEFT = {
    "not confirmed": "as the held-out part does not confirm another value",
    "no difference told": "as the log shows no other value",
    "flat": "as the log does not depend on them",
}
"""Why a noise is not changed -> the words for it."""


@dataclass(frozen=True, kw_only=True)
class Tune:
    """Find the noises under which a recorded drive is likeliest, and what they gain."""

    log: Annotated[tuple[Path, ...], tyro.conf.Positional]
    """The recorded drive, or the files it is in; the clock of the first counts."""
    map: Path | None = None
    """TOML file that gives the meaning and the unit of each column."""
    reader: str | None = None
    """What reads it: bag, can, csv, mat, nmea, parquet, run-folder, ubx or module:Name."""
    strict: bool = False
    """Refuse a log with a single bad row."""
    estimators: str = "slip-ekf"
    """Estimators, separated by commas: names, or module:Name of your own."""
    learn_share: float = 0.5
    """Part of the log's time that is learnt from; the rest is held out."""
    out: Path | None = None
    """File for the noises; by default <name of the log>-tuning.toml."""
    seed: int = 0
    """Of the points where searches begin."""
    quiet: bool = False
    """Print errors only."""
    json: bool = False
    """Print what was found as JSON instead of tables."""


def main(args: Sequence[str]) -> int:
    """Read a log, find the noises, write the file, print what they gain."""
    options = parse(Tune, args, prog="twin tune")
    if not options.log:
        raise BadInput("no log is named; twin tune LOG [LOG...]")
    absent = [log for log in options.log if options.reader is None and not log.exists()]
    if absent:  # before anything heavy is loaded
        raise BadInput(f"{absent[0]}: there is no such file")
    out = options.out or Path(f"{options.log[0].resolve().stem}-tuning.toml")
    if out.exists() and not out.read_bytes().startswith(b"# twin tune "):
        raise BadInput(f"{out} exists and twin tune did not write it; name another with --out")
    check_files(out=out)
    estimators = load_estimators(options.estimators)
    from twin.tuning.result import write
    from twin.tuning.tune import tune

    with counting("tuning", "estimators", shown=not (options.quiet or options.json)) as told:
        found = tune(
            options.log, options.map, estimators, options.reader, strict=options.strict,
            learn_share=options.learn_share, seed=options.seed, told=told,
        )  # fmt: skip
    write(found, out, f"twin tune {shlex.join(args)}")
    if options.json:
        print(json.dumps(_plain(found), indent=2))
    elif not options.quiet:
        for tuning in found.values():
            _print(tuning)
        say(f"{out}: twin estimate {shlex.join(map(str, options.log))} --tuning {out}")
    return 0


def _print(tuning: Tuning) -> None:
    say(
        f"{tuning.estimator}: learnt from {tuning.learnt_s:.0f} s, "
        f"held out {tuning.held_out_s:.0f} s"
    )
    _print_values([value for value in tuning.values if value.why.startswith("tuned")])
    for why, words in LEFT.items():
        left = [value.name for value in tuning.values if value.why == why]
        if left:
            say(f"unchanged, {words}: {', '.join(left)}", indent=2)
    print_table([
        Column(heading="on the held-out part", cells=[g.quantity for g in tuning.gains], text=True),
        Column(heading="before", cells=[f"{g.before:.4g}" for g in tuning.gains]),
        Column(heading="after", cells=[f"{g.after:.4g}" for g in tuning.gains]),
        Column(heading="unit", cells=[g.unit for g in tuning.gains], text=True, rank=2),
        Column(heading="change", cells=[_change(g, g.change) for g in tuning.gains]),
        Column(heading="95 %", cells=[_interval(g) for g in tuning.gains], rank=1),
        Column(heading="", cells=[g.verdict for g in tuning.gains], text=True),
    ])  # fmt: skip
    if tuning.kept == "nothing":
        say(f"{tuning.estimator}: nothing is changed")


def _print_values(values: Sequence[Value]) -> None:
    if not values:
        return
    print_table([
        Column(heading="noise", cells=[_name(v) for v in values], text=True),
        Column(heading="before", cells=[f"{v.before:.3g}" for v in values]),
        Column(heading="value", cells=[f"{v.value:.3g}" for v in values]),
        Column(heading="95 %", cells=[_range(v.low, v.high) for v in values], rank=1),
        Column(heading="gain, ln density", cells=[f"{v.gain:+.0f}" for v in values], rank=2),
        Column(heading="grade before", cells=[v.grade for v in values], text=True, rank=3),
        Column(heading="", cells=["at its bound" if "bound" in v.why else "" for v in values],
               text=True),
    ])  # fmt: skip


def _name(value: Value) -> str:
    return f"{value.name} sd, factor" if value.is_factor else value.name


def _range(low: float, high: float) -> str:
    return "-" if math.isnan(low) else f"{low:.3g} to {high:.3g}"


def _change(gain: Gain, by: float) -> str:
    if math.isnan(by):
        return "-"
    return f"{by:+.3g}" if gain.more_is_better else f"{100 * by:+.1f} %"


def _interval(gain: Gain) -> str:
    return (
        "-" if math.isnan(gain.low) else f"{_change(gain, gain.low)} to {_change(gain, gain.high)}"
    )


def _plain(found: Mapping[str, Tuning]) -> object:
    """What was found as JSON: no NaN."""
    from twin.io.plain import to_plain

    told = {
        name: to_plain(tuning)
        | {
            "verdict": tuning.verdict,
            "gains": [to_plain(g) | {"verdict": g.verdict} for g in tuning.gains],
        }
        for name, tuning in found.items()
    }
    return {"schema": 1, "estimators": told}
