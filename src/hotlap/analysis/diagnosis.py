"""Diagnosis: why parameters fail, found in the logs of flights that failed, and proved by flights without the cause."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import PlanningError
from hotlap.core.parameters import Parameters
from hotlap.core.records import Flights
from hotlap.core.shown import Shown
from hotlap.core.success_rate import Validation
from hotlap.feasibility.causes import SYMPTOMS, Case, Cure, FailureCause, Suspicion, suspect
from hotlap.feasibility.margins import margin
from hotlap.feasibility.signs import Signs, signs_of
from hotlap.feasibility.weights import none_helps, suspect_weights
from hotlap.feasibility.where import where_most_fail
from hotlap.planning.preparation import prepare
from hotlap.race.conditions import UNCHANGED, Condition
from hotlap.race.race import Race
from hotlap.reference.scenario import Scenario
from hotlap.tuning.goal import Goal
from hotlap.tuning.scoring import score
from hotlap.worlds.world import World

MOST = 3  # causes that are told
LOOKED_AT, FAILED = 16, 8  # flights whose logs are read, and how many of them are ones that failed
FLIGHTS = 12  # of each trial
HELPS = 0.25  # share of the flights by which a trial has to be better
CHEAP = 5.0  # s of planning
ENOUGH = 0.5  # share of the flights of a trial, below which it has not removed what makes them fail
ALL = 0.95  # share that is enough, however many held before
ALIKE = 0.1  # difference of two shares that says little

Replan = Callable[[Race], Scenario]


def cheap_replan(scenario: Scenario) -> Replan | None:
    """What plans a race like the scenario's anew; None where its reference was read, or planning takes long."""
    return prepare if 0 < scenario.reference.cpu_time < CHEAP else None


@dataclass(frozen=True, repr=False)
class Diagnosis(Shown):
    """A cause of failures, and what to do about it.

    Attributes:
        cause: why flights fail.
        found: by which sign, in words.
        advice: what to do, in words.
        tried: flights without the cause that met the goal; None where that was not flown.
        supposed: what was only supposed in these flights, in words; "" where the advice itself was flown.
        passed: how many of them passed the gate at which most had failed, where that is many more than before; else 0.
        gate: the name of that gate; "" where flights failed that passed all.
        before: how many of the same flights met the goal with the cause.
        change: what the advice changes, in words that do not recommend it; "": the advice itself.
    """

    cause: FailureCause
    found: str
    advice: str
    tried: Validation | None = None
    supposed: str = ""
    passed: int = 0
    gate: str = ""
    before: int = 0
    change: str = ""

    @property
    def rate(self) -> float:
        """Share of the flights without the cause that met the goal [-]; -1 where that was not flown."""
        return -1.0 if self.tried is None else self.tried.rate

    @property
    def rank(self) -> tuple[int, float, int, float]:
        """Larger is better: what helps, then what was not flown, then what does not help.

        Of those that help: how many flights without the cause held where these are enough, else how many got further, then held.
        """
        standing = 0 if self.tried is None else 1 if self.helps else -1
        return standing, self.rate if self.rate >= ENOUGH else 0.0, self.passed, self.rate

    @property
    def helps(self) -> bool:
        """Whether more flights held without the cause than with it, or many got further; True where that was not flown.

        Where some held anyway, hardly more than these are none.
        """
        if self.tried is None or self.passed:
            return True
        return self.tried.successes - self.before > (ALIKE * self.tried.flights if self.before else 0)

    @property
    def words(self) -> str:
        """In one line."""
        advice = self.advice if self.helps else f"{self.named} alone does not help"
        return f"{self.cause}: {self.found}; {advice}{f' ({self.proof})' if self.proof else ''}"

    @property
    def named(self) -> str:
        """What the advice changes, in words that do not recommend it."""
        return self.change or self.advice

    @property
    def proof(self) -> str:
        """What the trial gave, in words."""
        if self.tried is None:
            return ""
        supposed = f" {self.supposed}" if self.supposed else ""
        holding, flights = self.tried.successes, self.tried.flights
        if self.rate >= ENOUGH or not self.helps:
            return f"{holding} of {flights} flights hold{supposed}"
        further = f"{self.passed} of {flights} flights pass {self.gate}{supposed}, {holding or 'none'} of them to the end"
        return f"{further if self.passed else f'{holding} of {flights} flights hold{supposed}'}: not enough by itself"

    def dump(self) -> dict[str, Any]:
        """As plain JSON."""
        tried = None if self.tried is None else {"flights": self.tried.flights, "successes": self.tried.successes}
        trial = {"tried": tried, "supposed": self.supposed, "passed": self.passed, "gate": self.gate, "before": self.before}
        return {"cause": str(self.cause), "found": self.found, "advice": self.advice, **trial}


