"""Guesses as a table to read and as a map to edit."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping

import numpy as np

from twin.logs.mapping.guess import Guesses
from twin.logs.mapping.guessed import Guess, Seen

UNSURE = "# ? "


def rows(by_file: Mapping[str, Guesses]) -> list[tuple[str, str, str, str, str]]:
    """Signal, rate, range, share of holes and what it is taken for.

    A signal that never changes and is taken for nothing is not listed.
    """
    table = []
    for name, told in by_file.items():
        meant = {g.signal: g for g in told.quantities}
        for seen in told.seen:
            guess = meant.get(seen.name)
            if guess is None and _constant(seen):
                continue
            what = f"{guess.section}.{guess.key} [{guess.unit}]" if guess else ""
            mark = "" if guess is None or guess.sure else " ?"
            label = seen.name if len(by_file) == 1 else f"{name}:{seen.name}"
            table.append((label, _rate(seen), _range(seen), f"{seen.holes:.0%}", what + mark))
    return table


def map_of(by_file: Mapping[str, Guesses], dbc: tuple[str, ...] = ()) -> str:
    """A map as TOML; a line that is not sure says so."""
    several = len(by_file) > 1
    lines = ["# A first map. Lines with '# ?' are guesses that nothing confirms.", "", "[log]"]
    times = [t.time for t in by_file.values() if t.time is not None]
    if times:
        lines.append(_line("time", times[0], times[0].signal))
    if dbc:
        lines.append(f"dbc = {json.dumps(list(dbc))}")
    sections: dict[str, list[str]] = {}
    seen: set[str] = set()
    for name, told in by_file.items():
        for guess in told.quantities:
            if f"{guess.section}.{guess.key}" in seen:
                continue
            seen.add(f"{guess.section}.{guess.key}")
            column = f"{name}:{guess.signal}" if several else guess.signal
            sections.setdefault(guess.section, []).append(_line(guess.key, guess, column))
        if told.labels:
            sections.setdefault("rows", []).extend(
                f"{_bare(label)} = {{column = {json.dumps(label, ensure_ascii=False)}}}"
                for label in told.labels
            )
    for section, written in sections.items():
        lines += ["", f"[{section}]", *written]
    mounts = [t.heading_mount_rad for t in by_file.values() if t.heading_mount_rad is not None]
    return "\n".join([*lines, *_SETUP, *(_mount_lines(mounts[0]) if mounts else ()), ""])


_SETUP = (
    "",
    "[setup]",
    'machine = "unnamed tractor"',
    "# wheelbase_m = 2.8",
    "# [setup.wheels]",
    "# radius_m = {fl = 0.6, fr = 0.6, rl = 0.8, rr = 0.8}",
    "# counts_per_turn = 100  # of a wheel; ticks give no speed without it",
)


def _mount_lines(mount_rad: float) -> tuple[str, ...]:
    apart = f"heading and track are {math.degrees(abs(mount_rad)):.0f} deg apart on the move"
    return "", "[setup.gnss]", f"heading_mount_rad = {mount_rad:.7f}  {UNSURE}{apart}"


def _line(key: str, guess: Guess, column: str) -> str:
    more = f', convention = "{guess.convention}"' if guess.convention else ""
    more += ", sign = -1" if guess.sign < 0 else ""
    name = json.dumps(column, ensure_ascii=False)
    mark = "# " if guess.sure else UNSURE
    return f'{key} = {{column = {name}, unit = "{guess.unit}"{more}}}  {mark}{guess.why}'


def _bare(name: str) -> str:
    kept = "".join(c if c.isascii() and (c.isalnum() or c in "_-") else "_" for c in name)
    return kept or "label"


def _constant(seen: Seen) -> bool:
    known = seen.values[np.isfinite(seen.values)]
    return not len(known) or bool(np.all(known == known[0]))


def _rate(seen: Seen) -> str:
    return "-" if math.isnan(seen.rate_hz) else f"{seen.rate_hz:.3g} Hz"


def _range(seen: Seen) -> str:
    known = seen.values[np.isfinite(seen.values)]
    return f"{known.min():.6g} to {known.max():.6g}" if len(known) else "no value"
