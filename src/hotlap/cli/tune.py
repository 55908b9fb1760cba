"""`hotlap tune RACE`: the main job: tune, confirm, validate, save, report."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Iterator

from rich.text import Text

from hotlap.api.asked import command_line
from hotlap.api.checking import check
from hotlap.api.tuned import TuningResult
from hotlap.api.tuning import tune
from hotlap.api.wording import percent, seconds, share
from hotlap.cli.held import show_advice, show_robustness
from hotlap.cli.options import arguments_of
from hotlap.cli.output import Line, facts, present
from hotlap.cli.progress import TERMINAL
from hotlap.core.counts import count
from hotlap.core.errors import InputError
from hotlap.study.tried_plan import describe_choice
from hotlap.tuning.goal import Quantity
from hotlap.tuning.goal_forms import LAP_TIME


def run(options: Namespace) -> int:
    """Tune, and say how it ended: 1 where the goal was not confirmed within the budget."""
    try:
        tuned = tune(**arguments_of(tune, options), progress=TERMINAL)
    except InputError as error:
        if error.key != "goal" or error.source:
            raise
        raise InputError("", error.key, f"{error.reason}; {LAP_TIME} looks for the fastest plan") from None
    if not isinstance(tuned, TuningResult):
        from hotlap.cli import fastest  # noqa: PLC0415  the search for plans is work of its own

        return fastest.present_result(tuned, as_json=options.json)
    present(as_json=options.json, document=tuned.to_dict(), lines=summarise(tuned, _check(options)))
    return 0 if tuned.confirmed or tuned.result.goal == Quantity.NONE else 1


def _check(options: Namespace) -> str:
    """The command that says what may be in the way of what was tuned."""
    return command_line(check, {"file": options.race, **{name: getattr(options, name) for name in ("reference", "segments", "controller")}})


def summarise(tuned: TuningResult, further: str) -> Iterator[Line]:
    """How a tuning ended, what is where, and how to fly it again.

    Args:
        tuned: how it ended.
        further: the command that says what may be in the way.
    """
    result, no_goal = tuned.result, tuned.result.goal == Quantity.NONE
    style = "bold" if no_goal else "bold green" if tuned.confirmed else "bold red"
    kept = "" if tuned.kept_guess is None else f"; {tuned.kept_guess.words}"
    yield Text(f"{result.race}: {tuned.verdict}{kept}", style=style)
    yield from facts(
        {
            "plan": describe_choice(tuned.plans),
            "search flights": str(result.search_flights),
            "flights": f"{result.flights}, re-flights included",
            "chosen by": f"{count(result.selection_flights, 'flight')} more" if result.selection_flights else "",
            "lap time": seconds(result.best.lap_time),
            "completion": f"{percent(result.best.completion)} of the gates, over {count(result.best.flights, 'flight')}",
            "holds in": "" if result.validation is None else share(result.validation),
            "tuner": result.remark,
            "search time": seconds(result.wall_time, 1),
            "whole time": f"{seconds(tuned.wall_time, 1)}, with planning, compiling and the report",
            "study": str(tuned.folder),
            "parameters": str(tuned.parameters),
            "report": str(tuned.report or ""),
        }
    )
    if tuned.robustness:
        yield "will it hold?"
        yield from show_robustness(tuned.robustness)
    yield from show_advice(tuned.failures, tuned.advice)
    yield f"fly it again: {tuned.again}"
    if not tuned.confirmed and not no_goal:
        yield f"what may be in the way: {further}"
