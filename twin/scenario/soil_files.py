"""Soils by name, or from a TOML file as `twin calibrate` writes it."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from twin.errors import BadInput
from twin.io.plain import from_plain
from twin.scenario.soils import PRESETS, Preset
from twin.vehicle.reading import table_of


def preset(name: str) -> Preset | None:
    """A preset by name, or from a soil's TOML file; None where there is none.

    Raises:
        BadInput: the file cannot be read, or is no soil.
    """
    if name in PRESETS or not name.endswith(".toml"):
        return PRESETS.get(name)
    path = Path(name)
    return _of_file(path, path.stat().st_mtime_ns if path.is_file() else 0)


@lru_cache(maxsize=64)
def _of_file(path: Path, stamp: int) -> Preset:
    try:
        return from_plain(Preset, table_of(path))
    except BadInput as error:
        said = str(error)
        raise BadInput(said if said.startswith(str(path)) else f"{path}: {said}") from None
