"""Slow flights: flights of a simulator, which take seconds, shown one by one."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import TYPE_CHECKING

from hotlap.api.progress import Progress
from hotlap.api.rates import Pace
from hotlap.worlds.stepped import Stepped
from hotlap.worlds.world import World

if TYPE_CHECKING:
    from hotlap.tuning.loop import Batch


@contextmanager
def flying(world: World, flights: int, progress: Progress, text: str) -> Iterator[None]:
    """Say that flights are flown: those of a simulator are counted.

    Args:
        world: where.
        flights: how many.
        progress: is told.
        text: what is done, where flights take no time.
    """
    if not isinstance(world, Stepped):
        with progress.working(text):
            yield
        return
    pace = Pace()
    with progress.pieces("flights", flights, 0) as say:

        def count(ended: int) -> None:
            """One more."""
            pace.count()
            say(pace.words(flights - ended))

        with watched(world, count):
            yield


def followed(world: World, watch: Callable[[Batch], None]) -> AbstractContextManager[None]:
    """Let what watches a search see its flights one by one, where it can and they take seconds."""
    return watched(world, getattr(watch, "flown", None))


@contextmanager
def watched(world: World, see: Callable[[int], None] | None) -> Iterator[None]:
    """Let a simulator tell of each flight that has ended; None: it tells nobody."""
    if see is None or not isinstance(world, Stepped):
        yield
        return
    before, world.watch = world.watch, see
    try:
        yield
    finally:
        world.watch = before
