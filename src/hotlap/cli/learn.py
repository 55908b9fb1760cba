"""`hotlap learn`: races tuned, and flown with each other's parameters: what first guesses are learnt from."""

from __future__ import annotations

import hashlib
import shlex
from argparse import Namespace
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from hotlap.analysis.learning import Lesson, Tuned, assemble, candidates_of, fly_lesson, lessons, tune_lesson
from hotlap.cli.flying import make_kind_ready
from hotlap.cli.output import note, present
from hotlap.cli.progress import follow_pieces
from hotlap.cli.stopping import remark
from hotlap.core.errors import HotlapError, InputError, StudyError
from hotlap.files.descriptions import load_race
from hotlap.files.error_messages import check
from hotlap.first_guess.training_set import TrainingSet, write_training_set
from hotlap.race.controllers import TUNABLE, ControllerKind
from hotlap.system.journal import LinesFile
from hotlap.system.process_pool import spread
from hotlap.system.text_files import replace
from hotlap.worlds.built_in import BuiltIn

FILE = "first_guess.json"


def run(options: Namespace) -> int:
    """Tune what is not tuned yet, fly what is not flown yet, and write what is known."""
    folder: Path = options.out
    if options.jobs < 0:
        raise InputError("--jobs", "", f"must not be negative, not {options.jobs}")
    if folder.exists() and not folder.is_dir():
        raise StudyError(str(folder), "", "is a file, not the folder of what is learnt")
    asked = _lessons(options.races) if options.races else lessons()
    with remark(f"nothing is lost; go on with: {shlex.join(['hotlap', 'learn', *options.arguments])}"):
        make_kind_ready(BuiltIn(), asked[0].race.controller.kind)
        with LinesFile.opened(folder) as kept:
            training = _learn(asked, kept, options.jobs)
    path = folder / FILE
    replace(path, write_training_set(training))
    held = sum(race.tuned is not None for race in training.races)
    document = {"file": str(path), "races": len(training.races), "tuned": held, "candidates": len(training.candidates)}
    lines = [
        f"{len(training.races)} races, {held} of them tuned, {len(training.candidates)} parameters flown in each",
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


def _learn(asked: Sequence[Lesson], kept: LinesFile, jobs: int) -> TrainingSet:
    """Both steps, each race of which is kept as soon as it is there."""
    _work("races to tune", kept, {f"tuned {lesson.key}": lesson for lesson in asked}, tune_lesson, jobs)
    done = [(lesson, kept.done[f"tuned {lesson.key}"]) for lesson in asked]
    planned = [(lesson, check(Tuned, plain, str(kept.path))) for lesson, plain in done if plain is not None]
    for lesson, plain in done:
        if plain is None:
            note(f"note: {lesson.race.name} flown by {lesson.vehicle} is left out: it has no plan")
    if not planned:
        raise HotlapError("none of the races has a plan")
    candidates = candidates_of([tuned for _, tuned in planned], planned[0][0].race.controller.default)
    mark = hashlib.sha256(repr(candidates).encode()).hexdigest()[:16]
    work = {f"flown {mark} {lesson.key}": (lesson, candidates) for lesson, _ in planned}
    _work("races to fly", kept, work, fly_lesson, jobs)
    flown = [kept.done[key] for key in work]
    return assemble([lesson for lesson, _ in planned], [tuned for _, tuned in planned], candidates, flown)


def _work(unit: str, kept: LinesFile, wanted: Mapping[str, Any], work: Callable[[Any], Iterable[Any]], jobs: int) -> None:
    """Do what is missing, by key, and keep each result."""
    keys = {id(piece): key for key, piece in wanted.items() if key not in kept.done}
    with follow_pieces(unit, len(wanted), len(wanted) - len(keys)) as say:
        for piece, result in spread(work, [wanted[key] for key in keys.values()], jobs):
            kept.add(keys[id(piece)], result.model_dump(mode="json") if isinstance(result, Tuned) else result)
            lesson = piece if isinstance(piece, Lesson) else piece[0]
            say(f"{lesson.race.name} flown by {lesson.vehicle}")
