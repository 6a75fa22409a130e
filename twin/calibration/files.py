"""The calibrated machine and soil as files that every command takes."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from twin.calibration.verdicts import Told
from twin.io.plain import Plain, to_plain
from twin.scenario import Soil
from twin.vehicle import Machine
from twin.vehicle.files import mjcf_path

KEPT_APART = ("sources", "folder")


def machine_toml(machine: Machine, found: Sequence[Told], source: str) -> str:
    """A machine's file; what was found has its interval as its source."""
    path = mjcf_path(machine)
    named = machine.implement
    if named is not None and named.endswith(".toml") and machine.folder:
        named = str(Path(machine.folder) / named)
    machine = replace(machine, name=f"{machine.name}_calibrated", implement=named,
                      mjcf=None if path is None else str(path.absolute()))  # fmt: skip
    graded: dict[str, tuple[str, str]] = {s.path: (s.grade, s.source) for s in machine.sources}
    for each in found:
        if not each.name.startswith(("soil.", "log.")):
            interval = f"{source}: {each.low:.5g} to {each.high:.5g} {each.unit}, {each.verdict}"
            graded[each.name] = ("measured" if each.verdict == "identified" else "derived",
                                 interval)  # fmt: skip
    plain = {k: v for k, v in to_plain(machine).items() if k not in KEPT_APART}
    return f"# Written by twin calibrate.\n{_table(plain, graded, '')}"


def soil_toml(soil: Soil, source: str) -> str:
    """A soil's file: what a preset says, at the values that were found."""
    plain = {k: v for k, v in to_plain(soil.resolved).items() if k != "name"}
    plain["about"] = f"calibrated from {source}"
    head = "# Written by twin calibrate: twin run NAME --soil.preset THIS.toml"
    return f"{head}\n{_table(plain, {}, '')}"


def _table(plain: Mapping[str, Plain], graded: Mapping[str, tuple[str, str]], path: str) -> str:
    """TOML of a table, its plain values first."""
    lines, parts = [], []
    for name, value in plain.items():
        here = f"{path}.{name}" if path else name
        if value is None or value in ([], {}):
            continue
        if isinstance(value, Mapping):
            inner = _table(value, graded, here)
            if inner:
                parts.append(f"\n[{here}]\n{inner}")
        elif isinstance(value, list) and isinstance(value[0], Mapping):
            parts += [f"\n[[{here}]]\n{_table(v, graded, f'{here}.{i}')}"
                      for i, v in enumerate(value)]  # fmt: skip
        else:
            lines.append(f"{name} = {_value(value, graded.get(here))}\n")
    return "".join(lines + parts)


def _value(value: Plain, graded: tuple[str, str] | None) -> str:
    text = json.dumps(value, ensure_ascii=False)
    if graded is None:
        return text
    grade, source = graded
    said = f", source = {json.dumps(source, ensure_ascii=False)}" if source else ""
    return f'{{value = {text}, grade = "{grade}"{said}}}'
