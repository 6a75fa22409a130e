"""Compile functions with numba, and keep the machine code where a stale copy cannot be found.

numba's own cache looks at the file of the function it compiled, not at the functions that one
calls, nor at constants taken from elsewhere. So the folder that keeps a module's machine code is
named by all that it is made from: the text of the module, of every module of ours that it imports,
directly or not, and the versions of the libraries. Only our own modules are kept; a function from
elsewhere is compiled anew in every process, because what it imports is not known here.
"""

from __future__ import annotations

import hashlib
import os
import platform
import re
import shutil
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any, ParamSpec, TypeAlias, TypeVar

import numba
from numba.core.caching import CompileResultCacheImpl, FunctionCache, InTreeCacheLocator
from numba.core.ccallback import CFunc
from numba.core.sigutils import normalize_signature

from twin.compute import waiting
from twin.compute.kernel import Kernel, without_collection
from twin.compute.numba_arrays import load_numba_arrays

P = ParamSpec("P")
R = TypeVar("R")
Untyped: TypeAlias = Any
"""What is numba's own, which has no types."""
Function = Callable[..., Untyped]

ROOT = Path(__file__).parents[2]
PACKAGES = ("twin", "scenarios", "estimators")
LIBRARIES = ("llvmlite", "mujoco", "numba", "numpy")
"""What compiled code is made with, or takes numbers from: where MuJoCo's fields stand, too."""
UNUSED_S = 30 * 86400.0
"""Machine code that no process asked for in so long is deleted."""
STARTED_S = time.time()
IMPORT = re.compile(r"^[ \t]*(?:from[ \t]+([\w.]+)[ \t]+)?import[ \t]+(\([^)]*\)|.+)", re.MULTILINE)


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """The function as numba compiles it at its first call; a division by zero raises."""
    return _njit(function)


def inlined(function: Callable[P, R]) -> Callable[P, R]:
    """`compiled`, and always inlined: for what takes a compiled function as an argument.

    An argument that is a function is an address of this process, and its caller could not be kept
    between processes; inlined, the address vanishes.
    """
    return _njit(function, forceinline=True)


def law(function: Callable[P, R]) -> Callable[P, R]:
    """`compiled`, but a division by zero is inf or NaN: nothing can be raised inside MuJoCo.

    A law makes no array; arrays are not counted, which is a part of what is compiled.
    """
    return _njit(function, error_model="numpy", _nrt=False)


def array_law(function: Callable[P, R]) -> Callable[P, R]:
    """A `law` that makes arrays: a division by zero is inf or NaN."""
    return _njit(function, error_model="numpy")


def inlined_law(function: Callable[P, R]) -> Callable[P, R]:
    """A `law` that becomes part of its caller: small, or called once in the step's hot path.

    Calls with arrays and tuples cost tens of nanoseconds, a twentieth of the physics step together.
    """
    return _njit(function, error_model="numpy", _nrt=False, forceinline=True)


def c_callback(signature: Untyped) -> Callable[[Function], Untyped]:
    """Compile a function to a C function, with its `address`, at once."""

    def build(function: Function) -> Untyped:
        options = {"error_model": "numpy"}
        made = CFunc(function, normalize_signature(signature), locals={}, options=options)
        _keep(made, function)
        with without_collection():
            made.compile()
        return made

    return build


def key(file: Path, *more: str) -> str:
    """Sixteen hex digits for all that compiled functions of a file can read."""
    texts = sorted(f"{'/'.join(source.parts[-2:])} {_digest(source)}" for source in sources(file))
    return hashlib.sha256("\n".join([*_versions(), *texts, *more]).encode()).hexdigest()[:16]


@cache
def _versions() -> tuple[str, ...]:
    return platform.python_version(), *(f"{name} {version(name)}" for name in LIBRARIES)


@cache
def sources(file: Path) -> tuple[Path, ...]:
    """The file, and every file of our packages that it imports, directly or not."""
    found, to_read = set[Path](), {file}
    while to_read:
        found |= to_read
        to_read = {read for source in to_read for read in imports(source)} - found
    return tuple(sorted(found))


