"""Scenarios and estimators by name, or by `module:Name` from wherever the user stands."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Mapping
from typing import Any

from twin.errors import BadInput, UnknownName

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
        if spec not in known:
            raise UnknownName(kind, spec, known)
        spec = known[spec]
    module, _, attribute = spec.partition(":")
    found = _attribute(kind, spec, _module(kind, spec, module), attribute)
    return _estimator(spec, found) if kind == "estimator" else found


def _registry(kind: str) -> Mapping[str, str]:
    if kind not in PACKAGES:
        raise UnknownName("kind", kind, PACKAGES)
    registry: Mapping[str, str] = importlib.import_module(PACKAGES[kind]).REGISTRY
    return registry


def _module(kind: str, spec: str, module: str) -> Any:
    if os.getcwd() not in sys.path:
        sys.path.append(os.getcwd())
    importlib.invalidate_caches()
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name and (module == error.name or module.startswith(error.name + ".")):
            raise BadInput(f"{kind} '{spec}': there is no module '{error.name}'") from None
        raise BadInput(f"{kind} '{spec}': {module} cannot be imported: {error}") from None
    except Exception as error:  # whatever a user's module raises while it is imported
        raise BadInput(f"{kind} '{spec}': {module} cannot be imported: {_line(error)}") from None


def _attribute(kind: str, spec: str, module: Any, attribute: str) -> Any:
    found = module
    for part in attribute.split(".") if attribute else ():
        if not hasattr(found, part):
            public = [n for n in dir(found) if not n.startswith("_")]
            missing = UnknownName(f"attribute of {module.__name__}", part, public)
            raise BadInput(f"{kind} '{spec}': {missing}") from None
        found = getattr(found, part)
    return found


def _estimator(spec: str, found: Any) -> Any:
    if isinstance(found, type):
        try:
            found = found()
        except Exception as error:  # whatever a user's constructor raises
            raise BadInput(f"estimator '{spec}' cannot be made: {_line(error)}") from None
    lacking = [name for name in ("init", "run") if not callable(getattr(found, name, None))]
    if lacking:
        raise BadInput(
            f"estimator '{spec}' has no {' and no '.join(lacking)}; "
            "it needs init(setup) -> state and run(state, chunk) -> (state, estimates)"
        )
    return found


def _line(error: BaseException) -> str:
    first = (str(error).splitlines() or [""])[0]
    return f"{type(error).__name__}: {first}" if first else type(error).__name__
