"""What numba knows of arrays is loaded without scipy's linear algebra, which still works."""

import subprocess
import sys

PROGRAM = """
import sys
import numpy as np
from twin.compute.numba_arrays import load_numba_arrays
load_numba_arrays()
assert "numba.np.arraymath" in sys.modules and "scipy.linalg" not in sys.modules
import numba
product = numba.njit(lambda a, b: a @ b)
assert np.array_equal(product(2.0 * np.eye(2), np.ones((2, 2))), np.full((2, 2), 2.0))
assert "scipy.linalg.cython_blas" in sys.modules
"""


def test_scipy_is_imported_where_matrices_are_multiplied_and_not_before():
    subprocess.run([sys.executable, "-c", PROGRAM], check=True)
