"""Spreading: flights in simulators that workers of a cluster open, where one was asked for."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from hotlap import worlds
from hotlap.api.asked import Asked
from hotlap.core.errors import InputError
from hotlap.system.engine import Engine, opened


@contextmanager
def simulators_on(asked: Asked) -> Iterator[Engine | None]:
    """The cluster that was asked for; None where simulators are to be opened here.

    Raises:
        InputError: it is not usable, or nothing was asked for that is spread.
    """
    if asked.cluster is None:
        yield None
        return
    if getattr(asked, "on", "") == worlds.DEFAULT:
        reason = f"is for flights in simulators, such as on betaflight; those of {worlds.DEFAULT} take less time here than the way there"
        raise InputError("", "cluster", reason)
    with opened(asked.cluster, note=asked.progress.note) as engine:
        yield engine
