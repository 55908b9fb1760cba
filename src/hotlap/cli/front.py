"""`hotlap tune RACE --goal lap_time --hold ...`: the fastest plan that holds, and what bolder and calmer ones stand, for people."""

from __future__ import annotations

from collections.abc import Iterator

from rich.text import Text

from hotlap.analysis.front import HELD
from hotlap.api.front import FrontResult
from hotlap.api.wording import percent
from hotlap.cli.output import Line, note


def summarise(result: FrontResult) -> Iterator[Line]:
    """What was found, what it stands, and how to fly it again."""
    yield Text(f"{result.race}: {result.verdict}", style="bold green" if result.found else "bold red")
    if result.best is not None:
        yield from (f"  {change:<28} {percent(rate)}" for change, rate in result.rates_of(result.best).items())
    yield "lap time against what it stands (100 %: all that was asked for):"
    for point, place in zip(result.front, result.places, strict=True):
        yield f"  {point.lap:7.3f} s  {100 * point.standing.severity:4.0f} %  {place.race.parent}"
    for path in result.pictures[:1]:
        yield f"picture: {path}"
    if result.chosen is not None:
        yield f"fly it again: {result.chosen.again}"
        yield f"a study of it, with its page: {result.chosen.study}"
    elif not result.front:
        note(f"hotlap: {result.race}: no plan passes every gate in {percent(HELD)} of the flights, under no condition at all")
