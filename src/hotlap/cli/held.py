"""Held: how parameters fare under other conditions, for people."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rich.text import Text

from hotlap.analysis.robustness import Robustness
from hotlap.api.held import all_held, say_held
from hotlap.api.wording import share
from hotlap.cli.output import Line, facts


def show_robustness(robustness: Sequence[Robustness]) -> Iterator[Line]:
    """A line for each condition, and one that says whether those that were asked for are held."""
    yield from facts({one.change: share(one.validation) for one in robustness})
    verdict = say_held(robustness)
    if verdict:
        yield Text(f"  {verdict}", style="bold green" if all_held(robustness) else "bold red")
