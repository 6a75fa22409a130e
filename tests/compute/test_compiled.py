"""Compiled code is never stale: what is kept follows everything a compiled function reads."""

from __future__ import annotations

import ast
import importlib
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import numba
import numpy as np
import pytest

from twin.compute import compiled

ROOT = Path(__file__).parents[2]
COMPILING = sorted(
    file
    for package in compiled.PACKAGES
    for file in (ROOT / package).rglob("*.py")
    if re.search(r"^from twin\.compute\.compiled import", file.read_text(), re.MULTILINE)
)
"""Every module of ours that holds compiled functions."""
CACHED = (compiled.sources, compiled.imports, compiled._module, compiled._digest, compiled.folder,
          compiled._delete_unused, compiled._versions)  # fmt: skip

PROGRAM = """
import numpy as np
from estimators.layout import NOMINAL, SIGNALS
from estimators.steps import first_step, gather
from twin.camera.soil_texture import add_noise
from twin.physics.coupling import twist

torque, _ = twist(np.arange(1.0, 6.0), 1.0, 0.1, 0.2, 0.01)
picture = np.zeros((4, 4), np.float32)
add_noise(picture, np.uint32(7), 1, 2, 1, np.float32(1.0))
signal, step = np.zeros(1, SIGNALS), first_step()
signal["v_x_mps"], signal["accel_mps2"] = 2.0, 3.0
gather(signal[0], np.zeros(1, NOMINAL)[0], step[0])
for name, value, law in (
    ("physics", torque, twist), ("camera", picture.sum(), add_noise),
    ("estimators", np.nansum(step["z"] * np.arange(5)), gather),
):
    print(name, repr(float(value)), sum(law.stats.cache_hits.values()))
"""
EDITS = {
    "physics": ("twin/physics/block.py", "DAMPING_S = 4", "DAMPING_S = 0"),
    "camera": ("twin/camera/chance.py", "0x8DA6B343", "0x8DA6B345"),
    "estimators": ("twin/streams.py", '    "gnss": (', '    "odometer": (),\n    "gnss": ('),
}
"""What each part reads in another file: a place in the block, a constant, an order of columns."""


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the packages, to be edited."""
    folder = tmp_path_factory.mktemp("checkout")
    for package in compiled.PACKAGES:
        ignore = shutil.ignore_patterns("__pycache__", "_models")
        shutil.copytree(ROOT / package, folder / package, ignore=ignore)
    return folder


def started(checkout: Path, cache: Path, program: str = PROGRAM) -> subprocess.Popen[str]:
    """A process that runs a program on a checkout's packages."""
    environment = os.environ | {
        "XDG_CACHE_HOME": str(cache),
        "PYTHONPATH": str(checkout),
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    return subprocess.Popen(
        [sys.executable, "-c", program],
        env=environment, cwd=checkout, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip


def said(process: subprocess.Popen[str]) -> dict[str, tuple[float, int]]:
    """Part -> what its function gave, and how often machine code came from the cache."""
    out, err = process.communicate()
    assert process.returncode == 0, err
    lines = (line.split() for line in out.splitlines())
    return {name: (float(value), int(hits)) for name, value, hits in lines}


@pytest.mark.slow
def test_an_edit_of_what_a_function_reads_runs_at_once_and_all_else_from_the_cache(
    checkout: Path, tmp_path: Path
) -> None:
    """The first two processes compile at the same time."""
    both = [started(checkout, tmp_path) for _ in range(2)]
    first, second = (said(process) for process in both)
    assert {name: value for name, (value, _) in first.items()} == {
        name: value for name, (value, _) in second.items()
    }
    kept = {name: (value, 1) for name, (value, _) in first.items()}
    assert said(started(checkout, tmp_path)) == kept
    texts = {file: (checkout / file).read_text() for file, _, _ in EDITS.values()}
    for file, old, new in EDITS.values():
        assert texts[file].count(old) == 1
        (checkout / file).write_text(texts[file].replace(old, new))
    edited = said(started(checkout, tmp_path))
    assert [name for name in edited if edited[name] == (first[name][0], 0)] == []
    assert {hits for _, hits in edited.values()} == {0}
    for file, text in texts.items():
        (checkout / file).write_text(text)
    assert said(started(checkout, tmp_path)) == kept


def reads(file: Path) -> set[Path]:
    """The files of our packages that a file imports, as Python's own parser has it."""
    found: set[Path] = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}: write the whole name of what is imported"
            names = [f"{node.module}.{name.name}" for name in node.names]
            names = [name if place(name) else str(node.module) for name in names]
        elif isinstance(node, ast.Import):
            names = [name.name for name in node.names]
        else:
            continue
        found |= {path for name in names if (path := place(name))}
    return found


def place(module: str) -> Path | None:
    path = ROOT.joinpath(*module.split("."))
    if module.split(".")[0] not in compiled.PACKAGES:
        return None
    return next((p for p in (path / "__init__.py", path.with_suffix(".py")) if p.exists()), None)


@pytest.mark.parametrize("package", compiled.PACKAGES)
def test_every_import_is_seen(package: str) -> None:
    missed = {
        file: reads(file) - compiled.imports(file)
        for file in (ROOT / package).rglob("*.py")
        if "_models" not in file.parts
    }
    assert {file: some for file, some in missed.items() if some} == {}


def test_the_sources_of_compiled_code_are_closed_under_imports() -> None:
    assert len(COMPILING) > 40
    for file in COMPILING:
        sources = set(compiled.sources(file))
        assert file in sources
        assert set().union(*map(reads, sources)) <= sources


def test_an_edit_of_the_edge_recompiles_nothing() -> None:
    core = re.compile(
        r"estimators/|twin/(physics|camera|compute|plugins|scenario|sensors|trajectory)/|"
        r"twin/(simulation/(quiet|braking|controls|decision|driver|finite|records)|truth/motion|"
        r"env/(control_step|gearbox|judging|levers|quantities|reward|towing|traction_drive)|machine/(fuel|hitch)|\w+)\.py"
    )
    read = {str(f.relative_to(ROOT)) for file in COMPILING for f in compiled.sources(file)}
    assert [file for file in read if not core.match(file)] == []


def test_the_key_has_the_version_of_every_library_that_compiled_code_imports() -> None:
    libraries = set()
    for source in {source for file in COMPILING for source in compiled.sources(file)}:
        text = source.read_text()
        libraries |= set(
            re.findall(r"^\s*(?:from|import) (\w+)[\w.]*(?= import|\n| as)", text, re.M)
        )
    unknown = libraries - {*compiled.LIBRARIES, *compiled.PACKAGES, *sys.stdlib_module_names}
    assert unknown - {"scipy", "cv2"} == set()  # these are called beside compiled code, never in it


@pytest.fixture
def ours(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., ModuleType]]:
    """Writes a module of a package of ours, and its text changes to it; the module as loaded."""
    (tmp_path / "estimators").mkdir()
    monkeypatch.setattr(compiled, "ROOT", tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    forget()

    def write(text: str, name: str = "made_for_tests") -> ModuleType:
        file = tmp_path / "estimators" / f"{name}.py"
        file.write_text(text)
        os.utime(file, (1e9, 1e9))
        forget()
        spec = importlib.util.spec_from_file_location(f"estimators.{name}", file)
        assert spec
        assert spec.loader
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module

    yield write
    monkeypatch.undo()
    forget()


def forget() -> None:
    """Begin as a new process does."""
    for function in CACHED:
        function.cache_clear()


DOUBLED = (
    "from twin.compute.compiled import compiled\n@compiled\ndef doubled(x):\n    return 2 * x\n"
)


def hits(function: numba.core.dispatcher.Dispatcher) -> int:
    return sum(function.stats.cache_hits.values())


def test_what_was_kept_is_used_again(ours: Callable[..., ModuleType], tmp_path: Path) -> None:
    assert ours(DOUBLED).doubled(2) == 4
    again = ours(DOUBLED).doubled
    assert (again(2), hits(again)) == (4, 1)
    (kept,) = (tmp_path / "cache" / "tractor-twin").iterdir()
    assert re.fullmatch(r"estimators\.made_for_tests-[0-9a-f]{16}", kept.name)


@pytest.mark.parametrize("name", compiled.LIBRARIES)
def test_the_key_follows_the_versions(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    before, known = compiled.key(COMPILING[0]), compiled.version
    monkeypatch.setattr(compiled, "version", lambda n: "99.0" if n == name else known(n))
    compiled._versions.cache_clear()
    assert compiled.key(COMPILING[0]) != before
    monkeypatch.undo()
    compiled._versions.cache_clear()
    assert compiled.key(COMPILING[0]) == before


def test_a_function_of_other_peoples_is_not_kept(tmp_path: Path) -> None:
    function = compiled.law(lambda x: x + 1)
    assert function(1) == 2
    assert function.stats.cache_path is None  # type: ignore[attr-defined]


def test_a_cache_that_cannot_be_written_is_done_without(
    ours: Callable[..., ModuleType], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    doubled = ours(DOUBLED).doubled
    assert (doubled(2), doubled.stats.cache_path) == (4, None)


def test_a_cache_that_cannot_be_written_any_more_is_done_without(
    ours: Callable[..., ModuleType], tmp_path: Path
) -> None:
    doubled = ours(DOUBLED).doubled
    shutil.rmtree(tmp_path / "cache")
    (tmp_path / "cache").write_text("")
    assert doubled(2) == 4


def test_damaged_machine_code_is_done_without(
    ours: Callable[..., ModuleType], tmp_path: Path
) -> None:
    ours(DOUBLED).doubled(2)
    for pattern in ("*.nbc", "*.nbi"):
        for file in tmp_path.rglob(pattern):
            file.write_bytes(file.read_bytes()[:20])
        assert ours(DOUBLED).doubled(2) == 4


def test_a_source_that_was_edited_while_the_process_runs_is_not_kept(
    ours: Callable[..., ModuleType], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compiled, "STARTED_S", 0.9e9)
    doubled = ours(DOUBLED).doubled
    assert (doubled(2), doubled.stats.cache_path) == (4, None)


def test_code_for_other_types_of_arguments_is_not_taken(
    ours: Callable[..., ModuleType], tmp_path: Path
) -> None:
    """An index that two processes wrote at once: it gives the integers' code to a real number."""
    ours(DOUBLED).doubled(1.5)
    (index,) = tmp_path.rglob("*.nbi")
    for_reals = index.read_bytes()
    shutil.rmtree(index.parent)
    ours(DOUBLED).doubled(1)
    index.write_bytes(for_reals)
    assert ours(DOUBLED).doubled(1.5) == 3.0


def test_machine_code_that_nobody_uses_is_deleted(
    ours: Callable[..., ModuleType], tmp_path: Path
) -> None:
    base = tmp_path / "cache" / "tractor-twin"
    for name, days in (("unused", 31), ("used", 29)):
        (base / name).mkdir(parents=True)
        (base / name / "code.nbc").write_text("")
        then = time.time() - days * 86400
        os.utime(base / name, (then, then))
    ours(DOUBLED)
    assert {folder.name.partition("-")[0] for folder in base.iterdir()} == {
        "used",
        "estimators.made_for_tests",
    }


def test_laws_divide_as_numpy_does_and_loops_raise() -> None:
    def inverse(x: float) -> float:
        return 1.0 / x

    assert compiled.law(inverse)(0.0) == np.inf
    with pytest.raises(ZeroDivisionError):
        compiled.compiled(inverse)(0.0)