@cache
def imports(file: Path) -> frozenset[Path]:
    """The files of our packages that a file's import statements name, anywhere in it.

    `from a.b import c` names a/b/c.py or, where c is no module, the file of a.b.
    """
    found = set[Path | None]()
    for package, names in IMPORT.findall(file.read_text(encoding="utf-8", errors="replace")):
        for name in re.findall(r"[\w.]+", names):
            found.add((package and _module(f"{package}.{name}")) or _module(package or name))
    return frozenset(file for file in found if file)


@cache
def _module(name: str) -> Path | None:
    """The file of a module of ours."""
    if name.partition(".")[0] not in PACKAGES:
        return None
    path = ROOT.joinpath(*name.split("."))
    return next((f for f in (path / "__init__.py", path.with_suffix(".py")) if f.is_file()), None)


@cache
def _digest(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


@cache
def folder(file: Path) -> Path | None:
    """Where the machine code of a file's functions is kept, made if need be.

    None for a file that is not ours, and where the user's cache cannot be written.
    """
    if not any(ROOT / package in file.parents for package in PACKAGES):
        return None
    try:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "tractor-twin"
        module = ".".join(file.relative_to(ROOT).with_suffix("").parts)
        made = base / f"{module}-{key(file)}"
        if not made.exists():
            made.mkdir(parents=True, exist_ok=True)
            _delete_unused(base)
        os.utime(made)
        with tempfile.TemporaryFile(dir=made):
            return made
    except (OSError, RuntimeError):  # RuntimeError: there is no home
        return None


@cache
def _delete_unused(base: Path) -> None:
    """Delete what is old; a process that still uses it makes its folder anew."""
    for old in base.iterdir():
        with suppress(OSError):
            if time.time() - old.stat().st_mtime > UNUSED_S:
                shutil.rmtree(old)


def is_edited(file: Path) -> bool:
    """Whether a source was written since this process began, so that either form may be loaded."""
    try:
        return any(source.stat().st_mtime > STARTED_S for source in sources(file))
    except FileNotFoundError:
        return True


class _Locator(InTreeCacheLocator):  # type: ignore[misc]  # numba has no types
    """Gives numba the folder, which is the same for every copy of the same sources."""

    def __init__(self, function: Untyped, file: str) -> None:
        super().__init__(function, file)
        self._cache_path = str(folder(Path(file)))

    def get_source_stamp(self) -> str:
        """Nothing: the folder's name identifies the state of the sources."""
        return ""


class _Results(CompileResultCacheImpl):  # type: ignore[misc]
    _locator_classes = (_Locator,)


class _Cache(FunctionCache):  # type: ignore[misc]
    """numba's cache of one function, where two processes may write at once, on a full disk."""

    _impl_class = _Results

    def load_overload(self, sig: Untyped, target_context: Untyped) -> Untyped:
        """What was kept for these types of arguments.

        Two processes that compile the function for different types at the same moment may both
        write the first data file, and then the index gives one's types to the other's code.
        """
        load_numba_arrays()
        try:
            found = super().load_overload(sig, target_context)
        except Exception:  # a damaged file: numba unpickles what it finds
            found = None
        wanted, _ = normalize_signature(sig)
        if found is not None and tuple(found.signature.args) == wanted:
            return found
        waiting.begins(self)
        return None

    def save_overload(self, sig: Untyped, data: Untyped) -> None:
        """Keep it if that can be done."""
        waiting.ends(self)
        with suppress(Exception):
            super().save_overload(sig, data)


def _njit(function: Callable[P, R], **options: Untyped) -> Callable[P, R]:
    if numba.config.DISABLE_JIT:
        return function
    made = Kernel(function, targetoptions={"nopython": True, "nogil": True, **options})
    _keep(made, function)
    dispatcher: Callable[P, R] = made
    return dispatcher


def _keep(made: Untyped, function: Function) -> None:
    """Let numba look for machine code, and keep it, in the folder of the function's file."""
    file = Path(function.__code__.co_filename)
    if folder(file) is not None and not is_edited(file):
        with suppress(RuntimeError):  # the folder could be written a moment ago
            made._cache = _Cache(function)
