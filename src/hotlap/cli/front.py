"""`hotlap tune RACE --goal lap_time --hold ...`: the fastest plan that holds under conditions, and what bolder and calmer ones stand."""

from __future__ import annotations

import json
from argparse import Namespace
from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from rich.text import Text

from hotlap.analysis.front import HELD, Point, front, judge_under_conditions, most_plans, search, try_under_conditions, winner
from hotlap.analysis.resumable import ResumableJobs
from hotlap.analysis.severity import FALLS
from hotlap.api.wording import percent, seconds
from hotlap.cli.output import Line, finite, note, present
from hotlap.cli.planned_race import RACE_FILE, PlannedRace, write_planned_race
from hotlap.cli.progress import follow_rounds
from hotlap.core.counts import count
from hotlap.core.success_rate import Validation
from hotlap.files.descriptions import PARAMETERS_FILE
from hotlap.race.conditions import Condition
from hotlap.race.race import Race
from hotlap.report.front_chart import Tried, front_chart
from hotlap.report.pictures import save
from hotlap.system.text_files import replace
from hotlap.tuning.goal_forms import LAP_TIME
from hotlap.tuning.loop import TuningSettings

FRONT_FILE, FOLDER, PICTURES = "front.json", "front", ("front.png", "front.svg")
PLANS = "plans"  # what the progress counts


def run(
    options: Namespace,
    race: Race,
    folder: Path,
    tuning: tuple[str, TuningSettings],
    conditions: tuple[Condition, ...],
) -> int:
    """Search plans, write the front and the fastest that holds: 1 where none holds all that was asked for.

    Args:
        options: of the command line.
        race: whose plan is looked for.
        folder: of everything that is written.
        tuning: tuner and settings.
        conditions: what the plan is to hold under.
    """
    with follow_rounds(PLANS, most_plans(race)) as progress:
        each = partial(ResumableJobs(folder, progress=progress, note=note).each, PLANS)
        points = search(race, *tuning, conditions, partial(each, work=try_under_conditions))
        best, points = winner(race, *tuning, conditions, points, partial(each, work=judge_under_conditions))
    _remove_former(folder)
    stair, known = front(points), {"seed": tuning[1].seed, "hold": options.hold}
    places = {
        point: write_planned_race(
            folder / FOLDER / f"{point.lap:.3f}s",
            race,
            f"{race.name}-{point.lap:.3f}s",
            point.plan_settings,
            point.parameters,
            {**known, "stands": point.standing.severity, "lap_time": point.lap},
        )
        for point in stair
    }
    written = None
    if best is not None:
        remarks = {**known, "lap_time": best.lap, "validated_rate": min(best.standing.nominal, *best.standing.rates)}
        written = write_planned_race(folder, race, f"{race.name}-fastest", best.plan_settings, best.parameters, remarks)
    document = _document(race, options.hold, conditions, best, stair, places, tuning[1])
    replace(folder / FRONT_FILE, json.dumps(finite(document), indent=2, allow_nan=False) + "\n")
    pictures = _draw(folder, race, conditions, points, stair, best)
    present(as_json=options.json, document=document, lines=_lines(race, conditions, best, written, stair, places, pictures))
    return 0 if best is not None else 1


def _remove_former(folder: Path) -> None:
    """Remove races and parameters that an earlier search in this folder has written, perhaps under other conditions; nothing else."""
    for place in [folder, *(folder / FOLDER).glob("*s")]:
        for name in (RACE_FILE, PARAMETERS_FILE):
            (place / name).unlink(missing_ok=True)
        if place != folder:
            with suppress(OSError):  # something else is in it
                place.rmdir()


def _document(
    race: Race,
    hold: str,
    conditions: Sequence[Condition],
    best: Point | None,
    stair: Sequence[Point],
    places: dict[Point, PlannedRace],
    settings: TuningSettings,
) -> dict[str, Any]:
    """Everything that was found, as plain values."""
    return {
        "race": race.name,
        "goal": LAP_TIME,
        "hold": hold,
        "lap_time": None if best is None else best.lap,
        "rates": None if best is None else _rates(best, conditions, settings.validation),
        "plan": None if best is None else _plan(best),
        "front": [
            {
                "lap_time": point.lap,
                "stands": point.standing.severity,
                "plan": _plan(point),
                "rates": _rates(point, conditions, 0),
                "race_file": str(places[point].race),
                "parameters": str(places[point].parameters),
            }
            for point in stair
        ],
    }


def _plan(point: Point) -> dict[str, Any]:
    """Settings of a plan."""
    return dict(vars(point.plan_settings))


def _rates(point: Point, conditions: Sequence[Condition], flights: int) -> list[dict[str, Any]]:
    """Share of successes under each condition; with an interval where the flights were flown for that."""
    named = zip(["as tuned", *(condition.name for condition in conditions)], [point.standing.nominal, *point.standing.rates], strict=True)
    found = []
    for change, rate in named:
        interval = dict(zip(("low", "high"), Validation(flights, round(rate * flights)).interval, strict=True)) if flights else {}
        found.append({"change": change, "rate": rate, **interval})
    return found


def _draw(
    folder: Path, race: Race, conditions: Sequence[Condition], points: Sequence[Point], stair: Sequence[Point], best: Point | None
) -> list[Path]:
    """The picture of the front, in two formats; none where no plan held at all."""
    flown = [point for point in points if point.standing.severity > FALLS]
    if not flown:
        return []
    tried = [
        Tried(one.lap, one.standing.severity, one in stair, best is not None and one.plan_settings == best.plan_settings) for one in flown
    ]
    title = (
        f"{race.name}: no plan stands all that was asked for"
        if best is None
        else f"{race.name}: {best.lap:.2f} s stands all that was asked for"
    )
    figure = front_chart(tried, title, f"100 %: {', '.join(condition.name for condition in conditions)}")
    return [save(folder / name, figure) for name in PICTURES]


def _lines(
    race: Race,
    conditions: Sequence[Condition],
    best: Point | None,
    written: PlannedRace | None,
    stair: Sequence[Point],
    places: dict[Point, PlannedRace],
    pictures: Sequence[Path],
) -> Iterator[Line]:
    """The same for people."""
    asked = count(len(conditions), "condition")
    if best is None or written is None:
        yield Text(f"{race.name}: no plan was found that holds under {asked} in {percent(HELD)} of the flights", style="bold red")
    else:
        yield Text(f"{race.name}: {seconds(best.lap)} is the soonest plan that holds under {asked}", style="bold green")
        named = zip(["as tuned", *(condition.name for condition in conditions)], [best.standing.nominal, *best.standing.rates], strict=True)
        for change, rate in named:
            yield f"  {change:<28} {percent(rate)}"
    yield "lap time against what it stands (100 %: all that was asked for):"
    for point in stair:
        yield f"  {point.lap:7.3f} s  {100 * point.standing.severity:4.0f} %  {places[point].race.parent}"
    for path in pictures[:1]:
        yield f"picture: {path}"
    if written is not None:
        yield f"fly it again: {written.again}"
        yield f"a study of it, with its page: {written.study}"
    elif not stair:
        note(f"hotlap: {race.name}: no plan passes every gate in {percent(HELD)} of the flights, under no condition at all")
