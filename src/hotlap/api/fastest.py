"""Fastest: what `tune` does for the goal lap_time: the fastest plan that can be flown, or that holds, with its parameters."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hotlap import tuners, worlds
from hotlap.analysis.fastest import RELIABLE, fastest
from hotlap.analysis.plan_trials import PlanSettings, judge_plan, try_plan
from hotlap.analysis.resumable import ResumableJobs
from hotlap.api.asked import Asked
from hotlap.api.front import PLANS, FrontResult, find_front
from hotlap.api.held import read_hold
from hotlap.api.inputs import as_path
from hotlap.api.outcome import Outcome
from hotlap.api.planned_race import RACE_FILE, PlannedRace, write_planned_race
from hotlap.api.planning import plan
from hotlap.api.scenarios import load, make_kind_ready
from hotlap.api.wording import percent, seconds, share
from hotlap.core.errors import InputError, PlanningError, StudyError
from hotlap.core.success_rate import Validation
from hotlap.files.descriptions import load_race
from hotlap.planning.preparation import prepare
from hotlap.race.race import Race
from hotlap.study.database import is_begun
from hotlap.study.study import new_folder
from hotlap.system.engine import opened
from hotlap.system.regular_files import check_folder
from hotlap.tuning.goal_forms import LAP_TIME
from hotlap.tuning.loop import TuningSettings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROUNDS = 40  # of plans tried around the best so far
FIXED = ("reference", "first_guess", "segments", "on", "instances", "randomise", "samples", "reliability", "selection", "minutes")
"""Arguments that have no meaning here."""


@dataclass(frozen=True, repr=False)
class FastestResult(Outcome):
    """The fastest plan that can be flown reliably, and the parameters that fly it.

    Attributes:
        race: its name.
        lap_time: [s] as flown; None where no plan can be flown reliably.
        planned_before: [s] of the race's own plan; NaN where it has none.
        plan_settings: what was planned with; None likewise.
        validation: flights that it was not chosen by; None likewise.
        chosen: where its race and parameters lie; None likewise.
        folder: of everything that was written.
    """

    race: str
    lap_time: float | None
    planned_before: float
    plan_settings: PlanSettings | None
    validation: Validation | None
    chosen: PlannedRace | None
    folder: Path

    @property
    def found(self) -> bool:
        """Whether a plan can be flown reliably."""
        return self.chosen is not None

    @property
    def verdict(self) -> str:
        """How it ended, in a few words."""
        if self.lap_time is None:
            return f"no plan was found that passes every gate in {percent(RELIABLE)} of the flights"
        return f"{seconds(self.lap_time)}, where the race's own plan takes {seconds(self.planned_before)}"

    def facts(self) -> dict[str, str]:
        """The verdict, the plan, how often it held, and where everything lies."""
        return {
            "race": f"{self.race}: {self.verdict}",
            "plan": "" if self.plan_settings is None else self.plan_settings.key,
            "holds in": "" if self.validation is None else share(self.validation),
            "folder": str(self.folder),
        }

    def rows(self) -> list[dict[str, Any]]:
        """One row: the plan; none where there is none."""
        if self.plan_settings is None or self.validation is None:
            return []
        figures = {"lap_time": self.lap_time, "planned_before": self.planned_before, "rate": self.validation.rate}
        return [{"race": self.race, **figures, **vars(self.plan_settings)}]

    def plot(self) -> Figure:
        """The plan from above and from the side, coloured by speed.

        Raises:
            InputError: no plan was found.
        """
        if self.chosen is None:
            raise InputError("", "plot", f"{self.race}: {self.verdict}")
        return plan(self.chosen.race).plot()

    def to_dict(self) -> dict[str, Any]:
        """The keys of `hotlap tune --goal lap_time --json`."""
        plan, validation, chosen = self.plan_settings, self.validation, self.chosen
        document = {"race": self.race, "goal": LAP_TIME, "lap_time": self.lap_time, "planned_before": self.planned_before}
        if plan is None or validation is None or chosen is None:
            return {**document, "plan": None, "validation": None, "study": str(self.folder), "race_file": None, "parameters": None}
        low, high = validation.interval
        return {
            **document,
            "plan": {"v_max": plan.v_max, "tolerance": plan.tolerance, "thrust": plan.thrust},
            "validation": {**vars(validation), "rate": validation.rate, "low": low, "high": high},
            "study": str(self.folder),
            "race_file": str(chosen.race),
            "parameters": str(chosen.parameters),
        }


def carry_out(asked: Asked, call: Callable[..., Any]) -> FastestResult | FrontResult:
    """Search plans, and write the best as a race with its parameters.

    Args:
        asked: the arguments of a call.
        call: the function that was called, which has the defaults.
    """
    settings = _settings(asked, call)
    tuner, race = tuners.build(asked.tuner).name, load(asked.race, asked.controller)
    folder = as_path(asked.out) or new_folder(race.name)
    check_folder(folder, "the folder of a study")
    if is_begun(folder) or ((folder / RACE_FILE).exists() and load_race(folder / RACE_FILE).name != _name(race)):
        raise StudyError(str(folder), "", "holds another study; give another folder for this one")
    world = worlds.build(asked.on)
    conditions = read_hold(asked.hold, race, world)
    with asked.remarked("go on", out=folder), opened(asked.cluster, note=asked.progress.note) as engine:
        engine.require(asked.tuner.partition(":")[0].rpartition(".")[0])
        make_kind_ready(world, race.controller.kind, asked.progress)
        if conditions:
            return find_front(asked, race, folder, (tuner, settings), conditions, engine)
        with asked.progress.rounds(PLANS, 0) as progress:
            each = partial(ResumableJobs(folder, progress=progress, note=asked.progress.note, engine=engine).each, PLANS)
            best = fastest(race, tuner, settings, partial(each, work=try_plan), partial(each, work=judge_plan), ROUNDS)
    before = _lap_before(race)
    if best is None:
        return FastestResult(race.name, None, before, None, None, None, folder)
    plan_settings, found = best
    validation = Validation(settings.validation, round(found["rate"] * settings.validation))
    known = {"seed": settings.seed, "lap_time": found["lap"], "validated_rate": validation.rate}
    chosen = write_planned_race(folder, race, _name(race), plan_settings, found["parameters"], known)
    return FastestResult(race.name, found["lap"], before, plan_settings, validation, chosen, folder)


def _settings(asked: Asked, call: Callable[..., Any]) -> TuningSettings:
    """The settings of each plan's tuning; what has no meaning is refused."""
    defaults = inspect.signature(call).parameters
    for name in FIXED:
        if getattr(asked, name) != defaults[name].default:
            raise InputError("", name, f"has no meaning for the goal {LAP_TIME}, which looks for a plan of its own")
    if not asked.validation:
        raise InputError("", "validation", f"must not be 0 for the goal {LAP_TIME}, which chooses by it")
    names = ("budget", "seed", "confirm", "batch", "validation")
    return TuningSettings(**{name: getattr(asked, name) for name in names}, reliability=RELIABLE)


def _name(race: Race) -> str:
    """Of the race that is written."""
    return f"{race.name}-fastest"


def _lap_before(race: Race) -> float:
    """[s] of the race's own plan; NaN where it has none."""
    try:
        return prepare(race).reference.lap_time
    except PlanningError:
        return math.nan
