"""Threads of linear algebra: one is enough for a tuner's small matrices, and gives the same bits on every machine."""

from __future__ import annotations

import os
from contextlib import AbstractContextManager

from hotlap.system.environment import variables

VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")


def one_thread() -> None:
    """Let linear algebra use one thread, unless the user has set another number; to be called before numpy is loaded."""
    for name in VARIABLES:
        os.environ.setdefault(name, "1")


def one_thread_each() -> AbstractContextManager[None]:
    """Processes that are started within it use one thread each."""
    return variables(dict.fromkeys(VARIABLES, "1"))
