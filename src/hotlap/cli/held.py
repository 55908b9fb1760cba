"""Held: how parameters fare under other conditions, for people."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rich.text import Text

from hotlap.analysis.remedies import Failures, why
from hotlap.analysis.robustness import Robustness
from hotlap.api.held import all_held, say_held
from hotlap.api.wording import share
from hotlap.cli.output import Line, table
from hotlap.feasibility.margins import Margin


def show_robustness(robustness: Sequence[Robustness]) -> Iterator[Line]:
    """A line for each condition, and whether those that were asked for are held."""
    yield from table([(one.change, share(one.validation), left(one.margin)) for one in robustness], indent="  ")
    verdict = say_held(robustness)
    if verdict:
        yield Text(f"  {verdict}", style="bold green" if all_held(robustness) else "bold red")


def show_advice(failures: Failures, advice: Sequence[str]) -> Iterator[Line]:
    """Why flights fail, and one list of what to try."""
    for title, lines in (("why flights fail:", list(why(failures))), ("what to try:", advice)):
        yield from [title] * bool(lines)
        yield from (f"  {line}" for line in lines)


def left(margin: Margin | None) -> str:
    """What is left of the thrust, in words."""
    return "" if margin is None else f"thrust {margin.figure} of what is needed"
