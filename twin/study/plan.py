"""Which runs a study is made of.

The same seeds serve every scenario, sweep and estimator, so that differences are paired.
"""

from __future__ import annotations

import dataclasses
import hashlib
import itertools
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from twin import registry
from twin.plain import to_plain
from twin.study import fields


@dataclass(frozen=True, kw_only=True)
class Case:
    """One run: a scenario with its seed, and the estimators that see its streams."""

    scenario: str
    """As it was asked for."""
    swept: tuple[tuple[str, Any], ...]
    """Path and value of each swept field."""
    run: Any
    """The scenario itself, swept fields and seed in place."""
    estimators: tuple[str, ...]
    """As they were asked for: names, or module:Name."""
    part: str
    """File name of its part: of the same run the same, of any other another."""


def plan(
    scenarios: Sequence[str],
    seeds: Sequence[int],
    estimators: Sequence[str],
    sweeps: Mapping[str, Sequence[Any]],
) -> list[Case]:
    """Every combination, each once, in the order given; the last sweep changes fastest but seeds.

    Args:
        scenarios: names, or module:Name.
        seeds: of each combination.
        estimators: names, or module:Name.
        sweeps: path of a field -> the values it takes.

    Raises:
        UnknownName, BadInput, OutOfRange: for whatever cannot be run, before anything is.
    """
    names = tuple(dict.fromkeys(estimators))
    told = {name: _told(name, registry.load("estimator", name)) for name in names}
    cases = []
    for scenario in dict.fromkeys(scenarios):
        base = registry.load("scenario", scenario)
        for values in itertools.product(*(dict.fromkeys(v) for v in sweeps.values())):
            swept = tuple(zip(sweeps, values, strict=True))
            for seed in dict.fromkeys(seeds):
                run = fields.replaced(base, {**dict(swept), "seed": seed})
                part = f"{_plain(scenario)}-seed{seed}-{_digest(run, told)}.parquet"
                case = Case(scenario=scenario, swept=swept, run=run, estimators=names, part=part)
                cases.append(case)
    return cases


def _told(name: str, estimator: Any) -> Any:
    """What tells an estimator from another: its name, and its settings where it shows them."""
    shows = dataclasses.is_dataclass(estimator) and not isinstance(estimator, type)
    return [name, to_plain(estimator) if shows else None]


def _digest(run: Any, told: Mapping[str, Any]) -> str:
    said = {"kind": type(run).__qualname__, "run": to_plain(run), "estimators": told}
    text = json.dumps(said, sort_keys=True, default=repr)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def _plain(name: str) -> str:
    return re.sub(r"[^\w.-]+", "-", name)
