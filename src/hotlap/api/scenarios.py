"""Scenarios: races, worlds and parameters as they are given to a call, made ready to fly."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from hotlap.api.asked import Asked
from hotlap.api.inputs import one_of
from hotlap.api.progress import Progress
from hotlap.core.errors import InputError, UnknownNameError
from hotlap.core.parameters import Parameters
from hotlap.files.descriptions import PARAMETERS_FILE, load_parameters, load_race
from hotlap.files.parameters_file import CHOSEN_SHARE
from hotlap.first_guess.guess import first_guess, teaches
from hotlap.first_guess.names import DEFAULT, LEARNED, NAMES
from hotlap.first_guess.training_set import load_training_set, shipped
from hotlap.planning.preparation import differences, parameters_for, prepare
from hotlap.race.controller_kind import ControllerKind
from hotlap.race.race import Race
from hotlap.reference.scenario import Scenario
from hotlap.reference.segmentation_rule import SegmentationRule
from hotlap.study.database import is_begun
from hotlap.system.regular_files import is_folder, is_there
from hotlap.worlds.stepped import Stepped
from hotlap.worlds.world import World

COMPILED = "circle-34"  # the race that a kernel is compiled with; it serves all
TRAINING = ".json"  # what the files of training sets end with


def load(race: Race | str | Path, controller: str | None) -> Race:
    """A race with the controller that is asked for, or its own.

    Raises:
        InputError: the race cannot be read, or there is no such controller.
    """
    kind = None if controller is None else one_of(ControllerKind, controller, "controller", "controller")
    loaded = race if isinstance(race, Race) else load_race(race)
    return loaded if kind is None else loaded.with_controller(kind)


def make_scenario(race: Race, asked: Asked, *, cache: bool = True) -> Scenario:
    """Plan a race, or read its reference, and cut it by the rule that is asked for; says what was assumed about a reference.

    Raises:
        InputError: a file is not usable, or there is no such rule.
        PlanningError: there is no plan, or none was found.
    """
    rule, reference = one_of(SegmentationRule, asked.segments, "segmentation rule", "segments"), getattr(asked, "reference", None)
    with asked.progress.working(f"planning {race.name}" if reference is None else f"reading {reference}"):
        scenario = prepare(race, reference, cache=cache, segments=rule)
    for note in scenario.notes:
        asked.progress.note(f"note: {note}")
    if race.planning.free and reference is None:
        share = f"{100 * race.thrust_share:.0f} % of the thrust (planning.thrust_share)"
        asked.progress.note(f"note: {race.name} fixes no plan: planned with {share}; hotlap.tune() chooses the boldest that holds")
    return scenario


def planned_as(race: Race, parameters: Any) -> Race:
    """A race that fixes no plan, with the plan that was chosen when its parameters were tuned; any other race as it is.

    Args:
        race: as it was read.
        parameters: as they were given: those of a file or a study's folder remember it.

    Raises:
        InputError: they cannot be read.
    """
    given = isinstance(parameters, str | Path) and str(parameters) not in NAMES and Path(parameters).suffix != TRAINING
    if not given or not race.planning.free or not is_there(Path(parameters)):
        return race
    saved = load_parameters(parameters)
    share = saved.provenance.get(CHOSEN_SHARE)
    return race.with_share(float(share)) if share is not None and saved.race == race.name else race


def make_ready(world: World, scenario: Scenario, progress: Progress) -> None:
    """Let a world compile what it flies with, and say so where that takes its time."""
    if isinstance(world, Stepped):
        world.note = lambda line: progress.note(f"note: {line}")
        if scenario.race.noise.wind > 0 or scenario.race.noise.steady_wind > 0:
            world.note(f"the wind of {scenario.race.name} blows in the built-in world only, not in {world.name}")
    prepare_world, needs_compiling = getattr(world, "prepare", None), getattr(world, "needs_compiling", None)
    if prepare_world is None:
        return
    if needs_compiling is not None and needs_compiling(scenario):
        with progress.working("compiling the flight core (once, about half a minute)"):
            prepare_world(scenario)
    else:
        prepare_world(scenario)
    if isinstance(world, Stepped):
        with progress.working(world.opening):
            world.capacity(scenario)


def make_kind_ready(world: World, kind: ControllerKind, progress: Progress) -> None:
    """The same where no scenario is at hand yet: for any race that a kind of controller flies."""
    make_ready(world, prepare(load_race(COMPILED).with_controller(kind)), progress)


def read_parameters(path: Path, scenario: Scenario, progress: Progress) -> Parameters:
    """Parameters from a file or a study's folder, shape (S, K); says for what else they were tuned.

    Raises:
        InputError: they cannot be read, or do not fit the scenario.
    """
    _refuse_unfinished(path)
    saved = load_parameters(path)
    values = parameters_for(scenario, saved, str(path / PARAMETERS_FILE if is_folder(path) else path))
    for difference in differences(scenario, saved):
        progress.note(f"note: {path}: {difference}")
    return values


def fitting(values: Any, scenario: Scenario) -> Parameters:
    """Parameters that were given as numbers, shape (S, K) or (K,) for the same in all segments.

    Raises:
        InputError: another shape.
    """
    shape, given = (len(scenario.segments), scenario.space.size), np.asarray(values, dtype=np.float64)
    if given.shape not in {shape, shape[1:]}:
        raise InputError("", "parameters", f"must have shape {shape} or {shape[1:]}, not {given.shape}")
    return np.broadcast_to(given, shape).copy()


def check_guess(text: str) -> None:
    """Refuse a first guess that cannot be read, before anything takes its time.

    Raises:
        InputError: with the file, the key and the reason.
    """
    if text in NAMES:
        return
    path = Path(text)
    if not path.suffix and not is_there(path):
        raise UnknownNameError("first guess", text, NAMES, key="first_guess")
    if path.suffix == TRAINING:
        load_training_set(path)
    else:
        _refuse_unfinished(path)
        load_parameters(path)


def read_guess(text: str, scenario: Scenario, progress: Progress) -> Parameters:
    """The first guess that was asked for, shape (S, K): a name, parameters, or what is learnt from a training set.

    Raises:
        InputError: it cannot be read, or does not fit the scenario.
    """
    if text not in NAMES and Path(text).suffix != TRAINING:
        return read_parameters(Path(text), scenario, progress)
    if text == DEFAULT:
        return first_guess(scenario, DEFAULT)
    training = shipped() if text in NAMES else load_training_set(Path(text))
    if not teaches(training, scenario):
        kind = scenario.race.controller.kind
        progress.note(f"note: nothing was learnt about the controller {kind}; the first guess is its default")
    return first_guess(scenario, text if text in NAMES else LEARNED, training)


def _refuse_unfinished(path: Path) -> None:
    """A folder whose study has not ended holds no parameters yet."""
    if is_folder(path) and is_begun(path) and not (path / PARAMETERS_FILE).exists():
        reason = f"holds a study that has not ended, so no {PARAMETERS_FILE}; hotlap.tune(RACE, out={str(path)!r}) goes on with it"
        raise InputError(str(path), "", reason)
