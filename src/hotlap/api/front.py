"""Front: what `tune` finds for the goal lap_time under conditions: the fastest plan that holds, and what bolder and calmer ones stand."""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hotlap.analysis.front import HELD, Point, front, judge_under_conditions, most_plans, search, try_under_conditions, winner
from hotlap.analysis.resumable import ResumableJobs
from hotlap.analysis.severity import FALLS
from hotlap.api.asked import Asked
from hotlap.api.outcome import Outcome
from hotlap.api.planned_race import RACE_FILE, PlannedRace, write_planned_race
from hotlap.api.wording import percent, seconds
from hotlap.core.counts import count
from hotlap.core.finite import finite
from hotlap.core.success_rate import Validation
from hotlap.files.descriptions import PARAMETERS_FILE
from hotlap.race.conditions import Condition
from hotlap.race.race import Race
from hotlap.system.engine import Engine
from hotlap.system.text_files import replace
from hotlap.tuning.goal_forms import LAP_TIME
from hotlap.tuning.loop import TuningSettings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FRONT_FILE, FOLDER, PICTURES = "front.json", "front", ("front.png", "front.svg")
PLANS = "plans"  # what the progress counts


@dataclass(frozen=True, repr=False)
class FrontResult(Outcome):
    """Lap time against what it stands, and the fastest plan that holds under everything that was asked for.

    Attributes:
        race: its name.
        hold: the conditions, as they were asked for.
        conditions: the same, each by itself.
        best: the fastest plan that holds under all of them, also in flights that it was not chosen by; None where none does.
        chosen: where its race and parameters lie; None likewise.
        front: the plans that no faster one equals in what it stands, the soonest first: `lap`, `standing`, `plan_settings`, `parameters`.
        places: where the race and the parameters of each of these lie, in the same order.
        points: all plans that could be flown, the soonest first.
        validation: flights under each condition by which `best` was judged.
        folder: of everything that was written.
        document: the file with all that `to_dict` has.
        pictures: of the front; none where no plan holds at all.
    """

    race: str
    hold: str
    conditions: tuple[Condition, ...]
    best: Point | None
    chosen: PlannedRace | None
    front: tuple[Point, ...]
    places: tuple[PlannedRace, ...]
    points: tuple[Point, ...]
    validation: int
    folder: Path
    document: Path
    pictures: tuple[Path, ...] = ()

    @property
    def found(self) -> bool:
        """Whether a plan holds under everything that was asked for."""
        return self.best is not None

    @property
    def lap_time(self) -> float | None:
        """[s] of the fastest plan that does; None where none does."""
        return None if self.best is None else self.best.lap

    @property
    def verdict(self) -> str:
        """How it ended, in a few words."""
        asked = count(len(self.conditions), "condition")
        if self.best is None:
            return f"no plan was found that holds under {asked} in {percent(HELD)} of the flights"
        return f"{seconds(self.best.lap)} is the soonest plan that holds under {asked}"

    def rates_of(self, point: Point) -> dict[str, float]:
        """Share of successes of a plan without a condition and under each, by its name."""
        names = ("as tuned", *(condition.name for condition in self.conditions))
        return dict(zip(names, (point.standing.nominal, *point.standing.rates), strict=True))

    def facts(self) -> dict[str, str]:
        """The verdict, what each plan of the front stands, and where everything lies."""
        return {
            "race": f"{self.race}: {self.verdict}",
            "plan": "" if self.best is None else self.best.plan_settings.key,
            "front": ", ".join(f"{seconds(point.lap)} stands {percent(point.standing.severity)}" for point in self.front),
            "folder": str(self.folder),
        }

    def rows(self) -> list[dict[str, Any]]:
        """A row for each plan that could be flown, the soonest first."""
        return [
            {
                "lap_time": point.lap,
                "planned": point.planned,
                "stands": point.standing.severity,
                "on_front": point in self.front,
                "best": point == self.best,
                **vars(point.plan_settings),
                **self.rates_of(point),
            }
            for point in self.points
        ]

    def to_dict(self) -> dict[str, Any]:
        """The keys of `hotlap tune --goal lap_time --hold ... --json`."""
        best = self.best
        return {
            "race": self.race,
            "goal": LAP_TIME,
            "hold": self.hold,
            "lap_time": self.lap_time,
            "rates": None if best is None else self._dump_rates(best, self.validation),
            "plan": None if best is None else dict(vars(best.plan_settings)),
            "front": [
                {
                    "lap_time": point.lap,
                    "stands": point.standing.severity,
                    "plan": dict(vars(point.plan_settings)),
                    "rates": self._dump_rates(point, 0),
                    "race_file": str(place.race),
                    "parameters": str(place.parameters),
                }
                for point, place in zip(self.front, self.places, strict=True)
            ],
        }

    def _dump_rates(self, point: Point, flights: int) -> list[dict[str, Any]]:
        """Share of successes under each condition; with an interval where the flights were flown for that."""
        found = []
        for change, rate in self.rates_of(point).items():
            interval = dict(zip(("low", "high"), Validation(flights, round(rate * flights)).interval, strict=True)) if flights else {}
            found.append({"change": change, "rate": rate, **interval})
        return found

    def plot(self) -> Figure | None:
        """Lap time against what it stands; None where no plan holds at all."""
        from hotlap.report.front_chart import Tried, front_chart  # noqa: PLC0415  matplotlib, only where there is something to draw

        flown = [point for point in self.points if point.standing.severity > FALLS]
        if not flown:
            return None
        best = None if self.best is None else self.best.plan_settings
        tried = [Tried(one.lap, one.standing.severity, one in self.front, one.plan_settings == best) for one in flown]
        stands = "no plan" if self.best is None else f"{self.best.lap:.2f} s"
        title = f"{self.race}: {stands} stands all that was asked for"
        return front_chart(tried, title, f"100 %: {', '.join(condition.name for condition in self.conditions)}")


