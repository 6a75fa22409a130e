"""Scenarios and estimators by name, or by `module:Name` from wherever the user stands."""

from __future__ import annotations

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
    import path, so nothing in it shadows an installed package. A class of estimator is made into
    an instance.

    Raises:
        UnknownName: no such kind, or no such name and it is no `module:Name`.
        BadInput: the module cannot be imported, lacks the attribute, or it is no estimator.
    """
    known = _registry(kind)
    if ":" not in spec:
        if spec not in known and Path(f"{spec}.py").is_file():
            raise BadInput(f"no {kind} is called '{spec}'; of {spec}.py say what, as {spec}:Name")
        if spec not in known:
            raise UnknownName(kind, spec, known)
        spec = known[spec]
    found = attribute(kind, spec)
    return _estimator(spec, found) if kind == "estimator" else found


def _registry(kind: str) -> Mapping[str, str]:
    if kind not in PACKAGES:
        raise UnknownName("kind", kind, PACKAGES)
    registry: Mapping[str, str] = importlib.import_module(PACKAGES[kind]).REGISTRY
    return registry


def _estimator(spec: str, found: Any) -> Any:
    if isinstance(found, type):
        try:
            found = found()
        except Exception as error:  # whatever a user's constructor raises
            raise BadInput(f"estimator '{spec}' cannot be made: {line(error)}") from None
    lacking = [name for name in ("init", "run") if not callable(getattr(found, name, None))]
    if lacking:
        raise BadInput(
            f"estimator '{spec}' has no {' and no '.join(lacking)}; "
            "it needs init(setup) -> state and run(state, chunk) -> (state, estimates)"
        )
    return found
