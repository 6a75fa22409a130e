"""Files and folders that appear under their names only when whole; every writer goes through here.

A disk that is full raises `NoSpace`, any other refusal of the system `BadInput`. Neither leaves
anything: not what was half written, and no folder that was made for it.
"""

from __future__ import annotations

import errno
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from twin.errors import BadInput, NoSpace

FULL = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})
"""What the system says of a full disk, of a user's full share of it, of a file grown too large."""


def refusal(path: Path, error: OSError) -> BadInput:
    """What to raise for a file or folder that the system refuses to write."""
    kind = NoSpace if error.errno in FULL else BadInput
    why = os.strerror(error.errno) if error.errno else str(error)
    return kind(f"{path} cannot be written: {why}")


@contextmanager
def written_when_complete(path: Path) -> Iterator[Path]:
    """A hidden sibling to write into, which takes the file's name when the block is left whole.

    The sibling has the file's suffix, which some writers look at.

    Raises:
        NoSpace, BadInput: the file cannot be written; what stood under its name is still there.
    """
    partial = path.with_name(f".{os.getpid()}.{path.name}")
    try:
        yield partial
        with partial.open("rb+") as file:
            os.fsync(file.fileno())  # a full disk shows here at the latest
        partial.replace(path)
    except OSError as error:
        raise refusal(path, error) from None
    finally:
        partial.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a text file, or leave what was there. Raises NoSpace or BadInput."""
    write_bytes(path, text.encode())


def write_bytes(path: Path, content: bytes) -> None:
    """Write a file, or leave what was there. Raises NoSpace or BadInput."""
    with written_when_complete(path) as partial:
        partial.write_bytes(content)


@contextmanager
def renamed_when_complete(directory: Path) -> Iterator[Path]:
    """A hidden sibling to write into, which takes the folder's name and place when left whole.

    Raises:
        NoSpace, BadInput: the folder cannot be written; what stood under its name is still there.
    """
    try:
        with made(directory.parent), _sibling(directory) as partial:
            partial.chmod(0o755)  # mkdtemp makes it private
            yield partial
            _swap(partial, directory)
    except OSError as error:
        raise refusal(directory, error) from None


@contextmanager
def moved_when_complete(folder: Path) -> Iterator[Path]:
    """A hidden sibling to write files into, which go into the folder when it is left whole.

    Raises:
        NoSpace, BadInput: the folder cannot be written.
    """
    try:
        with made(folder.parent), _sibling(folder) as partial:
            yield partial
            with made(folder):
                for file in sorted(partial.iterdir()):
                    file.replace(folder / file.name)
    except OSError as error:
        raise refusal(folder, error) from None


@contextmanager
def made(folder: Path) -> Iterator[None]:
    """A folder, made with those above it; where the block fails, those that are empty go again."""
    missing = [f for f in (folder, *folder.parents) if not f.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        yield
    except BaseException:
        for new in missing:  # the innermost first
            with suppress(OSError):
                new.rmdir()
        raise


@contextmanager
def _sibling(folder: Path) -> Iterator[Path]:
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
