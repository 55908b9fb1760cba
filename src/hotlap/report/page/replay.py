"""Replay: parameters of a study flown once more, with noise that the search never met, for page, pictures and film.

All sets of parameters meet the same noise. Of each set the flight is shown whose rank among all of them is nearest the middle.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hotlap.analysis.robustness import Robustness, check_robustness
from hotlap.analysis.sensitivity import Sensitivity, survey_sensitivity
from hotlap.core.parameters import Parameters
from hotlap.core.records import Flights
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.race.hold import parse_hold
from hotlap.reference.scenario import Scenario
from hotlap.report.effort import Effort, effort_of
from hotlap.report.scene import Scene, repeat, stage, trace
from hotlap.study.configuration import Configuration
from hotlap.tuning.scoring import score
from hotlap.worlds.world import World, is_slow

BEST, FIRST, DEFAULT = "tuned", "first guess", "default"
FLIGHTS = 50  # of each set of parameters
WHILE_RUNNING = 12  # the same while the search runs, which needs the processors
IN_SIMULATORS = 5  # the same where a flight takes seconds
LOGGED = 12  # flights of each set that are recorded in full; the one that is shown is chosen among them
SLOW = 0.05  # s of computing time for a flight, above which robustness and sensitivity are left out


@dataclass(frozen=True)
class ParameterSet:
    """Parameters that are flown again.

    Attributes:
        label: what they are: `BEST`, `FIRST` or `DEFAULT`.
        parameters: shape (S, K).
    """

    label: str
    parameters: Parameters


def choose(scenario: Scenario, first: Parameters, best: Parameters) -> tuple[ParameterSet, ...]:
    """The sets that are flown again: the best, the first guess and the controller's default; equal sets are flown once.

    Args:
        scenario: that they belong to.
        first: first guess, shape (S, K).
        best: shape (S, K).
    """
    sets = [ParameterSet(BEST, best)]
    for label, values in ((FIRST, first), (DEFAULT, scenario.space.first_guess(len(scenario.segments)))):
        if not any(np.array_equal(values, known.parameters) for known in sets):
            sets.append(ParameterSet(label, values))
    return tuple(sets)


def demonstrate(scenario: Scenario, world: World, sets: Sequence[ParameterSet], seeds: NDArray[np.int64]) -> Scene:
    """Fly each set of parameters with the same seeds of the noise; a typical flight of each set is shown in full.

    Args:
        scenario: that is flown.
        world: where its flights happen.
        sets: at least one, the most important first.
        seeds: of the noise, shape (N,): N flights of each set.
    """
    return _stage(scenario, _fly(scenario, world, sets, seeds), sets)


def _fly(scenario: Scenario, world: World, sets: Sequence[ParameterSet], seeds: NDArray[np.int64]) -> Flights:
    """All flights of a scene, set by set; the first `LOGGED` of each are recorded in full."""
    count = len(seeds)
    parameters = np.concatenate([np.repeat(one.parameters[None], count, axis=0) for one in sets])
    return world.fly(
        scenario, parameters, np.tile(seeds, len(sets)), log=[i * count + k for i in range(len(sets)) for k in range(min(count, LOGGED))]
    )


def _stage(scenario: Scenario, flown: Flights, sets: Sequence[ParameterSet]) -> Scene:
    """The scene of these flights."""
    count = len(flown) // len(sets)
    rows = [slice(i * count, (i + 1) * count) for i in range(len(sets))]
    traces = tuple(trace(scenario, flown, typical(flown, own), one.label) for own, one in zip(rows, sets, strict=True))
    repeats = tuple(repeat(scenario.race, flown, own, one.label) for own, one in zip(rows, sets, strict=True))
    return stage(scenario, traces, repeats)


def typical(flown: Flights, rows: slice) -> int:
    """Index of the recorded flight that is nearest the middle of some flights: ordered by gates passed, then by mean tracking error.

    Args:
        flown: a batch.
        rows: which of its flights are compared; at least one of them is recorded in full.
    """
    error = np.nan_to_num(flown.mean_error[rows], nan=np.inf)
    order = np.lexsort((-error, flown.gates_passed[rows])) + rows.start
    middle = (len(order) - 1) / 2
    recorded = [(abs(rank - middle), index) for rank, index in enumerate(order.tolist()) if index in flown.logs]
    return min(recorded)[1]


@dataclass(frozen=True)
class Replay:
    """All flights of a page.

    Attributes:
        scene: one flight of each set of parameters in full, and how the others ended.
        efforts: for each of these flights, the effort of its commands and of the reference's inputs.
        sensitivity: of the best parameters; None where it was not flown.
        robustness: of the best parameters under other conditions; empty where it was not flown.
    """

    scene: Scene
    efforts: tuple[tuple[Effort, Effort], ...]
    sensitivity: Sensitivity | None
    robustness: tuple[Robustness, ...]

    @property
    def errors(self) -> dict[str, float]:
        """[m] mean tracking error of the flights that passed every gate, by the label of their parameters; NaN where none did."""
        return {repeats.label: repeats.mean_error for repeats in self.scene.repeats}


def replay_finished(
    configuration: Configuration, world: World, best: Parameters, *, robustness: bool | None = None, hold: str = ""
) -> Replay:
    """Fly everything that the page of a finished study shows.

    Args:
        configuration: of the study.
        world: where its flights happen.
        best: shape (S, K).
        robustness: whether other conditions are flown; None: where the world can, and is not slow.
        hold: conditions that were asked for; they are flown wherever the world can.
    """
    scenario, settings = _judged(configuration.scenario), configuration.settings
    flights = IN_SIMULATORS if is_slow(world) else FLIGHTS
    sets, seeds = choose(scenario, configuration.first_guess, best), _seeds(configuration, flights)
    before = time.perf_counter()
    flown = _fly(scenario, world, sets, seeds)
    slow = is_slow(world) or time.perf_counter() - before > SLOW * len(flown)
    checked: tuple[Robustness, ...] = ()
    asked = parse_hold(hold)
    if world.takes_vehicle_parameters and (asked or (not slow if robustness is None else robustness)):
        as_tuned = score(flown, scenario.race.judge).rows(slice(0, FLIGHTS))  # the best come first
        checked = check_robustness(scenario, world, settings.goal, best, settings.seed, FLIGHTS, as_tuned, asked, explained=not slow)
    sensitivity = None if slow else survey_sensitivity(scenario, world, best, settings.seed, configuration.metric)
    scene = _stage(scenario, flown, sets)
    return Replay(scene, _efforts(scene, scenario), sensitivity, checked)


def replay_running(configuration: Configuration, world: World, best: Parameters) -> Replay:
    """Fly what the page shows while the study is still running: fewer flights, no sensitivity, no robustness."""
    scenario = _judged(configuration.scenario)
    sets = choose(scenario, configuration.first_guess, best)
    scene = demonstrate(scenario, world, sets, _seeds(configuration, WHILE_RUNNING))
    return Replay(scene, _efforts(scene, scenario), None, ())


def _seeds(configuration: Configuration, flights: int) -> NDArray[np.int64]:
    return flight_seeds(configuration.settings.seed, Stream.DEMONSTRATION, 0, flights)


def _efforts(scene: Scene, scenario: Scenario) -> tuple[tuple[Effort, Effort], ...]:
    return tuple(effort_of(trace, scenario) for trace in scene.traces)


def _judged(scenario: Scenario) -> Scenario:
    """The same scenario, in which a flight ends at the first missed gate; up to there it is the same flight."""
    judge = scenario.race.judge.model_copy(update={"fly_on": False})
    return replace(scenario, race=scenario.race.model_copy(update={"judge": judge}))
