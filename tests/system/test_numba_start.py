"""Numba starts without loading scipy.linalg, and multiplies matrices all the same."""

from __future__ import annotations

import subprocess
import sys

PROGRAM = """
import sys
from hotlap.system.numba_start import defer_blas
defer_blas()
defer_blas()
import numba, numpy as np

@numba.njit
def triple(a):
    return np.vdot(a[0], a[0]) + (a @ a).sum()

print("scipy.linalg" in sys.modules, triple(2.0 * np.eye(3)), "scipy.linalg" in sys.modules)
defer_blas()
"""


def test_matrices_are_multiplied_by_a_library_that_is_loaded_then():
    ran = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    assert ran.stdout.split() == ["False", "16.0", "True"]
