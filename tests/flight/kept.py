"""Compiled functions of tests are kept on disk as those of the flight core are: compiled once for all processes and runs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba import njit

from hotlap.flight.kernel_cache import keep
from hotlap.flight.numbers import COMPILE
from hotlap.system.disk_cache import digest_sources


def kept(function: Callable[..., Any], label: str = "") -> Any:
    """A function compiled as the flight core's are; made anew when its file or the flight core changes.

    Args:
        function: calls compiled functions of hotlap, and of its own file.
        label: what it depends on besides: where a function is made for several kinds of number, the kind.
    """
    code = digest_sources(Path(function.__code__.co_filename))
    return keep(njit(**COMPILE)(function), f"test-{function.__module__}-{function.__name__}-{label}-{code}")
