"""Held: how parameters fare under other conditions, for people."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rich.text import Text

from hotlap.analysis.robustness import Robustness
from hotlap.api.held import all_held, say_held, why
from hotlap.api.wording import share
from hotlap.cli.output import Line, table
from hotlap.feasibility.margins import Margin


def show_robustness(robustness: Sequence[Robustness]) -> Iterator[Line]:
    """A line for each condition, why those fail that are not held, and whether those that were asked for are."""
    yield from table([(one.change, share(one.validation), left(one.margin)) for one in robustness], indent="  ")
    verdict = say_held(robustness)
    if verdict:
        yield Text(f"  {verdict}", style="bold green" if all_held(robustness) else "bold red")
    lines = list(why(robustness))
    yield from ["what fails, and what to try:"] * bool(lines)
    yield from (f"  {line}" for line in lines)


def left(margin: Margin | None) -> str:
    """What is left of the thrust, in words."""
    return "" if margin is None else f"thrust {margin.figure} of what is needed"