def diagnose(
    scenario: Scenario,
    world: World,
    parameters: Parameters,
    seeds: NDArray[np.int64],
    goal: Goal | None = None,
    condition: Condition = UNCHANGED,
    *,
    before: float | None = None,
    replan: Replan | None = None,
) -> tuple[Diagnosis, ...]:
    """Why parameters fail, the likeliest cause first, at most three; none where they do not fail.

    Each suspicion is tried: the same flights without the cause. What does not help is not told, unless figures prove it or nothing helps;
    what could not be flown is told before that.
    Only what lies before the place at which most of them fail is a cause; where nothing helps, other weights are tried as well, and where
    none of those helps either, the one advice is to look at the flights.

    Args:
        scenario: that is flown.
        world: one that takes vehicle parameters for each flight.
        parameters: shape (S, K).
        seeds: of the flights, shape (B,); a dozen are enough.
        goal: what counts as a success; None: all gates.
        condition: under which they are flown.
        before: share of flights that meet the goal, where more than these were flown.
        replan: plans a race anew; None: no other plan is tried.
    """
    trial = _Trial(scenario, world, parameters, seeds, goal or Goal(), replan)
    case = trial.case(condition)
    if case is None:
        return ()
    known = 1 - float(case.failed.mean()) if before is None else before
    helps, suspicions = min(known + HELPS, ALL), suspect(case)
    tested = [trial.test(case, suspicion, helps) for suspicion in suspicions]
    proved = [one for one in tested if one.rate >= helps]
    certain = [one for one, suspicion in zip(tested, suspicions, strict=True) if suspicion.certain]
    roots = sorted((one for one in proved if one.cause not in SYMPTOMS and one not in certain), key=lambda one: -one.rate)
    told = _each_once(without_symptoms([*certain, *roots, *(one for one in proved if one.cause in SYMPTOMS)]))
    if proved or certain:
        return tuple(told[:MOST])
    weights = trial.test(case, suspect_weights(case, parameters), helps)
    best = max((*tested, weights), key=lambda one: one.rank)
    vain = best is weights and not weights.helps
    return (replace(weights, advice=none_helps(weights.gate), change="", tried=None) if vain else best,)


def without_symptoms(diagnoses: Sequence[Diagnosis]) -> list[Diagnosis]:
    """Causes without those symptoms that vanish with another cause as well.

    Args:
        diagnoses: each with the flights of its trial.
    """
    best = max((one.rate for one in diagnoses if one.cause not in SYMPTOMS), default=-1.0)
    return [one for one in diagnoses if one.cause not in SYMPTOMS or one.rate > best + ALIKE]


def _each_once(diagnoses: Sequence[Diagnosis]) -> list[Diagnosis]:
    """Those whose cause and advice none before them has."""
    seen = [{word for before in diagnoses[:i] for word in (before.cause, before.advice)} for i in range(len(diagnoses))]
    return [one for one, before in zip(diagnoses, seen, strict=True) if not {one.cause, one.advice} & before]


