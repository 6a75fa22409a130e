"""Machines and implements by name, or from a user's own file."""

from __future__ import annotations

from dataclasses import fields, replace
from functools import cache
from pathlib import Path
from typing import TypeVar

from twin.errors import BadInput, TwinError, UnknownName
from twin.io.plain import Plain
from twin.vehicle.check import refuse_inconsistent
from twin.vehicle.implement import NONE, Implement
from twin.vehicle.machine import Machine
from twin.vehicle.reading import read, table_of

T = TypeVar("T", Machine, Implement)
USUAL = "taishan_1404a"
"""The machine of a scenario or rig that does not name one."""


@cache
def models_folder() -> Path:
    """Folder of the models: inside the installed package, or beside it in a source checkout.

    Raises:
        BadInput: it is in neither place.
    """
    package = Path(__file__).parents[1]
    for folder in (package / "_models", package.parent / "models"):
        if folder.is_dir():
            return folder
    raise BadInput(f"models are neither in {package / '_models'} nor in models/ beside it")


def machine_names() -> tuple[str, ...]:
    """Names of the machines that come with the package."""
    return tuple(_shipped("catalogue"))


def implement_names() -> tuple[str, ...]:
    """Names of the implements that come with the package."""
    return (*_shipped("implements"), NONE)


def machine(spec: str) -> Machine:
    """A machine by its name, or from the path of a TOML file or a MJCF.

    Raises:
        UnknownName: there is no such machine.
        BadInput: the file cannot be used.
    """
    found = _found("machine", spec, "catalogue", Machine)
    if found.folder and found.mjcf is None:
        try:
            refuse_inconsistent(found)
        except TwinError as error:
            raise BadInput(f"{spec}: {error}") from None
    return found


def implement(spec: str) -> Implement:
    """An implement by its name, or from the path of a TOML file; `none` for none.

    Raises:
        UnknownName: there is no such implement.
        BadInput: the file cannot be used.
    """
    if spec == NONE:
        return Implement(name=NONE, kind=NONE, about="the tractor alone")
    return _found("implement", spec, "implements", Implement)


def usual_implement(part: Machine) -> str | None:
    """The implement that a machine's file names, as an argument for `implement`; None for none.

    A relative path refers to the folder of the machine's file.
    """
    name = part.implement
    if name is None or not name.endswith(".toml") or Path(name).is_absolute():
        return name
    return str(Path(part.folder) / name)


def kind_of(path: Path) -> type[Machine] | type[Implement]:
    """Whether a TOML file describes a machine or an implement: the one with more fields in it.

    With as many of both it is an implement if it has `width_m`, which an implement needs.
    """
    given = set(table_of(path))
    machines, implements = ({f.name for f in fields(k)} for k in (Machine, Implement))
    own = len(given & (machines - implements)) - len(given & (implements - machines))
    return Machine if own > 0 or (own == 0 and "width_m" not in given) else Implement


def mjcf_path(part: Machine | Implement) -> Path | None:
    """Path of the hand-made MJCF of a machine or an implement; None if it has none.

    Raises:
        BadInput: the file is missing.
    """
    if part.mjcf is None:
        return None
    path = (Path(part.folder) if part.folder else models_folder() / part.name) / part.mjcf
    if not path.is_file():
        raise BadInput(f"mjcf = {path} is missing; a MJCF beside the file would do")
    return path


@cache
def _shipped(folder: str) -> dict[str, Path]:
    """Name -> file, of those in a folder of the models."""
    return {p.stem: p for p in sorted((models_folder() / folder).glob("*.toml"))}


_READ: dict[Path, Plain] = {}
"""What was read of the files that are shipped."""


def _read_shipped(kind: type[T], path: Path) -> T:
    if path not in _READ:
        _READ[path] = replace(read(kind, path), folder="")
    found: T = _READ[path]
    return found


def _found(what: str, spec: str, folder: str, kind: type[T]) -> T:
    shipped = _shipped(folder)
    if spec in shipped:
        return _read_shipped(kind, shipped[spec])
    path = Path(spec)
    if path.suffix == ".toml":
        return read(kind, path)
    if path.suffix == ".xml" and kind is Machine:
        if not path.is_file():
            raise BadInput(f"{path} is missing; a MJCF would do")
        return kind(name=path.stem, mjcf=path.name, folder=str(path.parent.absolute()))
    if path.exists():
        raise BadInput(f"{what} = {spec} is no TOML file; one that ends in .toml would do")
    for suffix in (".toml", ".xml") if kind is Machine else (".toml",):
        if Path(spec + suffix).is_file():
            raise BadInput(f"no {what} is called '{spec}'; did you mean the file {spec}{suffix}?")
    raise UnknownName(what, spec, shipped)
