"""The runs of a study.

Every scenario and every combination of swept values is run with the same seeds, and all estimators
see the same runs. So two estimators can be compared seed by seed.
"""

from __future__ import annotations

import dataclasses
import hashlib
import itertools
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from twin.errors import BadInput
from twin.io.plain import Plain, to_plain
from twin.pipeline import named as registry
from twin.pipeline.unread import complaint
from twin.plugins.lookup import Thing
from twin.scenario import Scenario, fields

NOT_SWEPT = {
    "seed": "`--seeds` takes the seeds (`seeds=` from Python)",
    "name": "it changes nothing in a run",
    "about": "it changes nothing in a run",
}
"""Fields that cannot be swept, and why."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """One run: a scenario with its seed, and the estimators that see its streams."""

    scenario: str
    """As it was asked for."""
    swept: tuple[tuple[str, Plain], ...]
    """Path and value of each swept field."""
    run: Thing
    """The scenario itself, swept fields and seed in place."""
    estimators: tuple[str, ...]
    """As they were asked for: names, or module:Name."""
    part: str
    """File name of its part. Equal runs have equal names, different runs different ones."""


def plan(
    scenarios: Sequence[str],
    seeds: Sequence[int],
    estimators: Sequence[str],
    sweeps: Mapping[str, Sequence[Plain]],
) -> list[Case]:
    """Every combination, each once, in the order given; the last sweep changes fastest but seeds.

    Args:
        scenarios: names, or module:Name.
        seeds: of each combination.
        estimators: names, or module:Name.
        sweeps: path of a field -> the values it takes.

    A combination that sets a field its run would not read is left out; `left_out` says which.

    Raises:
        UnknownName, BadInput, OutOfRange: for whatever cannot be run, before anything is.
    """
    names = tuple(dict.fromkeys(estimators))
    told = {name: _told(name, registry.load("estimator", name)) for name in names}
    cases = []
    for scenario, swept, base in _settings(scenarios, sweeps)[0]:
        for seed in dict.fromkeys(seeds):
            run = fields.replaced(base, {"seed": seed})
            part = f"{_plain(scenario)}-seed{seed}-{_digest(run, told)}.parquet"
            case = Case(scenario=scenario, swept=swept, run=run, estimators=names, part=part)
            cases.append(case)
    return cases


def left_out(scenarios: Sequence[str], sweeps: Mapping[str, Sequence[Plain]]) -> list[str]:
    """What of a plan is left out and why, a sentence each. Arguments and errors as `plan`."""
    return _settings(scenarios, sweeps)[1]


Setting = tuple[str, tuple[tuple[str, Plain], ...], Thing]
"""Name of a scenario, path and value of each swept field, and the scenario with them."""


def _settings(
    scenarios: Sequence[str], sweeps: Mapping[str, Sequence[Plain]]
) -> tuple[list[Setting], list[str]]:
    """The settings of a plan, and what is said of those that are left out.

    Raises:
        BadInput: a field cannot be swept, all settings are left out, or a scenario without a sweep
            sets a field that its run would not read.
    """
    for path in sweeps:
        if path in NOT_SWEPT:
            raise BadInput(f"{path} cannot be swept: {NOT_SWEPT[path]}")
    kept: list[Setting] = []
    said: list[str] = []
    for scenario in dict.fromkeys(scenarios):
        base = registry.load("scenario", scenario)
        for values in itertools.product(*(dict.fromkeys(v) for v in sweeps.values())):
            swept = tuple(zip(sweeps, values, strict=True))
            run = fields.replaced(base, dict(swept))
            if (why := complaint(run, tuple(sweeps))) is None:
                kept.append((scenario, swept, run))
                continue
            if not sweeps:
                raise BadInput(f"{scenario}: {why}")
            setting = ", ".join(f"{path} = {value}" for path, value in swept)
            said.append(f"{scenario}, {setting}: {why}")
    if said and not kept:
        raise BadInput(f"no value of the sweep can be run: {said[0]}")
    return kept, said


def _told(name: str, estimator: Thing) -> Plain:
    """What identifies an estimator: its name, and its settings if it is a dataclass."""
    shows = dataclasses.is_dataclass(estimator) and not isinstance(estimator, type)
    return [name, to_plain(estimator) if shows else None]


def _digest(run: Thing, told: Mapping[str, Plain]) -> str:
    run = run.with_numbers() if isinstance(run, Scenario) else run  # an edited preset is another
    said = {"kind": type(run).__qualname__, "run": to_plain(run), "estimators": told}
    text = json.dumps(said, sort_keys=True, default=repr)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def _plain(name: str) -> str:
    return re.sub(r"[^\w.-]+", "-", name)
