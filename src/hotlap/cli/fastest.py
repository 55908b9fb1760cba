"""`hotlap tune RACE --goal lap_time`: the fastest plan that can be flown, and the parameters that fly it."""

from __future__ import annotations

import inspect
import math
import shlex
from argparse import Namespace
from functools import partial
from typing import Any

from hotlap import tuners, worlds
from hotlap.analysis.fastest import RELIABLE, fastest
from hotlap.analysis.plan_trials import PlanSettings, judge_plan, try_plan
from hotlap.analysis.resumable import ResumableJobs
from hotlap.api.held import read_hold
from hotlap.api.tuning import tune
from hotlap.api.wording import percent, seconds
from hotlap.cli import front
from hotlap.cli.flying import load, make_kind_ready
from hotlap.cli.output import facts, note, present
from hotlap.cli.planned_race import RACE_FILE, write_planned_race
from hotlap.cli.progress import follow_rounds
from hotlap.cli.stopping import remark
from hotlap.core.counts import count
from hotlap.core.errors import InputError, PlanningError, StudyError
from hotlap.core.success_rate import Validation
from hotlap.files.descriptions import load_race
from hotlap.planning.preparation import prepare
from hotlap.race.race import Race
from hotlap.study.database import FILE as STUDY
from hotlap.study.study import new_folder
from hotlap.tuning.goal_forms import LAP_TIME
from hotlap.tuning.loop import TuningSettings

ROUNDS = 40  # of plans tried around the best so far
PLANS = "plans"  # what the progress counts
FIXED = ("reference", "first_guess", "segments", "on", "randomise", "samples", "reliability", "selection", "minutes")
"""Options that have no meaning here."""


def run(options: Namespace) -> int:
    """Search plans, and write the best as a race with its parameters: 1 where none can be flown reliably."""
    defaults = inspect.signature(tune).parameters
    for name in FIXED:
        if getattr(options, name) != defaults[name].default:
            raise InputError(f"--{name.replace('_', '-')}", "", "has no meaning for --goal lap_time, which looks for a plan of its own")
    if not options.validation:
        raise InputError("--validation", "", "must not be 0 for --goal lap_time, which chooses by it")
    names = ("budget", "seed", "confirm", "batch", "validation")
    settings = TuningSettings(**{name: getattr(options, name) for name in names}, reliability=RELIABLE)
    tuner, race = tuners.build(options.tuner).name, load(options)
    folder = new_folder(race.name) if options.out is None else options.out
    if folder.exists() and not folder.is_dir():
        raise StudyError(str(folder), "", "is a file, not the folder of a study")
    if (folder / STUDY).exists() or ((folder / RACE_FILE).exists() and load_race(folder / RACE_FILE).name != _name(race)):
        raise StudyError(str(folder), "", "holds another study; give --out a folder of its own")
    world = worlds.build(options.on)
    conditions = read_hold(options.hold, race, world)
    words = ["hotlap", "tune", *options.arguments, *([] if options.out is not None else ["--out", str(folder)])]
    with remark(f"nothing is lost; go on with: {shlex.join(words)}"):
        make_kind_ready(world, race.controller.kind)
        if conditions:
            return front.run(options, race, folder, (tuner, settings), conditions)
        with follow_rounds(PLANS) as progress:
            each = partial(ResumableJobs(folder, progress=progress, note=note).each, PLANS)
            best = fastest(race, tuner, settings, partial(each, work=try_plan), partial(each, work=judge_plan), ROUNDS)
    if best is None:
        note(f"hotlap: {race.name}: no plan was found that passes every gate in {percent(RELIABLE)} of the flights")
        return 1
    _present(options, race, folder, best, settings)
    return 0


def _present(options: Namespace, race: Race, folder: Any, best: tuple[PlanSettings, dict[str, Any]], settings: TuningSettings) -> None:
    """Write the race and its parameters, and say how fast it is."""
    plan_settings, found = best
    before = _lap_before(race)
    validation = Validation(settings.validation, round(found["rate"] * settings.validation))
    low, high = validation.interval
    known = {"seed": settings.seed, "lap_time": found["lap"], "validated_rate": validation.rate}
    written = write_planned_race(folder, race, _name(race), plan_settings, found["parameters"], known)
    document = {
        "race": race.name,
        "goal": LAP_TIME,
        "lap_time": found["lap"],
        "planned_before": before,
        "plan": {"v_max": plan_settings.v_max, "tolerance": plan_settings.tolerance, "thrust": plan_settings.thrust},
        "validation": {**vars(validation), "rate": validation.rate, "low": low, "high": high},
        "study": str(folder),
        "race_file": str(written.race),
        "parameters": str(written.parameters),
    }
    lines = [
        f"{race.name}: {seconds(found['lap'])}, where the race's own plan takes {seconds(before)}",
        *facts(
            {
                "holds in": f"{validation.successes} of {count(validation.flights, 'flight')} ({100 * low:.0f} to {100 * high:.0f} %)",
                "plan": plan_settings.key,
                "largest speed": f"{written.scenario.reference.max_speed:.1f} m/s",
                "race": str(written.race),
                "parameters": str(written.parameters),
            }
        ),
        f"fly it again: {written.again}",
        f"a study of it, with its page: {written.study}",
    ]
    present(as_json=options.json, document=document, lines=lines)


def _name(race: Race) -> str:
    """Of the race that is written."""
    return f"{race.name}-fastest"


def _lap_before(race: Race) -> float:
    """[s] of the race's own plan; NaN where it has none."""
    try:
        return prepare(race).reference.lap_time
    except PlanningError:
        return math.nan
