"""Load what numba knows of arrays without scipy.linalg, which takes longer to import than the rest.

numba imports it only to see that it is there, which it is. A function that multiplies matrices
imports it when it is compiled or first run.
"""

from __future__ import annotations

import sys
from functools import cache
from importlib import import_module
from types import ModuleType

LOOKED_FOR = "scipy.linalg.cython_blas"


@cache
def load_numba_arrays() -> None:
    """Import `numba.np.arraymath`, with an empty module where it looks for scipy's."""
    if LOOKED_FOR in sys.modules:
        return
    sys.modules[LOOKED_FOR] = ModuleType(LOOKED_FOR)
    try:
        import_module("numba.np.arraymath")
    finally:
        del sys.modules[LOOKED_FOR]
