"""Scenarios and estimators by registered name, or by `module:Name` from the working directory.

A scenario can also be read from the folder of a run, in order to repeat the run.
"""

from __future__ import annotations

import dataclasses
import importlib
import json
from collections.abc import Mapping
from pathlib import Path

from twin.errors import BadInput, TwinError, UnknownName
from twin.io.plain import from_plain
from twin.plugins.lookup import Thing, attribute, instance, line

PACKAGES = {"scenario": "scenarios", "estimator": "estimators"}
"""Kind of thing -> the package whose `REGISTRY` maps its names to "module:Attribute"."""


def names(kind: str) -> list[str]:
    """Sorted registered names of a kind, such as scenarios. Raises UnknownName for another kind."""
    return sorted(_registry(kind))


def load(kind: str, spec: str) -> Thing:
    """Object of a registered name or of `module:Name`.

    `module:` alone means the module itself. The working directory is added to the end of the
    import path, so nothing in it shadows an installed package. A class gives an
    instance without arguments. For a scenario, `spec` can also be the folder of a run or the path
    of a scenario.json.

    Raises:
        UnknownName: the kind is unknown, or `spec` is neither a known name nor `module:Name`.
        BadInput: the module cannot be imported or lacks the attribute, the object is not of the
            kind, or the file holds no scenario.
    """
    known = _registry(kind)
    if kind == "scenario" and spec not in known and (path := _file(spec)) is not None:
        return _kept(path)
    if ":" not in spec:
        if spec not in known and Path(f"{spec}.py").is_file():
            raise BadInput(f"no {kind} is called '{spec}'; of {spec}.py say what, as {spec}:Name")
        if spec not in known:
            raise UnknownName(kind, spec, known)
        spec = known[spec]
    return checked(kind, spec, attribute(kind, spec))


def checked(kind: str, name: str, found: Thing) -> Thing:
    """Object `found` if it is of the kind; an instance if `found` is a class.

    Raises:
        BadInput: the object lacks an attribute of the kind, or the class needs arguments.
    """
    return (_estimator if kind == "estimator" else _scenario)(name, found)


def _registry(kind: str) -> Mapping[str, str]:
    if kind not in PACKAGES:
        raise UnknownName("kind", kind, PACKAGES)
    registry: Mapping[str, str] = importlib.import_module(PACKAGES[kind]).REGISTRY
    return registry


def _file(spec: str) -> Path | None:
    """The scenario.json that a folder has or a path names; None for what looks like neither."""
    path = Path(spec)
    inside = path / "scenario.json"
    if inside.is_file() or (path.is_dir() and len(path.parts) > 1):
        return inside
    return path if path.suffix == ".json" else None


def _kept(path: Path) -> Thing:
    """The scenario in a file: of the twin's own kind, or of a registered scenario's."""
    try:
        plain = json.loads(path.read_text())
    except FileNotFoundError:
        raise BadInput(f"{path} is missing") from None
    except (OSError, ValueError) as error:
        raise BadInput(f"{path} is not JSON: {line(error)}") from None
    if not isinstance(plain, Mapping):
        raise BadInput(f"{path} holds no scenario")
    from twin.scenario import Scenario

    kinds = (type(load("scenario", name)) for name in names("scenario"))
    fitting = (k for k in kinds if plain.keys() <= {f.name for f in dataclasses.fields(k)})
    try:
        return from_plain(Scenario if "machine" in plain else next(fitting, Scenario), plain)
    except TwinError as error:
        raise BadInput(f"{path}: {error}") from None


def _scenario(spec: str, found: Thing) -> Thing:
    found = instance("scenario", spec, found)
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


def _estimator(spec: str, found: Thing) -> Thing:
    found = instance("estimator", spec, found)
    lacking = [name for name in ("init", "run") if not callable(getattr(found, name, None))]
    if lacking:
        raise BadInput(
            f"estimator '{spec}' has no {' and no '.join(lacking)}; "
            "it needs init(setup) -> state and run(state, chunk) -> (state, estimates)"
        )
    return found
