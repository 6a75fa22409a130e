"""What SECURITY.md says of the sources is true of them."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = [
    path
    for package in ("twin", "scenarios", "estimators")
    for path in (ROOT / package).rglob("*.py")
]
EXECUTING = {"eval", "exec", "compile", "execfile", "__import__"}
UNPICKLING = {
    ("pickle", "load"),
    ("pickle", "loads"),
    ("torch", "load"),
    ("joblib", "load"),
    ("os", "system"),
}
OWN_BYTES = {"twin/testing/checks.py": {"pickle.loads"}}
"""Unpickles a state of the estimator under test that it pickled itself a moment before."""
MODULES = {"shelve", "marshal", "dill", "cloudpickle"}


def calls(tree: ast.AST) -> set[str]:
    """Calls that run or unpickle what they are given."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            function = node.func
            if isinstance(function, ast.Name) and function.id in EXECUTING:
                found.add(function.id)
            if isinstance(function, ast.Attribute) and isinstance(function.value, ast.Name):
                pair = (function.value.id, function.attr)
                found |= {".".join(pair)} if pair in UNPICKLING else set()
            found |= {
                "allow_pickle"
                for word in node.keywords
                if word.arg in ("allow_pickle", "shell")
                and not (isinstance(word.value, ast.Constant) and word.value.value is False)
            }
        if isinstance(node, ast.Import):
            found |= {name.name for name in node.names} & MODULES
        if isinstance(node, ast.ImportFrom):
            found |= {node.module or ""} & MODULES
            if node.module in ("pickle", "torch", "joblib"):
                found |= {
                    f"{node.module}.{n.name}" for n in node.names if n.name in ("load", "loads")
                }
    return found


def test_nothing_is_executed_or_unpickled() -> None:
    found = {
        path.relative_to(ROOT).as_posix(): calls(ast.parse(path.read_text(encoding="utf-8")))
        for path in SOURCES
    }
    assert len(found) > 100
    assert {path: what for path, what in found.items() if what} == OWN_BYTES


@pytest.mark.parametrize(
    "text",
    [
        "eval('1')",
        "import pickle\npickle.load(f)",
        "from joblib import load",
        "np.load(f, allow_pickle=True)",
        "import dill",
    ],
)
def test_it_would_be_found(text: str) -> None:
    assert calls(ast.parse(text))
