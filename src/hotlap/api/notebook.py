"""Notebook: the progress of a call in a notebook, as bars that the browser draws, or elsewhere as lines; nothing has to be installed."""

from __future__ import annotations

import re
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from html import escape, unescape
from typing import TYPE_CHECKING, Any

from hotlap.api.progress import Progress, Quiet, Rounds
from hotlap.api.wording import percent

if TYPE_CHECKING:
    from hotlap.tuning.loop import Batch

INTERVAL = 0.2  # s between two pictures of a bar
LINES = 5.0  # s between two lines
TAG = re.compile(r"<[^>]*>")
Show = Callable[[str], Callable[[str], None]]
"""Shows some HTML, and gives what replaces it."""


def progress_of(given: Progress | bool | None) -> Progress:
    """What is told how the work goes on.

    Args:
        given: one of one's own; True: bars in a notebook, else lines on standard error; False: nothing; None: bars in a notebook alone.
    """
    if given is not None and not isinstance(given, bool):
        return given
    if given is not False and (show := _display()) is not None:
        return Notebook(show)
    return Notebook(_write, interval=LINES) if given else Quiet()


class Notebook:
    """Bars and remarks below the cell that called.

    Args:
        show: shows some HTML in the notebook.
        clock: [s]
        interval: [s] between two pictures of a bar.
    """

    def __init__(self, show: Show, clock: Callable[[], float] = time.monotonic, interval: float = INTERVAL) -> None:
        self._show, self._clock, self._interval = show, clock, interval

    def note(self, text: str) -> None:
        """A remark."""
        self._show(f"<small>{escape(text)}</small>")

    @contextmanager
    def working(self, text: str) -> Iterator[None]:
        """What takes its time; gone when it has ended."""
        replace = self._show(f"<small>{escape(text)} ...</small>")
        try:
            yield
        finally:
            replace("")

    @contextmanager
    def flights(self, budget: int, flown: int, seconds: float = 0.0, spent: float = 0.0) -> Iterator[Callable[[Batch], None]]:
        """The search of a tuning: flights, or seconds, and the best so far."""
        bar, begun = self._bar("seconds", seconds, spent) if seconds else self._bar("flights", budget, flown), self._clock() - spent

        def follow(batch: Batch) -> None:
            best = batch.best
            words = f"best so far: {percent(best.completion)} of the gates{', confirmed' if best.confirmed else ''}"
            bar.move(min(seconds, self._clock() - begun) if seconds else batch.flights, words)

        with bar:
            yield follow

    @contextmanager
    def pieces(self, unit: str, wanted: int, done: int, *, even: bool = True) -> Iterator[Callable[[str], None]]:  # noqa: ARG002
        """Pieces of work."""
        with self._bar(unit, wanted, done) as bar:
            yield lambda words: bar.move(bar.done + 1, words)

    @contextmanager
    def rounds(self, unit: str, most: int) -> Iterator[Rounds]:
        """Pieces of work that come in rounds, on one bar."""
        with self._bar(unit, most, 0) as bar:

            @contextmanager
            def go_on(_unit: str, wanted: int, done: int) -> Iterator[Callable[[str], None]]:
                bar.total = max(bar.total, bar.done + wanted)
                bar.move(bar.done + done, "")
                yield lambda words: bar.move(bar.done + 1, words)

            yield go_on

    def _bar(self, unit: str, total: float, done: float) -> Bar:
        return Bar(self._show, unit, total, done, self._clock, self._interval)


class Bar(AbstractContextManager["Bar"]):
    """A bar with its count and a few words, drawn a few times a second at most; it stays as it was at the end.

    Args:
        show: shows some HTML.
        unit: what is counted, in the plural.
        total: how many there are in all.
        done: how many of them so far.
        clock: [s]
        interval: [s] between two pictures.
    """

    def __init__(self, show: Show, unit: str, total: float, done: float, clock: Callable[[], float], interval: float) -> None:
        self.total, self.done, self._interval = total, done, interval
        self._unit, self._words, self._clock, self._drawn = unit, "", clock, clock()
        self._replace = show(self._html())

    def move(self, done: float, words: str) -> None:
        """Show how many are done, if it is time."""
        self.done, self._words = done, words
        if self._clock() - self._drawn >= self._interval:
            self._drawn = self._clock()
            self._replace(self._html())

    def __exit__(self, *error: object) -> None:
        self._replace(self._html())

    def _html(self) -> str:
        count = f"{self.done:.0f} of {self.total:.0f} {escape(self._unit)}"
        words = f", {escape(self._words)}" if self._words else ""
        return f'<progress value="{self.done:.0f}" max="{max(self.total, 1):.0f}"></progress> <small>{count}{words}</small>'


def _write(text: str) -> Callable[[str], None]:
    """A line on standard error, and further ones for what would replace it."""

    def say(later: str) -> None:
        if words := unescape(TAG.sub("", later)).strip():
            sys.stderr.write(f"{words}\n")

    say(text)
    return say


def _display() -> Show | None:
    """What shows HTML in the notebook that this runs in; None where it runs in none."""
    interactive = sys.modules.get("IPython")
    shell = None if interactive is None else interactive.get_ipython()
    if shell is None or not hasattr(shell, "kernel"):
        return None
    from IPython.display import HTML, display  # noqa: PLC0415  # pyright: ignore[reportMissingImports]  it is there already

    def show(text: str) -> Callable[[str], None]:
        handle: Any = display(HTML(text), display_id=True)
        return lambda later: handle.update(HTML(later))

    return show
