"""`hotlap learn`: races tuned, and flown with each other's parameters: what first guesses are learnt from."""

from __future__ import annotations

import shlex
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from hotlap.analysis.learning import Lesson, TunedRace, assemble, candidates_of, fly_lesson, lessons, tune_lesson
from hotlap.analysis.resumable import ResumableJobs
from hotlap.cli.flying import make_kind_ready
from hotlap.cli.output import note, present
from hotlap.cli.progress import follow_pieces
from hotlap.cli.stopping import remark
from hotlap.core.counts import count
from hotlap.core.errors import HotlapError, InputError
from hotlap.files.descriptions import load_race
from hotlap.files.error_messages import check
from hotlap.first_guess.training_set import TrainingSet, write_training_set
from hotlap.race.controllers import TUNABLE, ControllerKind
from hotlap.system.engine import check_jobs, opened
from hotlap.system.journal import Journal
from hotlap.system.regular_files import check_folder
from hotlap.system.text_files import replace
from hotlap.worlds.built_in import BuiltIn

FILE = "first_guess.json"


def run(options: Namespace) -> int:
    """Tune what is not tuned yet, fly what is not flown yet, and write what is known."""
    folder: Path = options.out
    check_jobs(options.jobs, options.cluster)
    check_folder(folder, "the folder of what is learnt")
    asked = _lessons(options.races) if options.races else lessons()
    again = f"nothing is lost; go on with: {shlex.join(['hotlap', 'learn', *options.arguments])}"
    with opened(options.cluster, options.jobs, note) as engine, remark(again):
        make_kind_ready(BuiltIn(), asked[0].race.controller.kind)
        training = _learn(asked, ResumableJobs(folder, progress=follow_pieces, note=note, engine=engine))
    path = folder / FILE
    replace(path, write_training_set(training))
    held = sum(race.tuned is not None for race in training.races)
    document = {"file": str(path), "races": len(training.races), "tuned": held, "candidates": len(training.candidates)}
    lines = [
        f"{count(len(training.races), 'race')}, {held} of them tuned, {len(training.candidates)} parameters flown in each",
        f"written to {path}; begin with it: hotlap tune RACE --first-guess {path}",
    ]
    present(as_json=options.json, document=document, lines=lines)
    return 0


def _lessons(names: Sequence[str]) -> tuple[Lesson, ...]:
    """A user's own races."""
    races = [load_race(name) for name in dict.fromkeys(names)]
    for race, name in zip(races, dict.fromkeys(names), strict=True):
        if TUNABLE[race.controller.kind] is not TUNABLE[ControllerKind.MPC]:
            raise InputError(name, "controller.kind", f"must be a model-predictive one, not {race.controller.kind}")
        if race.controller.horizon_unit != races[0].controller.horizon_unit:
            raise InputError(name, "controller.horizon_unit", "differs from the other races'")
    return tuple({lesson.key: lesson for lesson in (Lesson(race, race.vehicle.name) for race in races)}.values())


def _learn(asked: Sequence[Lesson], jobs: ResumableJobs) -> TrainingSet:
    """Tune the races, then fly all that was found in each of them."""
    done = jobs.each("races to tune", {lesson.name: lesson for lesson in asked}, tune_lesson)
    planned = [(one, check(TunedRace, done[one.name], str(jobs.folder / Journal.file))) for one in asked if done[one.name] is not None]
    for lesson in asked:
        if done[lesson.name] is None:
            note(f"note: {lesson.race.name} flown by {lesson.vehicle} is left out: it has no plan")
    if not planned:
        raise HotlapError("none of the races has a plan")
    candidates = candidates_of([tuned for _, tuned in planned], planned[0][0].race.controller.default)
    flown = jobs.each("races to fly", {lesson.name: (lesson, candidates) for lesson, _ in planned}, fly_lesson)
    return assemble([lesson for lesson, _ in planned], [tuned for _, tuned in planned], candidates, list(flown.values()))
