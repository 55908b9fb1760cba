"""A quicker start of Numba: whether there is a BLAS is seen without loading it."""

from __future__ import annotations

import sys
from importlib import import_module
from importlib.util import find_spec

BLAS, USER = "scipy.linalg.cython_blas", "numba.np.arraymath"


def defer_blas() -> None:
    """Load what Numba needs to compile anything at all, but not `scipy.linalg`, which takes a fifth of a second.

    Numba loads it only to see that it is there. Compiled code that multiplies matrices loads it again, when it is compiled.
    """
    if BLAS in sys.modules or USER in sys.modules or find_spec("numba") is None:
        return
    sys.modules[BLAS] = None  # pyright: ignore[reportArgumentType]  the import fails at once
    try:
        module = import_module(USER)
    finally:
        del sys.modules[BLAS]
    vars(module)["_HAVE_BLAS"] = find_spec("scipy") is not None
