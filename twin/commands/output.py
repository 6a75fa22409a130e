"""Options of commands that measure rows: tables, a JSON file, or JSON on standard output."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from twin.errors import BadInput
from twin.io import result_rows as rows_file
from twin.io.plain import Plain

STDOUT = Path("-")
"""Value of `--json` without a file name."""


@dataclass(frozen=True, kw_only=True)
class Output:
    """Where the rows are written."""

    json: Path | None = None
    """JSON file for the rows. Without a file name, print them as JSON instead of tables."""
    quiet: bool = False
    """Print errors only."""

    @property
    def talks(self) -> bool:
        """Whether tables and progress are shown."""
        return not self.quiet and self.json != STDOUT


def check_files(**files: Path | None) -> None:
    """Check before the work that files can be written after it. Raises BadInput."""
    for option, path in files.items():
        if path is None or path == STDOUT:
            continue
        if not path.parent.is_dir():
            raise BadInput(f"--{option} {path}: there is no directory {path.parent}")
        if path.is_dir():
            raise BadInput(f"--{option} {path} is a directory; name a file in it")


def check_folder(option: str, folder: Path | None) -> None:
    """Check before the work that a folder can be made after it. Raises BadInput."""
    if folder is None:
        return
    existing = next(p for p in (folder, *folder.absolute().parents) if p.exists())
    if not existing.is_dir():
        raise BadInput(f"--{option} {folder}: {existing} is a file, not a folder")


def deliver(measured: Sequence[Mapping[str, Plain]], path: Path | None) -> None:
    """Write the rows as `--json` asks."""
    if path == STDOUT:
        print(rows_file.to_json(measured))
    elif path is not None:
        rows_file.write(measured, path)
