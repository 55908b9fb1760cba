"""Summary: how a tuning or some flights ended, for people."""

from __future__ import annotations

import shlex
from argparse import Namespace
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.text import Text

from hotlap.cli.flying import command_to_fly
from hotlap.cli.output import Line, facts, percent, seconds
from hotlap.core.records import End, Flights, Scores
from hotlap.core.success_rate import Validation
from hotlap.reference.scenario import Scenario
from hotlap.study.result import Result

if TYPE_CHECKING:
    from hotlap.analysis.robustness import Robustness


def summarise(result: Result, holds: Sequence[Robustness], paths: Mapping[str, Any], options: Namespace) -> Iterator[Line]:
    """How a tuning ended, what is where, and how to fly it again."""
    verdict, style = _verdict(result)
    yield Text(f"{result.race}: {verdict}", style=style)
    yield from facts(
        {
            "search flights": str(result.search_flights),
            "flights": f"{result.flights}, re-flights included",
            "lap time": seconds(result.best.lap_time),
            "completion": f"{percent(result.best.completion)} of the gates, over {_count(result.best.flights, 'flight')}",
            "holds in": "" if result.validation is None else share(result.validation),
            "tuner": result.remark,
            "wall time": seconds(result.wall_time, 1),
            "study": paths["study"],
            "parameters": paths["parameters"],
            "report": paths["report"] or "",
            **{"pictures" if i == 0 else " " * i: path for i, path in enumerate(paths["pictures"])},
        }
    )
    if holds:
        yield "will it hold?"
        yield from facts({hold.change: share(hold.validation) for hold in holds})
    yield f"fly it again: {command_to_fly(options, Path(paths['study']))}"
    if not result.best.confirmed and result.goal != "none":
        yield f"what may be in the way: {shlex.join(['hotlap', 'check', options.race])}"


def dump_holds(holds: Sequence[Robustness]) -> list[dict[str, Any]]:
    """As plain JSON."""
    plain = []
    for hold in holds:
        (low, high), validation = hold.validation.interval, hold.validation
        counts = {"flights": validation.flights, "successes": validation.successes, "rate": validation.rate}
        plain.append({"change": hold.change, **counts, "low": low, "high": high})
    return plain


def describe_flights(scenario: Scenario, flights: Flights, scores: Scores) -> Iterator[Line]:
    """How some flights of the same parameters ended."""
    complete = Validation(len(scores), int(scores.complete.sum()))
    laps = scores.lap_time[scores.complete]
    yield f"{scenario.race.name}: {_count(len(scores), 'flight')}"
    yield from facts(
        {
            "all gates in": share(complete),
            "completion": f"{percent(float(scores.completion.mean()))} of the gates, on average",
            "lap time": f"{laps.mean():.2f} s on average, {laps.min():.2f} to {laps.max():.2f} s" if len(laps) else "-",
            "mean error": f"{scores.mean_error.mean():.2f} m from the reference",
            "largest error": f"{scores.max_error.max():.2f} m",
        }
    )
    yield from (f"  {line}" for line in _ends(flights))


def share(validation: Validation) -> str:
    """A rate with its interval: 97 % of 200 flights [94, 99]."""
    low, high = validation.interval
    return f"{percent(validation.rate)} of {_count(validation.flights, 'flight')} [{100 * low:.0f}, {100 * high:.0f}]"


def _verdict(result: Result) -> tuple[str, str]:
    """In a few words, with their colour."""
    if result.goal == "none":
        return f"budget of {result.flights} flights spent, no goal was set", "bold"
    if result.best.confirmed:
        return f"{result.goal} confirmed", "bold green"
    return f"{result.goal} NOT confirmed in {result.flights} flights; the best so far is kept", "bold red"


def _ends(flights: Flights) -> Iterator[str]:
    """Where flights ended that did not finish, by gate."""
    for end, verb in ((End.MISSED, "missed"), (End.CRASHED, "crashed before")):
        counts = np.bincount(flights.gates_passed[flights.end == end])
        for gate in np.flatnonzero(counts).tolist():
            yield f"{counts[gate]} {verb} gate {gate + 1}"


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
