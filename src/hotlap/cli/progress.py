"""Progress: how a tuning goes on, to standard error: a bar on a terminal, else a line every few seconds."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from itertools import count
from typing import TYPE_CHECKING

from rich.progress import BarColumn, MofNCompleteColumn, Progress, ProgressColumn, Task, TaskID, TextColumn, TimeRemainingColumn
from rich.text import Text

from hotlap.api.rates import Pace as FlightPace
from hotlap.api.rates import Rate
from hotlap.api.wording import percent
from hotlap.cli.log import LOG
from hotlap.cli.output import Plain, note, working
from hotlap.core.success_rate import Validation

if TYPE_CHECKING:
    from hotlap.tuning.candidate import Candidate
    from hotlap.tuning.loop import Batch

INTERVAL = 5.0  # s between lines


@contextmanager
def follow(budget: int, flown: int, seconds: float = 0.0, spent: float = 0.0) -> Iterator[Callable[[Batch], None]]:
    """Show the batches of a tuning.

    Args:
        budget: flights at most.
        flown: flights before this run of the program.
        seconds: of wall time at most; 0: flights are counted, not time.
        spent: [s] of them before this run of the program.

    Yields:
        What to call after each batch.
    """
    console = Plain(stderr=True)
    if not console.is_terminal:
        yield Lines(budget, flown, seconds=seconds, spent=spent)
        return
    state = TextColumn("{task.fields[state]}", markup=False)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), state, TimeLeft())
    with Progress(*columns, console=console, transient=True) as progress:
        bar = Bar(progress, budget, flown, seconds, spent)
        logged = LOG.isEnabledFor(logging.INFO)
        yield Both(bar, Lines(budget, flown, seconds=seconds, spent=spent, say=LOG.info)) if logged else bar


@contextmanager
def follow_pieces(unit: str, wanted: int, done: int, *, even: bool = True) -> Iterator[Callable[[str], None]]:
    """Show how many pieces of some work are done.

    Args:
        unit: what they are, in the plural.
        wanted: how many in all.
        done: how many of them before this run of the program.
        even: whether each takes about as long as the others, so that the bar can tell pace and time left; else the words do.

    Yields:
        What to call with a few words on each piece that has ended.
    """
    console = Plain(stderr=True)
    if not console.is_terminal:
        yield Tally(unit, wanted, done).say
        return
    state = TextColumn("{task.fields[state]}", markup=False)
    pace_and_time = (Pace(), TimeRemainingColumn()) if even else ()
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), *pace_and_time, state)
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task(unit, total=wanted, completed=done, state="")
        yield lambda words: _advance(progress, task, words)


@contextmanager
def follow_rounds(unit: str, most: int = 0) -> Iterator[Callable[[str, int, int], AbstractContextManager[Callable[[str], None]]]]:
    """Show pieces of work that come in rounds as one: the next round is known when the last one is done.

    Args:
        unit: what the pieces are, in the plural.
        most: pieces at most, of all rounds together; 0: nobody knows.

    Yields:
        What shows a round, as `follow_pieces` does; it counts on from the round before.
    """
    console = Plain(stderr=True)
    if not console.is_terminal:
        yield Tally(f"{unit} at most" if most else unit, most, 0).go_on
        return
    state = TextColumn("{task.fields[state]}", markup=False)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), Pace(), TimeRemainingColumn(), state)
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.tasks[progress.add_task(unit, total=most, state="")]

        @contextmanager
        def go_on(_unit: str, wanted: int, done: int) -> Iterator[Callable[[str], None]]:
            """Count a round on the bar of all."""
            progress.update(task.id, total=max(most, task.completed + wanted), completed=task.completed + done)
            yield lambda words: _advance(progress, task.id, words)

        yield go_on


@contextmanager
def follow_stages(wanted: int) -> Iterator[Callable[[str], None]]:
    """Show which stage of some work is under way: the bar counts those behind it.

    Args:
        wanted: how many in all.

    Yields:
        What to call with a few words when a stage begins.
    """
    console = Plain(stderr=True)
    if not console.is_terminal:
        yield note
        return
    state = TextColumn("{task.fields[state]}", markup=False)
    with Progress(BarColumn(), MofNCompleteColumn(), state, TimeRemainingColumn(), console=console, transient=True) as progress:
        task, behind = progress.add_task("stages", total=wanted, state=""), count()
        yield lambda words: progress.update(task, completed=next(behind), state=words)


class Terminal:
    """The progress of the calls of `hotlap.api`, on standard error; see `hotlap.api.progress.Progress`."""

    note = staticmethod(note)
    working = staticmethod(working)
    flights = staticmethod(follow)
    pieces = staticmethod(follow_pieces)
    rounds = staticmethod(follow_rounds)


TERMINAL = Terminal()


class Bar:
    """The bar of a search.

    Args:
        progress: that shows it.
        budget, flown, seconds, spent: as of `follow`.
    """

    def __init__(self, progress: Progress, budget: int, flown: int, seconds: float, spent: float) -> None:
        self._progress, self._budget, self._reached, self._seconds, self._spent = progress, budget, flown, seconds, spent
        self._total, done, unit = (round(seconds), round(spent), "seconds") if seconds else (budget, flown, "flights")
        self._task, self._begun = progress.add_task(unit, total=self._total, completed=done, state="", left=""), time.monotonic()
        self._rate, self._pace, self._best = Rate(flown), FlightPace(), ""

    def __call__(self, batch: Batch) -> None:
        """Move the bar, and report above it validations that failed."""
        self._reached, self._best = batch.flights, f"{describe(batch.best)}, "
        done = min(self._total, round(self._spent + time.monotonic() - self._begun)) if self._seconds else batch.flights
        self._progress.update(self._task, completed=done, state=f"{self._best}{self._rate(batch.flights)}")
        if self._pace.flown:
            self._tell()
        for validation in batch.failed_validations:
            self._progress.console.print(describe_failure(validation), markup=False, highlight=False)

    def flown(self, _ended: int) -> None:
        """A flight of a simulator has ended; the batch that it is of goes on."""
        self._pace.count()
        self._tell()

    def _tell(self) -> None:
        """How fast flights are, and how long the rest will take, by those that were flown."""
        speed = self._pace.words(0)
        left = "" if self._seconds else self._pace.words(self._budget - self._reached, "at most ").partition(", ")[2]
        self._progress.update(self._task, state=f"{self._best}{count_of(self._pace.flown)}, {speed}", left=left)


class Both:
    """A bar for people, and lines for the log.

    Args:
        bar, lines: that hear of everything.
    """

    def __init__(self, bar: Bar, lines: Lines) -> None:
        self._each = (bar, lines)

    def __call__(self, batch: Batch) -> None:
        """A batch has ended."""
        for one in self._each:
            one(batch)

    def flown(self, ended: int) -> None:
        """A flight has ended."""
        for one in self._each:
            one.flown(ended)


class TimeLeft(TimeRemainingColumn):
    """How long it will take, by the speed of the bar where nothing better is known."""

    def render(self, task: Task) -> Text:
        """What is known."""
        return Text(task.fields["left"]) if task.fields["left"] else super().render(task)


def _advance(progress: Progress, task: TaskID, words: str) -> None:
    """Move a bar by one piece."""
    LOG.debug("ended: %s", words)
    progress.update(task, advance=1, state=words)


class Pace(ProgressColumn):
    """How fast pieces of work are done."""

    def render(self, task: Task) -> Text:
        """As many in a second, or in a minute where that is less than one."""
        return Text(pace(task.finished_speed or task.speed))


def pace(speed: float | None) -> str:
    """A rate for people.

    Args:
        speed: [1/s]; None before there is any.
    """
    if not speed:
        return "-/s"
    return f"{speed:.3g}/s" if speed >= 1 else f"{60 * speed:.3g}/min"


class Tally:
    """Pieces of work for logs: a line every few seconds, and one at the end.

    Args:
        unit: what they are, in the plural.
        wanted: pieces in all.
        done: pieces so far.
        clock: [s]
    """

    def __init__(self, unit: str, wanted: int, done: int, clock: Callable[[], float] = time.monotonic) -> None:
        self._unit, self._wanted, self._done, self._clock, self._last = unit, wanted, done, clock, clock()

    @contextmanager
    def go_on(self, _unit: str, wanted: int, done: int) -> Iterator[Callable[[str], None]]:
        """Count further pieces, so many of which are done."""
        self._wanted, self._done = max(self._wanted, self._done + wanted), self._done + done
        yield self.say

    def say(self, words: str) -> None:
        """Count one, and say so, if it is time or the last."""
        self._done += 1
        if self._done == self._wanted or self._clock() - self._last >= INTERVAL:
            self._last = self._clock()
            note(f"{self._done} of {self._wanted} {self._unit}, now {words}")


class Lines:
    """Progress for logs: one line every few seconds, and one when the search has ended.

    Args:
        budget: flights at most.
        flown: flights so far.
        clock: [s]
        seconds: of wall time at most; 0: flights are counted, not time.
        spent: [s] of them so far.
        say: what takes a line.
    """

    def __init__(
        self,
        budget: int,
        flown: int,
        clock: Callable[[], float] = time.monotonic,
        *,
        seconds: float = 0.0,
        spent: float = 0.0,
        say: Callable[[str], None] = note,
    ) -> None:
        self._budget, self._clock, self._seconds, self._say = budget, clock, seconds, say
        self._rate, self._last = Rate(flown, clock), clock()
        self._begun, self._pace, self._reached_flights, self._best = self._last - spent, FlightPace(clock), flown, ""

    def flown(self, _ended: int) -> None:
        """A flight of a simulator has ended; the batch that it is of goes on."""
        self._pace.count()
        if self._clock() - self._last >= INTERVAL:
            self._last = self._clock()
            left = 0 if self._seconds else self._budget - self._reached_flights
            self._say(
                f"{self._reached(self._reached_flights)}{self._best}, {count_of(self._pace.flown)}, {self._pace.words(left, 'at most ')}"
            )

    def __call__(self, batch: Batch) -> None:
        """Say how it stands, if it is time."""
        self._reached_flights, self._best = batch.flights, f", best so far: {describe(batch.best)}"
        for validation in batch.failed_validations:
            self._say(describe_failure(validation))
        if batch.done or self._clock() - self._last >= INTERVAL:
            self._last = self._clock()
            speed = self._pace.words(0) if self._pace.flown else self._rate(batch.flights)
            self._say(f"{self._reached(batch.flights)}{self._best}, {speed}")

    def _reached(self, flights: int) -> str:
        """How far it is, of what there is."""
        if not self._seconds:
            return f"{flights} of {self._budget} flights"
        return f"{self._last - self._begun:.0f} of {self._seconds:.0f} s, {flights} flights"


def count_of(flown: int) -> str:
    """Flights of all kinds that were flown, re-flights and validations too."""
    return f"{flown} flown with all re-flights"


def describe(best: Candidate) -> str:
    """The best candidate in few words."""
    cost = f", cost {best.cost:.3g}" if math.isfinite(best.cost) else ""
    return f"completion {percent(best.completion)}{cost}{', confirmed' if best.confirmed else ''}"


def describe_failure(validation: Validation) -> str:
    """A confirmed candidate whose validation failed."""
    return f"a confirmed candidate held in {percent(validation.rate)} of {validation.flights} flights only; the search goes on"
