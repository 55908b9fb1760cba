"""Threads of linear algebra: one, for the small matrices of a surrogate model."""

from __future__ import annotations

import sys
from contextlib import AbstractContextManager
from functools import cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController


def one_thread() -> AbstractContextManager[Any]:
    """A context in which linear algebra uses one thread: for small matrices more are slower, and they change the rounding."""
    return _libraries("scipy.linalg" in sys.modules).limit(limits=1, user_api="blas")


@cache
def _libraries(_with_scipy: bool) -> ThreadpoolController:
    """The linear algebra libraries loaded by numpy and scipy; the latter has one of its own, which may be loaded later."""
    from threadpoolctl import ThreadpoolController  # noqa: PLC0415  it looks at every library that is loaded

    return ThreadpoolController()
