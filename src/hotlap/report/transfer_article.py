"""Article of a transfer: how the same parameters fly in several worlds, with tables and charts."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from hotlap.analysis.transfer import DEFAULT, STARTING, TransferFlight, TransferRow, metres
from hotlap.core.counts import count
from hotlap.report.article import Article
from hotlap.system.journal import Journal

LATER = f"largest error after {STARTING:g} s"
HEADS = ("world", "parameters", "all gates", "mean error [m]", f"{LATER} [m]", "lap [s]")
FEW = 5  # flights whose errors are written one by one
CAPTIONS = (
    f"Tracking error of all control steps of all flights: quartiles and median, 5 and 95 %, largest after {STARTING:g} s",
    "Tracking error over time, a line for each flight",
)


def compose_article(race: str, rows: Sequence[TransferRow], pictures: Sequence[Path], command: str) -> Article:
    """The article of a transfer.

    Args:
        race: its name.
        rows: of all worlds, that where the parameters were tuned first.
        pictures: both charts; none where they could not be drawn.
        command: shell command that does the same again; "" where there is none.
    """
    home, *others = dict.fromkeys(row.world for row in rows)
    article = Article(f"{race}: flown elsewhere", source=Journal.file)
    everywhere = f"{', '.join([home, *others[:-1]])} and {others[-1]}"
    article.say(
        f"Parameters that were tuned in the world *{home}*, and the default ones, flown in {everywhere} "
        f"with the same noise, {count(len(rows[0].flights), 'flight')} each. The error is the distance from the clocked reference; flights "
        "go on after a missed gate, to their end or to a crash. Each begins beside its reference, as far as the noise has drawn: the "
        f"largest error is looked for from {STARTING:g} s on. *Mean* and *largest error*: of each flight; *lap*: the mean of the "
        "flights that passed all gates, a dash where none did."
    )
    add_results(article, rows, pictures)
    article.head("What it says")
    article.say(
        "The plan, the controller and what it knows of the vehicle are the same everywhere; all else is the world's own. Nothing was tuned "
        f"but in {home}. A result that holds in a world that others have written does not rest on the mistakes of the first. None of them "
        "is a real drone."
    )
    if command:
        article.head("Run it again")
        article.say(f"`{command}`")
    return article


def add_results(article: Article, rows: Sequence[TransferRow], pictures: Sequence[Path]) -> None:
    """Add the table, what changed by tuning, the charts, and how flights ended that did not finish."""
    article.table(HEADS, cells_of(rows))
    for line in changes(rows):
        article.say(line)
    for path, caption in zip(pictures, CAPTIONS, strict=False):
        article.picture(path, caption)
    ends = list(endings(rows))
    if ends:
        article.head("Flights that missed a gate")
        article.table(("world", "parameters", "ended"), ends)


def cells_of(rows: Sequence[TransferRow]) -> list[list[str]]:
    """A row of cells for each, in the order of `HEADS`."""
    return [
        [
            row.world,
            row.label,
            f"{row.complete.successes} of {row.complete.flights}",
            errors_of(row, lambda flight: flight.mean_error),
            errors_of(row, lambda flight: flight.later_error),
            f"{row.lap_time:.2f}" if math.isfinite(row.lap_time) else "-",
        ]
        for row in rows
    ]


def errors_of(row: TransferRow, quantity: Callable[[TransferFlight], float]) -> str:
    """An error of each flight; of many their mean and range."""
    values = [quantity(flight) for flight in row.flights]
    if len(values) <= FEW:
        return " / ".join(map(metres, values))
    finite = [value for value in values if math.isfinite(value)]
    return f"{metres(float(np.mean(finite)))} ({metres(min(finite))} to {metres(max(finite))})" if finite else "-"


def changes(rows: Sequence[TransferRow]) -> Iterator[str]:
    """For each world, and each set of parameters beside the default one, a sentence: what tuning changed there.

    Errors are compared where all flights are whole.
    """
    defaults = {row.world: row for row in rows if row.label == DEFAULT}
    for tuned in rows:
        default = defaults.get(tuned.world)
        if default is None or tuned is default:
            continue
        if tuned.complete.rate == default.complete.rate == 1:
            mean = _change(tuned.mean_error, default.mean_error)
            largest = _change(tuned.later_error, default.later_error)
            yield f"{tuned.world}: {tuned.label} against default, mean error {mean}, {LATER} {largest} (means of the flights)"
        else:
            mine, others = tuned.complete, default.complete
            when_tuned = f"{mine.successes} of {count(mine.flights, 'flight')} pass every gate when {tuned.label}"
            yield f"{tuned.world}: {when_tuned}, {others.successes} of {others.flights} with the default parameters"


def endings(rows: Sequence[TransferRow]) -> Iterator[list[str]]:
    """World, parameters and "2 missed gate 3, 1 hit the floor before gate 5" where flights did not finish."""
    for row in rows:
        ends = Counter(flight.ending for flight in row.flights if not flight.complete)
        if ends:
            yield [row.world, row.label, ", ".join(f"{number} {words}" for words, number in ends.most_common())]


def _change(now: float, before: float) -> str:
    """Relative change in per cent, with its sign."""
    return f"{100 * (now / before - 1):+.0f} %" if math.isfinite(now) and before > 0 else "-"
