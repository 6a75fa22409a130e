"""Import matplotlib's axes without the tables of properties in its docstrings.

They are a third of the import, and only an interactive user reads them; where matplotlib is loaded
already it keeps them.
"""

from __future__ import annotations

import matplotlib.artist


def _no_table(artist: object) -> str:
    return ""


_table, matplotlib.artist.kwdoc = matplotlib.artist.kwdoc, _no_table
try:
    import matplotlib.axes
finally:
    matplotlib.artist.kwdoc = _table
