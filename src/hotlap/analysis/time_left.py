"""Time left: how long work will still take whose pieces are of several kinds, from how long pieces of each kind have taken."""

from __future__ import annotations

import statistics
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable


class TimeLeft:
    """Watches pieces of work.

    Args:
        waiting: the kind of each piece that is to be done.
        clock: [s]
    """

    def __init__(self, waiting: Iterable[str], clock: Callable[[], float] = time.monotonic) -> None:
        self._waiting, self._clock, self._last = Counter(waiting), clock, clock()
        self._taken: dict[str, list[float]] = defaultdict(list)

    def after(self, kind: str) -> str:
        """Count a piece that has just ended, begun when the one before had ended; the time that is left, in words.

        "" where nothing is left, and as long as there is a kind that waits and of which no piece has been done.
        """
        now = self._clock()
        self._taken[kind].append(now - self._last)
        self._last = now
        self._waiting[kind] -= 1
        return in_words(self.seconds)

    @property
    def seconds(self) -> float | None:
        """[s] that are left, by the median of each kind; None where that is not known."""
        waiting = {kind: number for kind, number in self._waiting.items() if number > 0}
        if any(not self._taken[kind] for kind in waiting):
            return None
        return sum(number * statistics.median(self._taken[kind]) for kind, number in waiting.items())


def in_words(seconds: float | None) -> str:
    """A time that is left for people: "about 40 s left", "about 3 min left"; "" where there is none, or nobody knows."""
    if not seconds:
        return ""
    if seconds < 90:
        return f"about {max(seconds, 1):.0f} s left"
    return f"about {seconds / 60:.0f} min left" if seconds < 90 * 60 else f"about {seconds / 3600:.1f} h left"
