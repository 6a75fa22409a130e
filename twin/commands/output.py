"""What commands that measure rows do with them: tables, a file, or JSON on standard output."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from twin.errors import BadInput
from twin.io import result_rows as rows_file

STDOUT = Path("-")
"""What `--json` means where it names no file."""


@dataclass(frozen=True, kw_only=True)
class Output:
    """Where rows go."""

    json: Path | None = None
    """File for the rows; without a name they are printed in place of tables."""
    quiet: bool = False
    """Say nothing but errors."""

    @property
    def talks(self) -> bool:
        """Whether tables and progress are shown."""
        return not self.quiet and self.json != STDOUT


def check_files(**files: Path | None) -> None:
    """Refuse before the work what could not be written after it. Raises BadInput."""
    for option, path in files.items():
        if path is None or path == STDOUT:
            continue
        if not path.parent.is_dir():
            raise BadInput(f"--{option} {path}: there is no directory {path.parent}")
        if path.is_dir():
            raise BadInput(f"--{option} {path} is a directory; name a file in it")


def check_folder(option: str, folder: Path | None) -> None:
    """Refuse before the work a folder that could not be made after it. Raises BadInput."""
    if folder is None:
        return
    existing = next(p for p in (folder, *folder.absolute().parents) if p.exists())
    if not existing.is_dir():
        raise BadInput(f"--{option} {folder}: {existing} is a file, not a folder")


def deliver(measured: Sequence[Mapping[str, Any]], path: Path | None) -> None:
    """Rows to where `--json` says."""
    if path == STDOUT:
        print(rows_file.to_json(measured))
    elif path is not None:
        rows_file.write(measured, path)
