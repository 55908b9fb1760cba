"""Replay: the flights of a page, flown again with noise that the search never met."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

from hotlap.analysis.robustness import Robustness, check_robustness
from hotlap.analysis.sensitivity import Sensitivity, survey_sensitivity
from hotlap.core.parameters import Parameters
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.reference.scenario import Scenario
from hotlap.report.demonstration import choose, demonstrate
from hotlap.report.effort import Effort, effort_of
from hotlap.report.scene import Scene
from hotlap.study.configuration import Configuration
from hotlap.worlds.world import World

FLIGHTS = 50  # of each set of parameters
WHILE_RUNNING = 12  # the same, while a tuning wants the processors
SLOW = 0.05  # s of a flight, beyond which parameters are not varied


@dataclass(frozen=True)
class Replay:
    """What was flown again.

    Attributes:
        scene: one flight of each set of parameters in full, and how the others ended.
        efforts: of each of these flights: its own, and its reference's.
        sensitivity: None where it was not flown.
        holds: with a vehicle that differs; empty where that was not flown.
    """

    scene: Scene
    efforts: tuple[tuple[Effort, Effort], ...]
    sensitivity: Sensitivity | None
    holds: tuple[Robustness, ...]


def show(configuration: Configuration, world: World, best: Parameters, holds: tuple[Robustness, ...] | None = None) -> Replay:
    """Fly all that a page of a finished study shows.

    Args:
        configuration: what the study is a study of.
        world: where its flights happen.
        best: shape (S, K).
        holds: if they have been flown already.
    """
    scenario, settings = _judged(configuration.scenario), configuration.settings
    before = time.perf_counter()
    scene = _demonstrate(configuration, scenario, world, best, FLIGHTS)
    slow = time.perf_counter() - before > SLOW * FLIGHTS * len(scene.traces)
    if holds is None:
        holds = check_robustness(scenario, world, settings.goal, best, settings.seed) if world.takes_vehicle_parameters and not slow else ()
    sensitivity = None if slow else survey_sensitivity(scenario, world, best, settings.seed)
    return Replay(scene, _efforts(scene, scenario), sensitivity, holds)


def glance(configuration: Configuration, world: World, best: Parameters) -> Replay:
    """Fly what a page shows while the study is still running."""
    scenario = _judged(configuration.scenario)
    scene = _demonstrate(configuration, scenario, world, best, WHILE_RUNNING)
    return Replay(scene, _efforts(scene, scenario), None, ())


def _demonstrate(configuration: Configuration, scenario: Scenario, world: World, best: Parameters, flights: int) -> Scene:
    seeds = flight_seeds(configuration.settings.seed, Stream.DEMONSTRATION, 0, flights)
    return demonstrate(scenario, world, choose(scenario, configuration.first_guess, best), seeds)


def _efforts(scene: Scene, scenario: Scenario) -> tuple[tuple[Effort, Effort], ...]:
    return tuple(effort_of(trace, scenario) for trace in scene.traces)


def _judged(scenario: Scenario) -> Scenario:
    """The same scenario, flown no further than its flights are judged: they are the same up to there."""
    judge = scenario.race.judge.model_copy(update={"fly_on": False})
    return replace(scenario, race=scenario.race.model_copy(update={"judge": judge}))
