"""Scenarios and estimators by name, or by `module:Name` from wherever the user stands."""

from __future__ import annotations

import dataclasses
import importlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from twin.errors import BadInput, UnknownName
from twin.lookup import attribute, line

PACKAGES = {"scenario": "scenarios", "estimator": "estimators"}
"""Kind of thing -> the package whose `REGISTRY` maps its names to "module:Attribute"."""


def names(kind: str) -> list[str]:
    """The registered names of a kind, sorted. Raises UnknownName for a kind that there is not."""
    return sorted(_registry(kind))


def load(kind: str, spec: str) -> Any:
    """The thing a registered name or a `module:Name` stands for.

    `module:` alone means the module itself. The working directory is added to the end of the
    import path, so nothing in it shadows an installed package. A class is made into an
    instance.

    Raises:
        UnknownName: no such kind, or no such name and it is no `module:Name`.
        BadInput: the module cannot be imported, lacks the attribute, or it is none of the kind.
    """
    known = _registry(kind)
    if ":" not in spec:
        if spec not in known and Path(f"{spec}.py").is_file():
            raise BadInput(f"no {kind} is called '{spec}'; of {spec}.py say what, as {spec}:Name")
        if spec not in known:
            raise UnknownName(kind, spec, known)
        spec = known[spec]
    found = attribute(kind, spec)
    return (_estimator if kind == "estimator" else _scenario)(spec, found)


def _registry(kind: str) -> Mapping[str, str]:
    if kind not in PACKAGES:
        raise UnknownName("kind", kind, PACKAGES)
    registry: Mapping[str, str] = importlib.import_module(PACKAGES[kind]).REGISTRY
    return registry


def _scenario(spec: str, found: Any) -> Any:
    found = _instance("scenario", spec, found)
    drives = hasattr(found, "machine") or callable(getattr(found, "measure", None))
    if not (drives and dataclasses.is_dataclass(found)):
        raise BadInput(
            f"scenario '{spec}' is {type(found).__name__}; it must be a twin.scenario.Scenario, "
            "or a dataclass with name, seed and measure() -> (setup, streams, truth)"
        )
    lacking = [name for name in ("name", "seed") if not hasattr(found, name)]
    if lacking:
        raise BadInput(f"scenario '{spec}' has no {' and no '.join(lacking)}")
    return found


def _instance(kind: str, spec: str, found: Any) -> Any:
    if not isinstance(found, type):
        return found
    try:
        return found()
    except Exception as error:  # whatever a user's constructor raises
        raise BadInput(f"{kind} '{spec}' cannot be made: {line(error)}") from None


def _estimator(spec: str, found: Any) -> Any:
    found = _instance("estimator", spec, found)
    lacking = [name for name in ("init", "run") if not callable(getattr(found, name, None))]
    if lacking:
        raise BadInput(
            f"estimator '{spec}' has no {' and no '.join(lacking)}; "
            "it needs init(setup) -> state and run(state, chunk) -> (state, estimates)"
        )
    return found
