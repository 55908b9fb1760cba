"""Shown: the flights of a page, flown again with noise that the search never met."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

from hotlap.analysis.hold import Hold, will_it_hold
from hotlap.analysis.sensitivity import Sensitivity, survey_sensitivity
from hotlap.configuration import Configuration
from hotlap.course import Course
from hotlap.parameters import Parameters
from hotlap.report.demonstration import choose, demonstrate
from hotlap.report.effort import Effort, effort_of
from hotlap.report.scene import Scene
from hotlap.seeds import Stream, flight_seeds
from hotlap.worlds.world import World

FLIGHTS = 50  # of each set of parameters
WHILE_RUNNING = 12  # the same, while a tuning wants the processors
SLOW = 0.05  # s of a flight, beyond which parameters are not varied


@dataclass(frozen=True)
class Shown:
    """What was flown again.

    Attributes:
        scene: one flight of each set of parameters in full, and how the others ended.
        efforts: of each of these flights: its own, and its reference's.
        sensitivity: None where it was not flown.
        holds: where the truth is different; empty where that was not flown.
    """

    scene: Scene
    efforts: tuple[tuple[Effort, Effort], ...]
    sensitivity: Sensitivity | None
    holds: tuple[Hold, ...]


def show(configuration: Configuration, world: World, best: Parameters, holds: tuple[Hold, ...] | None = None) -> Shown:
    """Fly all that a page of a finished study shows.

    Args:
        configuration: what the study is a study of.
        world: where its flights happen.
        best: shape (S, K).
        holds: if they have been flown already.
    """
    course, settings = _judged(configuration.course), configuration.settings
    before = time.perf_counter()
    scene = _demonstrate(configuration, course, world, best, FLIGHTS)
    slow = time.perf_counter() - before > SLOW * FLIGHTS * len(scene.traces)
    if holds is None:
        holds = will_it_hold(course, world, settings.goal, best, settings.seed) if world.takes_truth and not slow else ()
    sensitivity = None if slow else survey_sensitivity(course, world, best, settings.seed)
    return Shown(scene, _efforts(scene, course), sensitivity, holds)


def glance(configuration: Configuration, world: World, best: Parameters) -> Shown:
    """Fly what a page shows while the study is still running."""
    course = _judged(configuration.course)
    scene = _demonstrate(configuration, course, world, best, WHILE_RUNNING)
    return Shown(scene, _efforts(scene, course), None, ())


def _demonstrate(configuration: Configuration, course: Course, world: World, best: Parameters, flights: int) -> Scene:
    seeds = flight_seeds(configuration.settings.seed, Stream.DEMONSTRATION, 0, flights)
    return demonstrate(course, world, choose(course, configuration.first_guess, best), seeds)


def _efforts(scene: Scene, course: Course) -> tuple[tuple[Effort, Effort], ...]:
    return tuple(effort_of(trace, course) for trace in scene.traces)


def _judged(course: Course) -> Course:
    """The same course, flown no further than its flights are judged: they are the same up to there."""
    judge = course.race.judge.model_copy(update={"fly_on": False})
    return replace(course, race=course.race.model_copy(update={"judge": judge}))
