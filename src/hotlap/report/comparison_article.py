"""Article of a comparison of tuners: tables with the pictures; apart from the pictures, as it is written even where none can be drawn."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from hotlap.analysis.comparison import Run
from hotlap.analysis.comparison_table import Row, cells_of, held_cells_of, overall, rows_of
from hotlap.report.article import Article

CAPTIONS = {
    "curves": "Completion of the best candidate so far over flights, median of all seeds",
    "profile": "Share of all races and seeds that were solved within a multiple of the fastest tuner's flights",
}


def compose_article(runs: Sequence[Run], pictures: Sequence[Path], source: str, command: str) -> Article:
    """The article of a comparison: tables over all races and race by race, with the pictures.

    Args:
        runs: at least one.
        pictures: files that were drawn of the runs.
        source: name of the file with the runs, in the folder of the article.
        command: shell command that does the comparison again.
    """
    races, seeds = list(dict.fromkeys(run.race for run in runs)), len({run.seed for run in runs})
    article = Article(f"Tuners compared on {', '.join(races) if len(races) <= 3 else f'{len(races)} races'}", source=source)
    article.say(
        f"Every tuner began at the same first guess and met the same noise, {seeds} {'seed' if seeds == 1 else 'seeds'} on each race. "
        "*Confirmed*: the share of runs that found a controller which passed its re-flights. *Validated*: the share of fresh flights in "
        "which that controller then met the goal. In brackets: 95 % intervals, for flights the quartiles."
    )
    article.head("Over all races")
    _add_table(article, overall(runs))
    for path in pictures:
        article.picture(path, CAPTIONS.get(path.stem, path.stem))
    article.head("Race by race")
    _add_table(article, rows_of(runs))
    if any(run.held for run in runs):
        article.head("Will it hold?")
        article.say(
            "The result of each run flown under the conditions that were asked for; share of flights that met the goal, mean over runs."
        )
        for rows in (overall(runs), rows_of(runs)):
            heads, *body = held_cells_of(rows)
            article.table(heads, body)
    article.head("Run it again")
    article.say(f"`{command}`")
    return article


def _add_table(article: Article, rows: Sequence[Row]) -> None:
    """Add rows as a table, without columns that are empty."""
    columns = [column for column in zip(*cells_of(rows), strict=True) if any(column[1:])]
    heads, *body = zip(*columns, strict=True)
    article.table(heads, body)
