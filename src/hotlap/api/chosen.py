"""Chosen: the plan of a race that fixes none: the boldest that its tuned controller holds, each tuned in a study of its own.

The plans share out the flights of the budget, or its minutes, planning and compiling included: each may take a quarter, and is given up
earlier where no candidate passes half of the gates. The study of the chosen one becomes that of the race, with all that is left.
"""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable
from contextlib import nullcontext, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from hotlap.analysis.boldest import find_boldest, shares_of
from hotlap.analysis.robustness import HELD, fly_conditions
from hotlap.api.asked import Asked
from hotlap.api.flown import FlightsResult
from hotlap.api.scenarios import make_ready
from hotlap.api.slow_flights import followed
from hotlap.api.wording import percent
from hotlap.core.counts import count
from hotlap.core.errors import PlanningError
from hotlap.core.parameters import Parameters
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.race.hold import parse_hold
from hotlap.race.race import Race
from hotlap.study.configuration import Configuration
from hotlap.study.database import FILE, is_begun
from hotlap.study.study import Study
from hotlap.study.tried_plan import TriedPlan, chosen_of
from hotlap.tuning.candidate import Candidate
from hotlap.tuning.goal import Quantity
from hotlap.tuning.loop import Batch, TuningSettings
from hotlap.tuning.objective import Objective
from hotlap.tuning.shared_time import SharedTime
from hotlap.worlds.built_in import BuiltIn
from hotlap.worlds.world import World, is_slow

PLANS = "plans"  # folder of the studies of all plans, within that of the race
CALMER = 0.97  # of a share of the thrust, for a plan to be called calmer
PARTS = 4  # of the budget, and of the minutes: what one plan may take at most
SHORTEST = 0.01  # minutes of a study
MORE = 1.05  # times what the search of the chosen plan has had, at least, for its result to be chosen as that of any other is
FEWEST = 20  # flights of a plan beside its re-flights
PATIENCE, HALF = 24, 0.5  # flights after which a plan is given up where no candidate has passed this share of the gates
UNSEEN = 300_000  # first of the flights that tell whether parameters hold: nothing was chosen by their noise
CHOOSES = "a calmer plan: where a race leaves planning.thrust_share out, a tuning chooses the boldest that its controller holds"
TOLD, TOLD_IN_SIMULATORS = 50, 10  # flights that tell how a plan fails

Configure = Callable[[Race, TuningSettings], Configuration]


def leaves_open(race: Race, settings: TuningSettings, asked: Asked) -> bool:
    """Whether a plan is to be chosen: none is fixed or read, and the flights are enough to tell one that holds."""
    enough = settings.budget >= settings.confirm + FEWEST and settings.validation > 0
    return race.planning.free and asked.reference is None and settings.goal.quantity is not Quantity.NONE and enough


def minutes_beside(settings: TuningSettings, beside: float) -> float:
    """Minutes of the search of the chosen plan, where choosing took so many seconds beside it; 0 where time is not counted."""
    return settings.minutes and max(settings.minutes - beside / 60, SHORTEST)


def plan_of(folder: Path) -> tuple[float | None, tuple[TriedPlan, ...], float]:
    """The share of the thrust that a study's race is planned with, the plans that were tried, and [s] what else choosing it took."""
    with Study.read(folder) as study:
        return study.configuration.scenario.race.planning.thrust_share, tuple(study.plans), study.beside


def choose_plan(
    race: Race, world: World, settings: TuningSettings, configure: Configure, folder: Path, asked: Asked
) -> tuple[Configuration, tuple[TriedPlan, ...]]:
    """How a race is tuned with the plan that is chosen for it, and the plans that were tried.

    Raises:
        PlanningError: there is no plan with any share of the thrust.
    """
    choice = PlanChoice(race, world, settings, configure, folder, asked)
    chosen = choice.choose()
    return (configure(race, settings), ()) if chosen is None else (choice.settle(chosen), tuple(choice.plans))


