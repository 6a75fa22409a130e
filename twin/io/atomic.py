"""Files and folders that appear under their names only when whole."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from twin.errors import BadInput


@contextmanager
def written_when_complete(path: Path) -> Iterator[Path]:
    """A hidden sibling to write into, which takes the file's name when the block is left whole.

    The sibling has the file's suffix, which some writers look at.

    Raises:
        BadInput: the file cannot be written; what stood under its name is still there.
    """
    partial = path.with_name(f".{os.getpid()}.{path.name}")
    try:
        yield partial
        with partial.open("rb+") as file:
            os.fsync(file.fileno())  # a full disk shows here at the latest
        partial.replace(path)
    except OSError as error:
        raise BadInput(f"{path} cannot be written: {error.strerror or error}") from None
    finally:
        partial.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a text file, or leave what was there. Raises BadInput where it cannot be written."""
    with written_when_complete(path) as partial:
        partial.write_text(text, encoding="utf-8")


@contextmanager
def renamed_when_complete(directory: Path) -> Iterator[Path]:
    """A hidden sibling to write into, which takes the folder's name and place when left whole.

    Raises:
        BadInput: the folder cannot be written; what stood under its name is still there.
    """
    try:
        with _sibling(directory) as partial:
            partial.chmod(0o755)  # mkdtemp makes it private
            yield partial
            _swap(partial, directory)
    except OSError as error:
        raise BadInput(f"{directory} cannot be written: {error.strerror or error}") from None


@contextmanager
def moved_when_complete(folder: Path) -> Iterator[Path]:
    """A hidden sibling to write files into, which go into the folder when it is left whole.

    Raises:
        BadInput: the folder cannot be written.
    """
    try:
        with _sibling(folder) as partial:
            yield partial
            folder.mkdir(exist_ok=True)
            for file in sorted(partial.iterdir()):
                file.replace(folder / file.name)
    except OSError as error:
        raise BadInput(f"{folder} cannot be written: {error.strerror or error}") from None


@contextmanager
def _sibling(folder: Path) -> Iterator[Path]:
    folder.parent.mkdir(parents=True, exist_ok=True)
    partial = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.parent))
    try:
        yield partial
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def _swap(new: Path, directory: Path) -> None:
    """Put `new` under the final name; what was there goes away only afterwards."""
    if not directory.exists():
        new.rename(directory)
        return
    old = Path(tempfile.mkdtemp(prefix=f".{directory.name}.old.", dir=directory.parent))
    try:
        directory.rename(old / "run")
        new.rename(directory)
    finally:
        shutil.rmtree(old, ignore_errors=True)
