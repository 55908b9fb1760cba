"""Causes: why flights fail, by the signs that their logs show, and what would remove each cause.

A cause is suspected by a sign, and each suspicion names what would remove it. Whether that helps is for flights to say
(`analysis.diagnosis`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters
from hotlap.core.records import Flights
from hotlap.feasibility.explanation import help_with, verdict_on
from hotlap.feasibility.margins import Margin, margin
from hotlap.feasibility.race import SAME_MASS, missing_mass
from hotlap.feasibility.signs import BEFORE, Signs
from hotlap.feasibility.where import Where
from hotlap.race.conditions import UNCHANGED, Condition
from hotlap.race.controller_kind import ControllerKind
from hotlap.race.race import GateRule, PlanDynamics, Race
from hotlap.race.vehicle_parameters import VEHICLE_PARAMETERS, scale, vehicle_parameters_of
from hotlap.reference.scenario import Scenario
from hotlap.reference_files.thrust_vectors import drag

UNKNOWN = 0.05  # share of the thrust that a controller should know of
LATER = 0.008  # s of dead time that matter
READ = 0.03  # s of dead time that are no error of reading a log
FELT = 1.0  # m/s^2 of drag
OFTEN = 10.0  # jumps a second: no manoeuvre asks for them
MOSTLY = 0.5  # of the time
STRONGER, SURELY = 1.4, 1.25  # rotors, and the margin that they give at least, to see whether thrust is what is lacking
WIDER = 1.5  # gates, to see whether room is
CALMER = 0.85  # of the thrust that the plan takes
DAMPED = (1.0, 10.0, 10.0)  # factors of `controller.input_weights`
LEAD = 0.5  # of the lag
SAME_SPEED = 0.99  # share of the top speed that is all of it

Floats = NDArray[np.float64]


class FailureCause(StrEnum):
    """Why flights fail; those of `SYMPTOMS` may be symptoms of the others. The weights are looked at where it is nothing else."""

    NO_MARGIN = "no thrust left"
    UNKNOWN_FORCE = "unknown force"
    DEAD_TIME = "unknown dead time"
    CHATTERING = "chattering"
    SATURATED = "saturated from the start"
    LATE = "late at the gate"
    OPENING = "opening too small"
    WEIGHTS = "weights"


SYMPTOMS = (FailureCause.SATURATED, FailureCause.LATE, FailureCause.OPENING)


@dataclass(frozen=True)
class Cure:
    """What would remove a cause.

    Attributes:
        advice: what to do, in words.
        change: what that changes, in words that do not recommend it.
        race: with it; its vehicle is replaced by `vehicle_parameters`.
        vehicle_parameters: shape (P,) of the vehicle that flies.
        replanned: whether the race has to be planned anew.
        supposed: what is only supposed for a trial, in words: "with stronger rotors"; "" where the advice itself is tried.
        parameters: shape (S, K), that fly in place of those that failed; None: the same ones.
    """

    advice: str
    change: str
    race: Race
    vehicle_parameters: Floats
    replanned: bool = False
    supposed: str = ""
    parameters: Parameters | None = None


@dataclass(frozen=True)
class Suspicion:
    """A cause that is likely.

    Attributes:
        cause: of the failures.
        found: by which sign, in words.
        cures: what would remove it, the best first; at least one.
        certain: whether figures alone prove it.
    """

    cause: FailureCause
    found: str
    cures: tuple[Cure, ...]
    certain: bool = False


@dataclass(frozen=True)
class Case:
    """Flights that failed, and what is known of them.

    Attributes:
        scenario: that was flown.
        where: most of those that failed did.
        signs: in the logs of some that failed there.
        margin: of thrust, until then.
        flights: all of them.
        failed: shape (B,) which of them failed.
        condition: under which they were flown.
        true: whether the vehicle that flew is the one of the race; else what it weighs is read from the logs.
    """

    scenario: Scenario
    where: Where
    signs: Signs
    margin: Margin
    flights: Flights
    failed: NDArray[np.bool_]
    condition: Condition = UNCHANGED
    true: bool = True

    @property
    def planned(self) -> bool:
        """Whether the reference was planned, and not read."""
        return self.scenario.reference.cpu_time > 0

    @property
    def race(self) -> Race:
        """Of the scenario, with the noise of the condition."""
        race = self.scenario.race
        return race.model_copy(update={"noise": self.condition.noise(race.noise)})

    @property
    def vehicle_parameters(self) -> Floats:
        """Of the vehicle that flew, shape (P,)."""
        return self.row(self.scenario, self.condition)

    @staticmethod
    def row(scenario: Scenario, condition: Condition) -> Floats:
        """Vehicle parameters of a scenario under a condition, shape (P,)."""
        return condition.vehicle_parameters(vehicle_parameters_of(scenario.race.vehicle))

    @property
    def top_speed(self) -> float:
        """[m/s] of the reference, until most flights fail."""
        return self.where.top_speed(self.scenario.reference)

    @property
    def at_top_speed(self) -> str:
        """Where that is, in words."""
        fastest = self.top_speed >= SAME_SPEED * self.scenario.reference.max_speed
        return "at top speed" if fastest else f"at {self.top_speed:.1f} m/s"

    def vehicle(self, name: str) -> float:
        """One of them."""
        return float(self.vehicle_parameters[VEHICLE_PARAMETERS.index(name)])

    def cure(self, change: str, race: Race, *, replanned: bool = False) -> Cure:
        """One that sets keys of the race alone."""
        return Cure(f"set {change}", change, race, self.vehicle_parameters, replanned)


def suspect(case: Case) -> tuple[Suspicion, ...]:
    """What is likely to be the cause of failures, the likeliest first.

    Args:
        case: flights of which some failed.
    """
    looked_for = (_no_margin, _dead_time, _unknown_force, _chattering, _saturated, _late, _opening)
    return tuple(suspicion for look in looked_for for suspicion in look(case))


def _no_margin(case: Case) -> Iterator[Suspicion]:
    """Less thrust than the reference needs."""
    scenario, found = case.scenario, case.margin
    if found.enough:
        return
    lap = margin(scenario.race, scenario.reference, case.condition, offset_free=scenario.offset_free)
    stronger = max(STRONGER, SURELY / lap.thrust)
    race, row = case.race, scale(case.vehicle_parameters, ("rotor_thrust_max",), stronger)
    low, high = race.controller.thrust
    race = _knowing(race, mass=case.vehicle("mass"))
    race = _controlled(race, thrust=(low, stronger * high))
    helps = help_with(scenario.race, scenario.reference, lap, planned=case.planned)  # what helps has to do so to the end
    cures = [Cure(helps.advice, helps.change, race, row, supposed="with enough of it")]
    if not case.scenario.offset_free and _estimated(case).thrust > 1:
        cures.insert(0, case.cure("controller.offset_free = true", _controlled(case.race, offset_free=True)))
    yield Suspicion(FailureCause.NO_MARGIN, verdict_on(found), tuple(cures), certain=found.lacking)


def _estimated(case: Case) -> Margin:
    """The margin of a controller that estimates its thrust."""
    return margin(case.scenario.race, case.scenario.reference, case.condition, offset_free=True)


def _dead_time(case: Case) -> Iterator[Suspicion]:
    """Dead time that the controller does not predict over."""
    race, delay = case.race, case.vehicle("delay") if case.true else case.signs.dead_time
    unknown = delay - (race.control_model.delay if race.controller.predict else 0.0)
    if unknown < (LATER if case.true else READ):
        return
    far = unknown * case.top_speed
    found = f"{unknown * 1e3:.0f} ms that the controller does not know of, {far:.2f} m {case.at_top_speed}"
    if race.controller.predict:
        cure = case.cure(f"model.delay = {delay:g}", _knowing(race, delay=delay))
    else:
        cure = case.cure("controller.predict = true", _controlled(_knowing(race, delay=delay), predict=True))
    yield Suspicion(FailureCause.DEAD_TIME, found, (cure,))


def _unknown_force(case: Case) -> Iterator[Suspicion]:
    """Thrust that does more or less than the controller takes for granted, a drone that weighs more or less, or a steady wind."""
    race, wind = case.race, case.race.noise.steady_wind
    weight = case.vehicle("mass") / race.control_model.mass
    acted = 1 / weight if case.true else case.signs.effectiveness
    known = not abs(acted - 1) > UNKNOWN  # a NaN says nothing
    resisted = _unknown_drag(case)
    if case.scenario.offset_free or (known and not wind and resisted < FELT):
        return
    height = f"{abs(case.signs.above):.2f} m too {'low' if case.signs.above < 0 else 'high'}"
    gives = f"a command gives {acted:.0%} of the thrust that the controller takes for granted"
    blown = f"a wind pushes with {wind:g} m/s^2" if wind else f"drag takes {resisted:.1f} m/s^2 {case.at_top_speed}"
    pushed = f"{blown}, of which the controller does not know" if known else gives
    cures = [case.cure("controller.offset_free = true", _controlled(race, offset_free=True))]
    if not known:
        knowing = _knowing(race, mass=case.vehicle("mass"))
        if not case.condition.changes and abs(missing_mass(race)) > SAME_MASS:
            cures.append(case.cure(f"model.mass = {case.vehicle('mass'):g}", knowing))
        else:
            measure, known = "weigh the drone, measure its thrust", "to know mass and thrust"
            cures.append(Cure(measure, known, knowing, case.vehicle_parameters, supposed="with it known"))
    yield Suspicion(FailureCause.UNKNOWN_FORCE, f"{pushed}; the drone ends {height}", tuple(cures))


def _unknown_drag(case: Case) -> float:
    """Deceleration [m/s^2] by drags that the controller does not make up for, level and at the top speed of the reference."""
    race, level, ahead = case.race, np.array([[1.0, 0.0, 0.0, 0.0]]), np.array([[case.top_speed, 0.0, 0.0]])
    acts, believed = (drag(one, level, ahead, np.array([one.gravity])) for one in (race.vehicle, race.control_model))
    knows = race.controller.reference_drag or race.controller.kind is ControllerKind.MPC_DRAG
    return float(np.linalg.norm(acts - believed * knows))


def _chattering(case: Case) -> Iterator[Suspicion]:
    """Rate commands that jump between their limits."""
    signs, race = case.signs, case.race
    if signs.jumps < OFTEN:
        return
    found = f"rate commands jump by more than their limit {signs.jumps:.0f} times a second"
    found += ", with the thrust at its own" if signs.saturated > MOSTLY else ""
    weights = tuple(float(a * b) for a, b in zip(race.controller.input_weights, DAMPED, strict=True))
    written = ", ".join(f"{weight:g}" for weight in weights)
    cure = case.cure(f"controller.input_weights = [{written}]", _controlled(race, input_weights=weights))
    yield Suspicion(FailureCause.CHATTERING, found, (cure,))


def _saturated(case: Case) -> Iterator[Suspicion]:
    """Thrust at its limit from the first moment on."""
    signs, race = case.signs, case.race
    if signs.saturated_first < MOSTLY or not case.planned:
        return
    found = f"thrust is at its limit in {signs.saturated_first:.0%} of the first half second"
    cures = []
    if race.planning.dynamics is PlanDynamics.IDEAL:
        full = race.model_copy(update={"planning": race.planning.model_copy(update={"dynamics": PlanDynamics.FULL})})
        words = 'planning.dynamics = "full"'
        if race.controller.predict and race.controller.lag_lead < LEAD:
            full, words = _controlled(full, lag_lead=LEAD), f"{words} and controller.lag_lead = {LEAD:g}"
        cures.append(case.cure(words, full, replanned=True))
    cures += _calmer(case)
    if cures:
        yield Suspicion(FailureCause.SATURATED, found, tuple(cures))


def _late(case: Case) -> Iterator[Suspicion]:
    """Lag that the controller does not make up for, and a drone behind the reference on its path."""
    signs, race = case.signs, case.race
    if race.controller.predict and race.controller.lag_lead < LEAD:
        found = f"rates follow {race.control_model.lag * 1e3:.0f} ms behind their commands, and the controller makes up for little of it"
        lead = case.cure(f"controller.lag_lead = {LEAD:g}", _controlled(race, lag_lead=LEAD))
        yield Suspicion(FailureCause.LATE, found, (lead,))
    if not signs.behind:
        return
    speed = max(case.where.mean_speed(case.scenario.reference, BEFORE), 0.1)
    found = f"{-signs.along:.2f} m behind on the path at the end, {-signs.along / speed * 1e3:.0f} ms, and {signs.aside:.2f} m beside it"
    cures = []
    if not case.scenario.offset_free:
        cures.append(case.cure("controller.offset_free = true", _controlled(race, offset_free=True)))
    cures += _calmer(case)
    if race.judge.rule is GateRule.CLOCK:
        judge = race.judge.model_copy(update={"rule": GateRule.CLOSEST})
        closest = case.cure('judge.rule = "closest"', race.model_copy(update={"judge": judge}))
        cures.append(replace(closest, advice=f"where being on time does not count, {closest.advice}"))
    if cures:
        yield Suspicion(FailureCause.LATE, found, tuple(cures))


def _opening(case: Case) -> Iterator[Suspicion]:
    """Gates that leave less room than flights spread."""
    race, flights = case.race, case.flights
    gate, name = case.where.gate, case.where.name
    if not name:
        return
    room, measured = float(flights.rooms[gate]), flights.clock_distance[:, gate]
    if race.judge.rule is GateRule.OPENING and np.isfinite(flights.rim_distance[:, gate]).any():
        measured = flights.rim_distance[:, gate] + room
    elif race.judge.rule is not GateRule.CLOCK:
        measured = flights.closest_distance[:, gate]
    there = measured[np.isfinite(measured)]
    if not len(there):
        return
    near, far = np.percentile(there, (10, 90))
    if near > WIDER * room:  # a wider gate would not do
        return
    found = f"{name} leaves {room:.2f} m, and most flights pass at {near:.2f} to {far:.2f} m from its middle"
    judge = race.judge.model_copy(update={"distance": WIDER * race.judge.distance})
    small = race.vehicle.model_copy(update={"radius": max(race.vehicle.outer_radius - (WIDER - 1) * room, 0.0)})
    wide = race.model_copy(update={"judge": judge, "vehicle": small} if race.judge.rule is GateRule.OPENING else {"judge": judge})
    more = f"{(WIDER - 1) * room:.2f} m more of room"
    wider = Cure(f"give the gates {more}", more, wide, case.vehicle_parameters, supposed="with so much more room")
    yield Suspicion(FailureCause.OPENING, found, (*_calmer(case), wider))


def _calmer(case: Case) -> list[Cure]:
    """A plan that takes less of the thrust, where the race plans by a share."""
    race = case.race
    if not case.planned or race.planning.quadrotor is not None:
        return []
    share = round(CALMER * race.planning_model.max_acceleration / race.control_model.max_acceleration, 2)
    calm = race.model_copy(update={"planning": race.planning.model_copy(update={"thrust_share": share})})
    return [case.cure(f"planning.thrust_share = {share:g}", calm, replanned=True)]


def _knowing(race: Race, **known: float) -> Race:
    """The race, whose controller knows something about its vehicle."""
    return race.model_copy(update={"model": race.control_model.model_copy(update=known)})


def _controlled(race: Race, **settings: object) -> Race:
    """The race with other settings of its controller."""
    return race.model_copy(update={"controller": race.controller.model_copy(update=settings)})
