"""`hotlap tune RACE --goal lap_time`: the fastest plan that can be flown, and the parameters that fly it, for people."""

from __future__ import annotations

from collections.abc import Iterator

from hotlap.api.fastest import FastestResult
from hotlap.api.front import FrontResult
from hotlap.cli import front
from hotlap.cli.output import Line, facts, note, present
from hotlap.core.counts import count


def present_result(result: FastestResult | FrontResult, *, as_json: bool) -> int:
    """Say what a search for plans has found: 1 where no plan is fit to be flown."""
    lines = front.summarise(result) if isinstance(result, FrontResult) else summarise(result)
    present(as_json=as_json, document=result.to_dict(), lines=lines)
    return 0 if result.found else 1


def summarise(result: FastestResult) -> Iterator[Line]:
    """What was found, and how to fly it again."""
    if result.chosen is None or result.plan_settings is None or result.validation is None:
        note(f"hotlap: {result.race}: {result.verdict}")
        return
    validation, written = result.validation, result.chosen
    low, high = validation.interval
    yield f"{result.race}: {result.verdict}"
    yield from facts(
        {
            "holds in": f"{validation.successes} of {count(validation.flights, 'flight')} ({100 * low:.0f} to {100 * high:.0f} %)",
            "plan": result.plan_settings.key,
            "largest speed": f"{written.scenario.reference.max_speed:.1f} m/s",
            "race": str(written.race),
            "parameters": str(written.parameters),
        }
    )
    yield f"fly it again: {written.again}"
    yield f"a study of it, with its page: {written.study}"
