"""Comparison: every tuner on every race with the same first guess, budget, seeds and noise; all seeds of a cell in lockstep."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap import tuners, worlds
from hotlap.analysis.robustness import check_robustness
from hotlap.core.parameters import Parameters, ParameterSpace
from hotlap.core.records import Scores
from hotlap.core.shown import Shown
from hotlap.first_guess.guess import DEFAULT, first_guess
from hotlap.planning.preparation import prepare
from hotlap.race.conditions import Condition
from hotlap.race.race import Race
from hotlap.reference.scenario import Scenario
from hotlap.reference.segmentation import SegmentationRule
from hotlap.study.configuration import Configuration
from hotlap.system.engine import is_one_of_many
from hotlap.system.journal import Journal
from hotlap.tuners.tuner import Tuner
from hotlap.tuning.loop import Batch, Tuning, TuningSettings, scenario_for, tune_together
from hotlap.tuning.objective import Objective
from hotlap.tuning.progress_curve import ProgressCurve
from hotlap.worlds.built_in import BuiltIn


@dataclass(frozen=True)
class Cell:
    """A tuner on a race, with some seeds.

    Attributes:
        race: what is flown.
        tuner: algorithm with preset.
        settings: of all its runs, but for the seed.
        seeds: of the runs.
        world: where.
        segments: how the reference is cut.
        first_guess: name of where its runs begin.
        reference: the CSV that is flown; None: the race's plan.
        hold: conditions that the result of each run is flown under.
        instances: simulators that fly side by side.
    """

    race: Race
    tuner: str
    settings: TuningSettings
    seeds: tuple[int, ...]
    world: str = worlds.DEFAULT
    segments: SegmentationRule = SegmentationRule.PAPER
    first_guess: str = DEFAULT
    reference: Path | None = None
    hold: tuple[Condition, ...] = ()
    instances: int = 1

    @cached_property
    def key(self) -> str:
        """Changes with everything that decides about a run, but for its seed and the source code."""
        tuner = tuners.build(self.tuner)
        scenario = scenario_for(prepare(self.race, self.reference, segments=self.segments), tuner)
        first, goal = first_guess(scenario, self.first_guess), self.settings.goal
        fingerprint = Configuration(scenario, self.world, goal.metric, tuner.name, self.settings, first).fingerprint
        held = "".join(f"-{condition.text}" for condition in self.hold)
        return f"{fingerprint}-{self.settings.budget}{held}"


Group = tuple[Cell, ...]
"""Cells whose flights may be flown together: of one race, cut by one rule, in one world, all with dense costs or none."""


@dataclass(frozen=True, repr=False)
class Run(Shown):
    """One run of a tuner on a race, from the first guess to its validation.

    Attributes:
        race: its name.
        tuner: algorithm with preset.
        seed: of the run.
        budget: flights that it was given.
        flights: that it took, re-flights included.
        search_flights: without re-flights, up to the confirmed candidate.
        confirmed: whether there was one.
        completion: mean over the flights of the best candidate.
        cost: likewise.
        lap_time: [s] likewise, over its complete flights; NaN without any.
        successes: of the validation.
        validation: its flights.
        tuner_time: [s] of the processor that the tuner itself took.
        curve: (flights, completion of the best candidate so far) wherever that changed; each flight counts at its own number.
        held: (condition in words, successes, flights) of the best candidate, as tuned and under each condition that was asked for.
    """

    race: str
    tuner: str
    seed: int
    budget: int
    flights: int
    search_flights: int
    confirmed: bool
    completion: float
    cost: float
    lap_time: float
    successes: int
    validation: int
    tuner_time: float
    curve: tuple[tuple[int, float], ...]
    held: tuple[tuple[str, int, int], ...] = ()

    @property
    def validated(self) -> float:
        """Share of the validation that succeeded, 0 to 1; 0 without one."""
        return self.successes / self.validation if self.validation else 0.0

    def completion_at(self, flights: int) -> float:
        """Completion of the best candidate after so many flights, 0 before the first."""
        known = [completion for when, completion in self.curve if when <= flights]
        return known[-1] if known else 0.0

    def dump(self) -> dict[str, Any]:
        """As plain JSON."""
        plain = {**vars(self), "curve": [list(point) for point in self.curve], "held": [list(row) for row in self.held]}
        return {key: None if isinstance(value, float) and not np.isfinite(value) else value for key, value in plain.items()}

    @staticmethod
    def load(plain: Mapping[str, Any]) -> Run:
        """The inverse of `dump`."""
        worst = {"cost": float("inf"), "lap_time": float("nan")}
        values = {key: worst[key] if value is None else value for key, value in plain.items()}
        curve = tuple((int(when), float(completion)) for when, completion in plain["curve"])
        return Run(**{**values, "curve": curve, "held": tuple((name, *counts) for name, *counts in plain.get("held", ()))})


class Timed:
    """A tuner with a clock: processor time spent in it, on one thread."""

    def __init__(self, tuner: Tuner) -> None:
        self._tuner = tuner
        self.name, self.settings, self.spent = tuner.name, tuner.settings, 0.0

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """As the tuner."""
        self._tuner.start(first_guess, space, rng)

    def ask(self, n: int) -> Parameters:
        """As the tuner, on the clock."""
        start = time.thread_time()
        asked = self._tuner.ask(n)
        self.spent += time.thread_time() - start
        return asked

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:
        """As the tuner, on the clock."""
        start = time.thread_time()
        accepted = self._tuner.tell(parameters, scores)
        self.spent += time.thread_time() - start
        return accepted

    def state(self) -> dict[str, Any]:
        """Nothing: an interrupted run of a comparison begins anew, so that no state needs to be kept for thousands of runs."""
        return {}

    def restore(self, state: dict[str, Any]) -> None:
        """Refused: no state has been kept."""
        raise NotImplementedError


class RunJournal(Journal):
    """Runs by the key of their cell and their seed, a line each."""

    file = "runs.jsonl"
    done: dict[tuple[str, int], Run]

    def _plain(self, key: tuple[str, int], value: Run) -> dict[str, Any]:
        return {"key": key[0], "run": value.dump()}

    def _parsed(self, plain: Any) -> tuple[tuple[str, int], Run]:
        run = Run.load(plain["run"])
        return (plain["key"], run.seed), run


@dataclass
class _Progress:
    """A run that is under way."""

    cell: Cell
    seed: int
    tuning: Tuning
    tuner: Timed
    curve: ProgressCurve = field(default_factory=ProgressCurve)


def fly_cells(cells: Group) -> Iterator[tuple[Cell, Run]]:
    """The runs of cells that share a scenario, as they end."""
    first = cells[0]
    scenario = scenario_for(prepare(first.race, first.reference, segments=first.segments), tuners.build(first.tuner))
    world = worlds.build(first.world, first.instances)
    if isinstance(world, BuiltIn) and is_one_of_many():
        world.threads = 1  # there is a worker for each processor
    objective = Objective(scenario, world, first.settings.goal.metric, first.settings.randomise)
    guesses = {name: first_guess(scenario, name) for name in {cell.first_guess for cell in cells}}
    runs = [_begin(cell, scenario, guesses[cell.first_guess], seed) for cell in cells for seed in cell.seeds]
    for i, batch in tune_together(objective, [run.tuning for run in runs]):
        runs[i].curve.follow(batch)
        if batch.done:
            yield runs[i].cell, _end(batch, runs[i], _fly_held(objective, runs[i], batch))


def _begin(cell: Cell, scenario: Scenario, guess: Parameters, seed: int) -> _Progress:
    """A run that has not flown yet."""
    tuner = Timed(tuners.build(cell.tuner))
    settings = TuningSettings(**{**vars(cell.settings), "seed": seed})
    return _Progress(cell, seed, Tuning(tuner, scenario, settings, guess), tuner)


def _fly_held(objective: Objective, progress: _Progress, batch: Batch) -> tuple[tuple[str, int, int], ...]:
    """The best candidate of a run under what was asked for; see `Run.held`."""
    cell, goal = progress.cell, progress.cell.settings.goal
    if not cell.hold:
        return ()
    asked = {"asked": cell.hold, "further": ()}
    rows = check_robustness(objective.scenario, objective.world, goal, batch.best.parameters, progress.seed, **asked)
    return tuple((row.change, row.validation.successes, row.validation.flights) for row in rows)


def _end(batch: Batch, progress: _Progress, held: tuple[tuple[str, int, int], ...]) -> Run:
    """The summary of a run that has ended."""
    cell, validation = progress.cell, batch.validation
    return Run(
        race=cell.race.name,
        tuner=progress.tuner.name,
        seed=progress.seed,
        budget=cell.settings.budget,
        flights=batch.flights,
        search_flights=batch.search_flights,
        confirmed=batch.best.confirmed,
        completion=batch.best.completion,
        cost=batch.best.cost,
        lap_time=batch.best.lap_time,
        successes=validation.successes if validation else 0,
        validation=validation.flights if validation else 0,
        tuner_time=progress.tuner.spent,
        curve=tuple(progress.curve.points),
        held=held,
    )


def flies_on(tuner: str) -> bool:
    """Whether a tuner's flights go on after a missed gate."""
    return bool(getattr(tuners.build(tuner).settings, "dense", False))