def advise_calmer(
    race: Race, world: World, settings: TuningSettings, configure: Configure, folder: Path, asked: Asked, spent: float
) -> tuple[str, ...]:
    """Which plan would hold where the one that a race fixes does not: calmer ones are tuned, in what is left of the minutes.

    Nothing where the plan is another's, where flights are not free, or in a search of some minutes that has taken them all.

    Args:
        race: that fixes its plan.
        world: where it is flown.
        settings: of the tuning.
        configure: plans a race, and says how it is tuned.
        folder: of the study.
        asked: what was asked for.
        spent: [s] of the minutes, on the plan that is fixed.
    """
    if race.planning.quadrotor is not None or asked.reference is not None or not isinstance(world, BuiltIn):
        return ()
    choice = PlanChoice(race, world, settings, configure, folder, asked, spent=spent)
    chosen = choice.choose(below=race.thrust_share * CALMER)
    if chosen is None:
        return (CHOOSES,) if settings.minutes and not choice.plans else ()
    if chosen.holds:
        beside = count(sum(plan.flights for plan in choice.plans), "flight")
        return (f"a calmer plan holds: planning.thrust_share = {chosen.share:g}: {chosen.lap_time:.2f} s (found in {beside} more)",)
    shares = ", ".join(f"{plan.share:g}" for plan in choice.plans)
    return (f"no calmer plan was found that holds (planning.thrust_share of {shares} tried)",)