def telling(seeds: NDArray[np.int64], failed: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Seeds of flights that tell most: some that failed, then others, sixteen at most.

    Args:
        seeds: of flights that were flown, shape (B,).
        failed: shape (B,) which of them failed.
    """
    first = np.flatnonzero(failed)[:FAILED]
    others = np.setdiff1d(np.arange(len(seeds)), first)
    return seeds[np.concatenate([first, others])[:LOOKED_AT].astype(np.int64)]


def diagnose_logs(
    scenario: Scenario, flights: Flights, failed: NDArray[np.bool_], condition: Condition = UNCHANGED
) -> tuple[Diagnosis, ...]:
    """The same from the logs that there are, where no further flight is to be flown.

    Args:
        scenario: that was flown.
        flights: with the logs of some.
        failed: shape (B,) which of them failed.
        condition: under which they were flown.
    """
    case = _case(scenario, flights, failed, condition, true=False)
    if case is None:
        return ()
    return tuple(Diagnosis(one.cause, one.found, one.cures[0].advice, change=one.cures[0].change) for one in suspect(case)[:MOST])


@dataclass(frozen=True)
class _Trial:
    """Flights of the same parameters with the same seeds, as they are and without a cause."""

    scenario: Scenario
    world: World
    parameters: Parameters
    seeds: NDArray[np.int64]
    goal: Goal
    replan: Replan | None

    def case(self, condition: Condition) -> Case | None:
        """What failed, with the logs of some; None where nothing did."""
        race = self.scenario.race
        noisy = replace(self.scenario, race=race.model_copy(update={"noise": condition.noise(race.noise)}))
        row = Case.row(self.scenario, condition)
        flights = self._fly(noisy, row, self.seeds, log=len(self.seeds))
        return _case(self.scenario, flights, ~self._succeeded(noisy, flights), condition)

    def test(self, case: Case, suspicion: Suspicion, helps: float) -> Diagnosis:
        """A suspicion with the first of its cures that helps, by the share of flights that hold then; or the one that helps most."""
        tried = [self._try(case, suspicion, cure) for cure in suspicion.cures]
        return next((one for one in tried if one.rate >= helps), max(tried, key=lambda one: one.rank))

    def _try(self, case: Case, suspicion: Suspicion, cure: Cure) -> Diagnosis:
        """A suspicion with what flights with one of its cures gave, where that can be flown."""
        seeds = self.seeds[:FLIGHTS]
        held = int((~case.failed[: len(seeds)]).sum())
        told = Diagnosis(suspicion.cause, suspicion.found, cure.advice, None, cure.supposed, 0, case.where.name, held, cure.change)
        scenario = replace(self.scenario, race=cure.race)
        if cure.replanned:
            try:
                scenario = scenario if self.replan is None else self.replan(cure.race)
            except PlanningError:
                return told
            if self.replan is None or len(scenario.segments) != len(self.scenario.segments):
                return told
        flights = self._fly(scenario, cure.vehicle_parameters, seeds, parameters=cure.parameters)
        told = replace(told, tried=Validation(len(flights), int(self._succeeded(scenario, flights).sum())))
        further, before = (int((one.gates_passed[: len(seeds)] > case.where.gate).sum()) for one in (flights, case.flights))
        more = bool(case.where.name) and further >= before + HELPS * len(seeds)
        return replace(told, passed=further * more)

    def _succeeded(self, scenario: Scenario, flights: Flights) -> NDArray[np.bool_]:
        return self.goal.succeeded(score(flights, scenario.race.judge))

    def _fly(
        self, scenario: Scenario, row: NDArray[np.float64], seeds: NDArray[np.int64], log: int = 0, parameters: Parameters | None = None
    ) -> Flights:
        flown = self.parameters if parameters is None else parameters
        repeated, rows = np.repeat(flown[None], len(seeds), axis=0), np.repeat(row[None], len(seeds), axis=0)
        return self.world.fly(scenario, repeated, seeds, vehicle_parameters=rows, log=range(log))


def _case(scenario: Scenario, flights: Flights, failed: NDArray[np.bool_], condition: Condition, *, true: bool = True) -> Case | None:
    """What is known of flights that failed, from the logs of those that did where most did; None where there are none of any use.

    Where there is no log of these, the next most common place at which flights failed counts.
    """
    rest = failed
    while rest.any():
        where = where_most_fail(scenario.race, flights, rest)
        read = [signs_of(scenario, log, float(where.times[i])) for i, log in flights.logs.items() if where.flights[i]]
        signs = [one for one in read if one is not None]
        if signs:
            left = margin(scenario.race, scenario.reference, condition, offset_free=scenario.offset_free, until=where.time)
            return Case(scenario, where, Signs.median(signs), left, flights, failed, condition, true)
        rest = rest & ~where.flights
    return None
