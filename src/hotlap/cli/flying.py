"""Flying: what `tune` and `fly` share: a scenario and a world made ready, and parameters that fit."""

from __future__ import annotations

import shlex
from argparse import Namespace
from pathlib import Path

from hotlap.cli.output import note, working
from hotlap.core.errors import InputError, UnknownNameError
from hotlap.core.parameters import Parameters
from hotlap.files.descriptions import PARAMETERS_FILE, load_parameters, load_race
from hotlap.first_guess.guess import DEFAULT, LEARNED, NAMES, first_guess, teaches
from hotlap.first_guess.training_set import load_training_set, shipped
from hotlap.planning.preparation import differences, parameters_for, prepare
from hotlap.race.controllers import ControllerKind
from hotlap.race.race import Race
from hotlap.reference.scenario import Scenario
from hotlap.reference.segmentation import SegmentationRule
from hotlap.study.database import FILE
from hotlap.worlds.world import World

COMPILED = "circle-34"  # the race that a kernel is compiled with; it serves all
TRAINING = ".json"  # what the files of training sets end with


def load(options: Namespace) -> Race:
    """The race that was asked for, with the controller that was asked for."""
    race = load_race(options.race)
    return race if options.controller is None else race.with_controller(ControllerKind(options.controller))


def make_scenario(race: Race, options: Namespace) -> Scenario:
    """Plan, or read the reference."""
    with working(f"planning {race.name}" if options.reference is None else f"reading {options.reference}"):
        return prepare(race, options.reference, segments=SegmentationRule(options.segments))


def make_ready(world: World, scenario: Scenario) -> None:
    """Let a world compile what it flies with, and say so where that takes its time."""
    prepare_world, needs_compiling = getattr(world, "prepare", None), getattr(world, "needs_compiling", None)
    if prepare_world is None:
        return
    if needs_compiling is not None and needs_compiling(scenario):
        with working("compiling the flight core (once, about half a minute)"):
            prepare_world(scenario)
    else:
        prepare_world(scenario)


def make_kind_ready(world: World, kind: ControllerKind) -> None:
    """The same where no scenario is at hand yet: for any race that a kind of controller flies."""
    make_ready(world, prepare(load_race(COMPILED).with_controller(kind)))


def read_parameters(path: Path, scenario: Scenario) -> Parameters:
    """Parameters from a file or a study's folder, shape (S, K); says for what else they were tuned."""
    _refuse_unfinished(path)
    saved = load_parameters(path)
    values = parameters_for(scenario, saved, str(path / PARAMETERS_FILE if path.is_dir() else path))
    for difference in differences(scenario, saved):
        note(f"note: {path}: {difference}")
    return values


def _refuse_unfinished(path: Path) -> None:
    """A folder whose study has not ended holds no parameters yet."""
    if path.is_dir() and (path / FILE).exists() and not (path / PARAMETERS_FILE).exists():
        raise InputError(
            str(path), "", f"holds a study that has not ended, so no {PARAMETERS_FILE}; hotlap tune --out {path} goes on with it"
        )


def check_guess(text: str) -> None:
    """Refuse a first guess that cannot be read, before anything takes its time.

    Raises:
        InputError: with the file, the key and the reason.
    """
    if text in NAMES:
        return
    path = Path(text)
    if not path.suffix and not path.exists():
        raise UnknownNameError("first guess", text, NAMES, "--first-guess")
    if path.suffix == TRAINING:
        load_training_set(path)
    else:
        _refuse_unfinished(path)
        load_parameters(path)


def read_guess(text: str, scenario: Scenario) -> Parameters:
    """The first guess that was asked for, shape (S, K): a name, parameters, or what is learnt from a training set."""
    if text not in NAMES and Path(text).suffix != TRAINING:
        return read_parameters(Path(text), scenario)
    training = shipped() if text in NAMES else load_training_set(Path(text))
    name = text if text in NAMES else LEARNED
    if name != DEFAULT and not teaches(training, scenario):
        note(f"note: nothing was learnt about the controller {scenario.race.controller.kind}; the first guess is its default")
    return first_guess(scenario, name, training)


def command_to_fly(options: Namespace, parameters: Path) -> str:
    """The command that flies tuned parameters as they were tuned."""
    words = ["hotlap", "fly", options.race, "--parameters", str(parameters)]
    if options.reference is not None:
        words += ["--reference", str(options.reference)]
    if options.segments != SegmentationRule.PAPER:
        words += ["--segments", options.segments]
    if options.controller is not None:
        words += ["--controller", options.controller]
    if options.on != "built-in":
        words += ["--on", options.on]
    return shlex.join(words)