@dataclass
class PlanChoice:
    """The search for the plan of a race.

    Attributes:
        race: which fixes none.
        world: where it is flown.
        settings: of the tuning; budget and minutes are those of all plans together.
        configure: plans a race, and says how it is tuned.
        folder: of the study.
        asked: what was asked for.
        spent: [s] of the minutes, before.
        clock: [s]
        plans: that were tried, in the order tried.
    """

    race: Race
    world: World
    settings: TuningSettings
    configure: Configure
    folder: Path
    asked: Asked
    spent: float = 0.0
    clock: Callable[[], float] = time.monotonic
    plans: list[TriedPlan] = field(default_factory=list)
    _configurations: dict[float, Configuration] = field(default_factory=dict, init=False)
    _time: SharedTime = field(init=False)

    def __post_init__(self) -> None:
        self._time = SharedTime(self.settings.minutes, PARTS, self.spent, self.clock)

    def choose(self, below: float = 1.0) -> TriedPlan | None:
        """Try plans that take less than a share of the thrust; None where there is none at all."""
        find_boldest(shares_of(self.race, below), self._attempt)
        return chosen_of(self.plans)

    @property
    def left(self) -> int:
        """Flights that no plan has taken."""
        return self.settings.budget - sum(plan.flights for plan in self.plans)

    @property
    def time_left(self) -> float:
        """[s] of the minutes that no plan has taken."""
        return self._time.left

    def settle(self, chosen: TriedPlan) -> Configuration:
        """Make the study of the chosen plan that of the race, with all flights, or all the time, that is left."""
        configuration, place = self._configurations[chosen.share], self.folder / PLANS / _name(chosen.share)
        with Study.open(place, configuration) as study:
            had = MORE * max(60 * configuration.settings.minutes, study.wall_time)
            beside = min(self._time.spent - study.wall_time, 60 * self.settings.minutes - had) if self.settings.minutes else 0.0
            study.record_plans(self.plans, beside)
        (place / FILE).replace(self.folder / FILE)
        shutil.rmtree(place, ignore_errors=True)
        with suppress(OSError):  # the others stay, to be looked at
            (self.folder / PLANS).rmdir()
        minutes = minutes_beside(self.settings, beside)
        left = {"budget": self.left + chosen.flights, "minutes": minutes, "selection": self.settings.selection}
        return replace(configuration, settings=replace(configuration.settings, **left))

    def _attempt(self, share: float) -> TriedPlan | None:
        """Plan with a share of the thrust, tune, and judge; None where too few flights, or too little time, are left."""
        budget = min(self.left, max(self.settings.budget // PARTS, self.settings.confirm + FEWEST))
        if budget < self.settings.confirm + FEWEST or not self._time.enough:
            return None
        try:
            configuration = self._prepare(share, replace(self.settings, budget=budget, selection=0))
        except PlanningError as error:
            tried = TriedPlan(share, None, 0, None, holds=False, end=f"there is no plan ({error.reason})")
        else:
            self._configurations[share] = configuration
            self._tune(share, configuration)
            with self._time.counted(), Study.read(self.folder / PLANS / _name(share)) as study:
                tried = self._judge(share, study)
        self.plans.append(tried)
        return tried

    def _prepare(self, share: float, settings: TuningSettings) -> Configuration:
        """Plan, compile what flies, and set how long the search may take; one that goes on has what it had."""
        known = self._minutes_of(share)
        before = self._time.spent
        with nullcontext() if known else self._time.planning():
            configuration = self.configure(self.race.with_share(share), settings)
        with nullcontext() if known else self._time.counted():
            make_ready(self.world, configuration.scenario, self.asked.progress)
        minutes = known or self._time.search(self._time.spent - before)
        return replace(configuration, settings=replace(configuration.settings, minutes=minutes if settings.minutes else 0.0))

    def _minutes_of(self, share: float) -> float:
        """Minutes of the study of a plan that was begun before; 0 where there is none."""
        place = self.folder / PLANS / _name(share)
        if not is_begun(place):
            return 0.0
        with Study.read(place) as study:
            return study.configuration.settings.minutes

    def _tune(self, share: float, configuration: Configuration) -> None:
        """Tune one plan as far as that makes sense."""
        settings = configuration.settings
        objective = Objective(configuration.scenario, self.world, configuration.metric, settings.randomise)
        with Study.open(self.folder / PLANS / _name(share), configuration) as study, suppress(_Hopeless):
            try:
                before = study.result
                if before is not None and _is_hopeless(before.flights, before.best):
                    raise _Hopeless
                flown, spent = (before.flights, before.wall_time) if before else (0, 0.0)
                with (
                    self.asked.progress.flights(settings.budget, flown, 60 * settings.minutes, spent) as watch,
                    followed(self.world, watch),
                ):
                    study.run(objective, _patient(watch), self.clock)
            finally:
                self._time.take(study.wall_time)

    def _judge(self, share: float, study: Study) -> TriedPlan:
        """Whether the best parameters hold, as tuned and under what was asked for; if not, how most flights end."""
        result, configuration = study.result, study.configuration
        assert result is not None, "it has flown"  # noqa: S101  our own mistake
        rate = None if result.validation is None else result.validation.rate
        lap = configuration.scenario.reference.lap_time
        told = TriedPlan(share, lap, result.flights, rate, holds=False)
        if not result.best.confirmed or rate is None or rate < HELD:
            return replace(told, end=_how_it_ends(configuration, self.world, result.best.parameters))
        lost = self._lost(configuration, result.best.parameters)
        return replace(told, holds=not lost, end=lost)

    def _lost(self, configuration: Configuration, parameters: Parameters) -> str:
        """Why parameters do not hold in flights that they were not chosen by, as tuned and under what was asked for; "" where they do."""
        settings, conditions = configuration.settings, parse_hold(self.asked.hold)
        seeds = flight_seeds(settings.seed, Stream.DEMONSTRATION, UNSEEN, settings.validation)
        objective = Objective(configuration.scenario, self.world, configuration.metric, settings.randomise)
        again = float(settings.goal.succeeded(objective.fly(np.repeat(parameters[None], len(seeds), axis=0), seeds)).mean())
        if again < HELD:
            return f"{percent(again)} of further flights succeed"
        flown = fly_conditions(configuration.scenario, self.world, parameters, seeds, conditions) if conditions else {}
        lost = [condition.name for condition, scores in flown.items() if settings.goal.succeeded(scores).mean() < HELD]
        return f"it does not hold under {', '.join(lost)}" if lost else ""


class _Hopeless(Exception):  # noqa: N818  no error
    """A plan of which no candidate passes enough gates."""


def _patient(watch: Callable[[Batch], None]) -> Callable[[Batch], None]:
    """What watches a search, and ends one that leads nowhere."""

    def see(batch: Batch) -> None:
        """Show a batch, and raise where the search is hopeless."""
        watch(batch)
        if _is_hopeless(batch.flights, batch.best):
            raise _Hopeless

    return see


def _is_hopeless(flights: int, best: Candidate) -> bool:
    """Whether a search has had its time, and no candidate passes enough gates."""
    return flights >= PATIENCE and best.completion < HALF and not best.confirmed


def _how_it_ends(configuration: Configuration, world: World, parameters: Parameters) -> str:
    """How most flights end that do not pass all gates: "31 of 50 flights missed gate 3"."""
    seeds = flight_seeds(configuration.settings.seed, Stream.DEMONSTRATION, 0, TOLD_IN_SIMULATORS if is_slow(world) else TOLD)
    flights, scores = Objective(configuration.scenario, world).fly_recorded(np.repeat(parameters[None], len(seeds), axis=0), seeds)
    return FlightsResult(configuration.scenario, world.name, parameters, flights, scores).commonest_end() or "too few flights succeed"


def _name(share: float) -> str:
    """Of the folder of a plan's study."""
    return f"{share:.2f}"