def budget_of(tuner: str, budgets: Mapping[str, int]) -> int:
    """The flights that a tuner is given: those of its name with preset, of its algorithm, or of all (under "")."""
    algorithm = tuner.partition(":")[0]
    return budgets.get(tuner, budgets.get(algorithm, budgets[""]))


def missing(cells: Sequence[Cell], done: Mapping[tuple[str, int], Run], processes: int) -> list[Group]:
    """Runs that are missing, in groups that are flown in lockstep, so that the lanes are full; the longest first.

    Args:
        cells: all that is asked for, with the same settings but for the budget.
        done: runs by key of their cell and seed.
        processes: there are at least so many groups, where there are so many runs.
    """
    groups: dict[tuple[str, bool, SegmentationRule], list[Cell]] = {}
    for cell in cells:
        key = cell.key
        seeds = tuple(seed for seed in cell.seeds if (key, seed) not in done)
        if seeds:
            groups.setdefault((cell.race.name, flies_on(cell.tuner), cell.segments), []).append(replace(cell, seeds=seeds))
    parts = -(-processes // len(groups)) if groups else 1
    divided = [
        tuple(replace(cell, seeds=cell.seeds[k::parts]) for cell in group if cell.seeds[k::parts])
        for group in groups.values()
        for k in range(parts)
    ]
    return sorted(filter(None, divided), key=lambda group: -sum(cell.settings.budget * len(cell.seeds) for cell in group))
