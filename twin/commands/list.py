"""`twin list`: print all scenarios, machines, implements, soils and estimators."""

from __future__ import annotations

import ast
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from twin.commands.terminal import say


@dataclass(frozen=True, kw_only=True)
class List:
    """List scenarios, machines, implements, soils and estimators with one line each."""

    json: bool = False
    """Print JSON instead of text."""


def main(args: Sequence[str]) -> int:
    """Print every name with its description."""
    import estimators

    options = _read(args)
    groups = everything()
    if options.json:
        print(json.dumps(groups, indent=2))
        return 0
    for title, entries in groups.items():
        if title != "estimators":
            _print(title, entries)
            continue
        for group, names in estimators.GROUPS.items():
            _print(f"estimators, {group}", {name: entries[name] for name in names})
    return 0


def _read(args: Sequence[str]) -> List:
    """The options; tyro is loaded only where there are others than `--json`."""
    if set(args) <= {"--json"}:
        return List(json=bool(args))
    from twin.commands.parse import parse

    return parse(List, args, prog="twin list")


def _print(title: str, entries: Mapping[str, str]) -> None:
    say(title, style="bold")
    width = max((len(name) for name in entries), default=0)
    for name, about in entries.items():
        say(f"  {name:<{width}}  {about}", indent=width + 4)


def everything() -> dict[str, dict[str, str]]:
    """Kind -> name -> one line, without importing anything heavy."""
    import estimators
    import scenarios
    from twin.scenario.soils import PRESETS
    from twin.vehicle import files

    return {
        "scenarios": {n: _scenario_about(n) for n in scenarios.REGISTRY},
        "machines": {name: files.machine(name).about for name in files.machine_names()},
        "implements": {name: files.implement(name).about for name in files.implement_names()},
        "soils": {name: preset.about for name, preset in PRESETS.items()},
        "estimators": described(estimators.REGISTRY),
    }


def described(registry: Mapping[str, str]) -> dict[str, str]:
    """First line of the documentation of each `module:Attribute`, read without importing it."""
    return {name: _about(target) for name, target in registry.items()}


def _scenario_about(name: str) -> str:
    from twin.pipeline import named as registry

    return str(registry.load("scenario", name).about)


def _about(target: str) -> str:
    module, _, attribute = target.partition(":")
    file = _file(module)
    if file is None:
        return ""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    text = _attribute_doc(tree, attribute) or ast.get_docstring(tree) or ""
    return text.split("\n\n")[0].replace("\n", " ").strip()


def _file(module: str) -> Path | None:
    """Where a module stands; `find_spec` of an inner one would import the packages around it."""
    top, *inner = module.split(".")
    spec = find_spec(top)
    if spec is None or not spec.submodule_search_locations:
        return None if spec is None or spec.origin is None else Path(spec.origin)
    place = Path(spec.submodule_search_locations[0]).joinpath(*inner)
    file = place / "__init__.py" if place.is_dir() else place.with_name(f"{place.name}.py")
    return file if file.exists() else None


def _attribute_doc(tree: ast.Module, attribute: str) -> str | None:
    """Docstring of a class or function, or the string under an assignment."""
    for node, following in zip(tree.body, [*tree.body[1:], None], strict=True):
        if isinstance(node, (ast.ClassDef, ast.FunctionDef)) and node.name == attribute:
            return ast.get_docstring(node)
        assigned = isinstance(node, (ast.Assign, ast.AnnAssign)) and _assigns(node, attribute)
        if assigned and isinstance(following, ast.Expr):
            return str(getattr(following.value, "value", "")) or None
    return None


def _assigns(node: ast.Assign | ast.AnnAssign, name: str) -> bool:
    targets = node.targets if isinstance(node, ast.Assign) else [node.target]
    return any(isinstance(t, ast.Name) and t.id == name for t in targets)
