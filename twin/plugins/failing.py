"""Code that a user wrote, run so that what it raises is one line that says where."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager

from twin.errors import BadInput, TwinError
from twin.plugins.lookup import line, where

WRITES = re.compile("read-?only", re.IGNORECASE)
"""What numpy, numba and OpenCV say of an array that cannot be written to."""


@contextmanager
def failing(what: str, thing: object) -> Iterator[None]:
    """Whatever is raised inside, as BadInput: `WHAT fails: KeyError: 'wheelz' (mine.py, line 12)`.

    Arrays that are handed out are read-only; the error of a write says so.

    Args:
        what: who fails, as messages say it.
        thing: what the user wrote; its file is where a line is looked for first.
    """
    try:
        yield
    except TwinError:
        raise
    except Exception as error:  # whatever a user's code raises
        at = where(error, thing)
        if WRITES.search(str(error)):
            raise BadInput(
                f"{what} writes to an array it was handed{at}, which others read too; "
                "work on a copy, x = x.copy()"
            ) from error
        raise BadInput(f"{what} fails: {line(error)}{at}") from error