def find_front(
    asked: Asked, race: Race, folder: Path, tuning: tuple[str, TuningSettings], conditions: tuple[Condition, ...], engine: Engine
) -> FrontResult:
    """Search plans, and write the front and the fastest that holds.

    Args:
        asked: the arguments of the call.
        race: whose plan is looked for.
        folder: of everything that is written.
        tuning: tuner and settings.
        conditions: what the plan is to hold under.
        engine: where plans are tried.
    """
    with asked.progress.rounds(PLANS, most_plans(race)) as progress:
        each = partial(ResumableJobs(folder, progress=progress, note=asked.progress.note, engine=engine).each, PLANS)
        points = search(race, *tuning, conditions, partial(each, work=try_under_conditions))
        best, points = winner(race, *tuning, conditions, points, partial(each, work=judge_under_conditions))
    _remove_former(folder)
    stair, known = front(points), {"seed": tuning[1].seed, "hold": asked.hold}
    places = [
        write_planned_race(
            folder / FOLDER / f"{point.lap:.3f}s",
            race,
            f"{race.name}-{point.lap:.3f}s",
            point.plan_settings,
            point.parameters,
            {**known, "stands": point.standing.severity, "lap_time": point.lap},
        )
        for point in stair
    ]
    chosen = None
    if best is not None:
        remarks = {**known, "lap_time": best.lap, "validated_rate": min(best.standing.nominal, *best.standing.rates)}
        chosen = write_planned_race(folder, race, f"{race.name}-fastest", best.plan_settings, best.parameters, remarks)
    ended = (best, chosen, tuple(stair), tuple(places), tuple(points), tuning[1].validation)
    result = FrontResult(race.name, asked.hold, conditions, *ended, folder, folder / FRONT_FILE, _pictures(folder, points))
    replace(result.document, json.dumps(finite(result.to_dict()), indent=2, allow_nan=False) + "\n")
    figure = result.plot()
    if figure is not None:
        from hotlap.report.pictures import save  # noqa: PLC0415  matplotlib, only where there is something to draw

        for picture in result.pictures:
            save(picture, figure)
    return result


def _pictures(folder: Path, points: Sequence[Point]) -> tuple[Path, ...]:
    """Where the front is drawn; nowhere if no plan holds at all."""
    return tuple(folder / name for name in PICTURES) if any(point.standing.severity > FALLS for point in points) else ()


def _remove_former(folder: Path) -> None:
    """Remove races and parameters that an earlier search in this folder has written, perhaps under other conditions; nothing else."""
    for place in [folder, *(folder / FOLDER).glob("*s")]:
        for name in (RACE_FILE, PARAMETERS_FILE):
            (place / name).unlink(missing_ok=True)
        if place != folder:
            with suppress(OSError):  # something else is in it
                place.rmdir()
