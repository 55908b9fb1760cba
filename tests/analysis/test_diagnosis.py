"""Why flights fail: small flights that fail for one cause each, really flown, and what removes it."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from flight.scenarios import TUNED, make_race, make_scenario
from hotlap.analysis.diagnosis import Diagnosis, diagnose, diagnose_logs, telling, without_symptoms
from hotlap.analysis.remedies import failures_of, what_to_try
from hotlap.core.success_rate import Validation
from hotlap.feasibility.causes import FailureCause
from hotlap.feasibility.margins import margin
from hotlap.files.descriptions import load_race
from hotlap.first_guess.guess import first_guess
from hotlap.planning.preparation import prepare
from hotlap.race.conditions import UNCHANGED
from hotlap.race.gate import Gate
from hotlap.race.hold import parse_hold
from hotlap.race.race import GateRule, PlanDynamics, Race
from hotlap.race.track import Track
from hotlap.reference.attitude import follow_axes, turn_rates
from hotlap.reference.reference import PERIOD, Reference
from hotlap.reference.scenario import Scenario
from hotlap.reference.segmentation import SegmentClass, Segments
from hotlap.worlds.built_in import BuiltIn

NOISE = {"position": 0.05, "thrust": 0.02, "rates": 0.1}
LOUD = {"position": 0.1, "velocity": 0.1, "thrust": 0.05, "rates": 0.3}
SLUGGISH = (1.0, 100.0, 1.0, 1.0, 1.0)  # weights: it hardly cares
RESTLESS = (32.5, 104.6, 9.7, 821.9, 1.7)  # weights: velocity at any price
SLOW = {"delay": 0.06, "rate_gain": (40.0, 40.0, 20.0), "motor_time": (0.06, 0.06)}
LAGGING = {"rate_gain": (8.0, 8.0, 4.0), "motor_time": (0.08, 0.08)}
WIDE = {"distance": 0.6}
SEEDS = np.arange(16)
EARLY = ("airsim-final-22", "airsim-final-21", "airsim-flip-16", "airsim-qualifier-20", "qualifier-20", "final-22")  # fail before their end
WORLD = BuiltIn(threads=1)


def dash(push: float, rise: float = 0.0) -> Reference:
    """From rest straight ahead with an acceleration [m/s^2] that takes a time [s] to rise; it tilts as that needs, at once if none."""
    times = np.arange(0.0, 4.0, PERIOD)
    share = np.clip(times / rise, 0.0, 1.0) if rise else (times > 0).astype(float)
    ahead = push * share * (times < 1.6)
    velocity = np.cumsum(ahead) * PERIOD
    position = np.cumsum(velocity) * PERIOD
    zeros = np.zeros_like(times)
    thrust = np.stack([ahead, zeros, np.full_like(times, 9.81)], axis=1)
    size = np.linalg.norm(thrust, axis=1)
    attitude = follow_axes(thrust / size[:, None], np.array([1.0, 0.0, 0.0, 0.0]))
    rates = np.vstack([turn_rates(attitude, PERIOD), np.zeros((1, 3))])
    gates = np.array([0.6, 1.0, 1.5])
    flat = np.stack([position, zeros, zeros + 2.0], axis=1)
    unknown = np.full((len(times), 4), np.nan)
    return Reference(flat, attitude, np.stack([velocity, zeros, zeros], axis=1), rates, size, unknown, gates, 1.5, cpu_time=1.0)


def dashing(reference: Reference, race: Race) -> Scenario:
    """A race along such a reference."""
    gates = tuple(Gate(position=tuple(place)) for place in reference.position_at(reference.gate_times).tolist())
    track = Track(name="dash", start=(0.0, 0.0, 2.0), gates=gates)
    segments = Segments(np.array([0.0, 0.75]), (SegmentClass.FLAT, SegmentClass.ASCENT), 1.5)
    return Scenario(race.model_copy(update={"track": track}), reference, segments)


def weak(push: float, more: float = 1.1) -> dict[str, object]:
    """Settings of a drone whose rotors give a little more than a dash takes."""
    most = more * float(np.hypot(push, 9.81))
    rotor = (0.0, 0.716 * most / 4)
    return {"vehicle": {"rotor_thrust": rotor}, "model": {"rotor_thrust": rotor}, "controller": {"thrust": (0.1, most)}}


def found(scenario: Scenario, hold: str = "", weights: tuple[float, ...] = TUNED, **options) -> tuple[Diagnosis, ...]:
    """What is found out about flights of these weights."""
    condition = parse_hold(hold)[0] if hold else UNCHANGED
    return diagnose(scenario, WORLD, np.tile(weights, (2, 1)), SEEDS, condition=condition, **options)


def replan(race: Race) -> Scenario:
    """The same dash, begun slowly where all is planned with; else a slower one."""
    return dashing(dash(12.0, 0.4) if race.planning.dynamics is PlanDynamics.FULL else dash(9.0), race)


def heavy(limit: float = 20.0, hold: str = "mass=+30%") -> tuple[Diagnosis, ...]:
    return found(make_scenario(controller={"thrust": (0.1, limit)}, noise=NOISE, judge=WIDE), hold)


def late(**controller) -> Scenario:
    return dashing(dash(10.0, 0.5), make_race(LAGGING, model=LAGGING, controller=controller, noise=NOISE, judge={"distance": 0.3}))


def chattering() -> tuple[Diagnosis, ...]:
    race = {"controller": {"thrust": (0.1, 14.6)}, "noise": LOUD, "judge": WIDE}
    return found(make_scenario(SLOW, model=SLOW, **race), weights=RESTLESS)


def saturated(distance: float = 0.3, **options) -> tuple[Diagnosis, ...]:
    return found(dashing(dash(12.0), make_race(noise=NOISE, judge={"distance": distance}, **weak(12.0))), **options)


CASES = {
    "no thrust left": lambda: heavy(16.0),
    "unknown force: heavier": heavy,
    "unknown force: drag": lambda: found(make_scenario({"drag": (0.6, 0.6, 0.2)}, noise=NOISE, judge=WIDE)),
    "unknown force: wind": lambda: found(make_scenario(noise=NOISE, judge=WIDE), "wind=4"),
    "unknown dead time": lambda: found(make_scenario({"delay": 0.15}, noise=NOISE, judge=WIDE)),
    "chattering": chattering,
    "saturated from the start": lambda: saturated(replan=replan),
    "late at the gate": lambda: found(late(lag_lead=0.0)),
    "opening too small": lambda: found(make_scenario(noise=LOUD, judge={"distance": 0.09})),
}
ADVICE = {
    "no thrust left": "controller.offset_free",
    "unknown force": "controller.offset_free",
    "unknown dead time": "model.delay = 0.15",
    "chattering": "controller.input_weights = [1, 10, 10]",
    "saturated from the start": 'planning.dynamics = "full"',
    "late at the gate": "controller.lag_lead = 0.5",
    "opening too small": "m more of room",
}


@pytest.mark.parametrize("name", CASES)
def test_flights_that_fail_for_one_cause_are_told_it_first_with_what_makes_them_hold(name):
    first, *others = CASES[name]()
    cause = name.split(":")[0]
    assert first.cause == cause
    assert ADVICE[cause] in first.advice
    assert first.rate >= 0.75
    assert len(others) < 3


def test_what_nothing_helps_but_thrust_is_certain_and_told_with_the_plan_that_would_do():
    scenario = dashing(dash(12.0, 0.4), make_race(noise=NOISE, judge={"distance": 0.3}, **weak(12.0, 0.9)))
    first, *_ = found(scenario)
    assert first.cause is FailureCause.NO_MARGIN
    assert "no weights will help" in first.found
    assert "takes at most" in first.advice


def later(reference: Reference, push: float) -> Reference:
    """The same until a little after its second gate, then with so much more thrust than it takes."""
    more = np.where(reference.times > reference.gate_times[1] + 0.1, push, 0.0)
    return replace(reference, thrust=reference.thrust + more)


def sluggish(reference: Reference, distance: float = 0.1, **controller) -> Scenario:
    """A race whose gates flights miss by their weights alone."""
    judge = {"distance": distance, "rule": GateRule.CLOSEST}
    return dashing(reference, make_race(noise=NOISE, judge=judge, controller={"thrust": (0.1, 20.0), "lag_lead": 0.5, **controller}))


def test_what_lies_after_the_gate_at_which_flights_fail_is_no_cause():
    scenario = sluggish(later(dash(9.0, 0.2), 20.0))
    assert margin(scenario.race, scenario.reference).lacking
    causes = found(scenario, weights=SLUGGISH)
    assert {one.gate for one in causes} <= {"gate 1", "gate 2"}
    assert FailureCause.NO_MARGIN not in {one.cause for one in causes}


def test_where_nothing_else_helps_other_weights_are_tried_and_what_happens_at_the_gate_is_told():
    (only,) = found(sluggish(dash(9.0, 0.2)), weights=SLUGGISH)
    assert only.cause is FailureCause.WEIGHTS
    assert "m from the reference at gate 1, with thrust and rates within their limits" in only.found
    assert "Q_pos_xy multiplied by" in only.advice
    assert only.rate == 1.0


def test_where_no_weights_help_either_the_advice_is_to_look_at_the_flights():
    (only,) = found(sluggish(dash(9.0, 0.2), 0.002, offset_free=True), weights=SLUGGISH)
    assert only.cause is FailureCause.WEIGHTS
    assert only.advice == "no single weight, 10 or 4 times larger or smaller, gets many more flights past gate 1: look at the flights"
    assert only.words.endswith(f"; {only.advice}"), "nothing was tuned further that could be said not to help"
    assert what_to_try(failures_of((), (only,))) == (only.advice,)


@pytest.mark.check
@pytest.mark.parametrize(
    "race", ["airsim-final-22", "airsim-final-21", "airsim-flip-16", "airsim-qualifier-20", "qualifier-20", "final-22"]
)
def test_no_cause_that_is_told_of_a_real_race_lies_after_the_gate_at_which_flights_fail(race):
    scenario = prepare(load_race(race))
    names = [point.name for point in scenario.race.track.route if point.counts]
    for weights in (scenario.space.first_guess(len(scenario.segments)), first_guess(scenario)):
        for one in diagnose(scenario, WORLD, weights, SEEDS):
            places = [names.index(name) for name in re.findall(r"gate \d+", one.found)]
            assert one.gate
            assert all(place <= names.index(one.gate) for place in places), one.words


def test_a_trial_that_held_in_no_flight_is_told_without_a_verb():
    vain = Validation(12, 0)
    race = make_race(noise=NOISE, judge={"distance": 0.02}, **weak(12.0, 0.9))
    for one in found(dashing(dash(12.0, 0.4), race)):
        assert one.rate < 0.5
        assert one.advice.startswith(f"fly {one.change}")
        assert f"; {one.change} alone does not help" in one.words
    lost = Diagnosis(FailureCause.NO_MARGIN, "0.9", "set planning.thrust_share = 0.5", vain, "with enough of it")
    assert not lost.helps
    assert lost.proof == "0 of 12 flights hold with enough of it"
    further = replace(lost, passed=11, gate="gate 3")
    assert further.helps
    assert further.proof == "11 of 12 flights pass gate 3 with enough of it, none of them to the end: not enough by itself"
    assert further.rank > lost.rank
    told = further.dump()
    assert (told["tried"], told["passed"], told["gate"], told["before"]) == ({"flights": 12, "successes": 0}, 11, "gate 3", 0)


def test_a_cause_that_could_not_be_flown_without_is_told_before_one_that_does_not_help():
    (only,) = saturated(0.1)
    assert only.cause is FailureCause.SATURATED
    assert only.tried is None


def test_what_could_not_be_flown_ranks_between_what_helps_and_what_does_not():
    unknown = Diagnosis(FailureCause.SATURATED, "", 'set planning.dynamics = "full"')
    some, further, lost = (replace(unknown, tried=Validation(12, held), passed=passed) for held, passed in ((3, 0), (0, 11), (0, 0)))
    same, hardly, more = (replace(unknown, tried=Validation(12, held), before=7) for held in (7, 8, 9))
    assert max(some, further, more, unknown, key=lambda one: one.rank) is not unknown
    assert min(some, further, more, unknown, key=lambda one: one.rank) is unknown
    assert max(unknown, lost, same, hardly, key=lambda one: one.rank) is unknown
    assert not any(one.helps for one in (lost, same, hardly))


def test_flights_that_hold_have_no_causes():
    assert found(make_scenario(noise=NOISE, judge=WIDE)) == ()
    assert found(late(lag_lead=0.5)) == ()


def test_logs_alone_tell_a_wrong_weight_and_thrust_at_its_limit():
    heavier = make_scenario({"mass": 0.93}, noise=NOISE, judge=WIDE)
    flights = WORLD.fly(heavier, np.tile(TUNED, (6, 2, 1)), SEEDS[:6], log=range(6))
    failed = flights.gates_passed < len(flights.gate_times)
    assert failed.any()
    causes = diagnose_logs(heavier, flights, failed)
    assert FailureCause.UNKNOWN_FORCE in {one.cause for one in causes}
    assert all(one.tried is None for one in causes)
    assert diagnose_logs(heavier, flights, np.zeros(6, dtype=bool)) == ()


def test_the_one_log_of_a_flight_that_failed_elsewhere_than_most_tells_its_cause():
    heavier = make_scenario({"mass": 0.93}, noise=NOISE, judge=WIDE)
    flights = WORLD.fly(heavier, np.tile(TUNED, (6, 2, 1)), SEEDS[:6], log=(0,))
    later, first = np.arange(6) > 0, np.arange(6) < 1
    passed = int(flights.gates_passed[0])
    assert 0 < passed < len(flights.gate_times)
    flights = replace(flights, gates_passed=np.where(later, passed - 1, passed))
    causes = diagnose_logs(heavier, flights, later | first)
    assert FailureCause.UNKNOWN_FORCE in {one.cause for one in causes}
    assert [one.words for one in causes] == [one.words for one in diagnose_logs(heavier, flights, first)]
    assert diagnose_logs(heavier, flights, later) == ()


def test_symptoms_that_vanish_with_their_cause_are_not_told():
    held, some = Validation(12, 12), Validation(12, 8)
    cause, symptom = (Diagnosis(one, "", "", held) for one in (FailureCause.DEAD_TIME, FailureCause.LATE))
    assert without_symptoms([cause, symptom]) == [cause]
    assert without_symptoms([symptom]) == [symptom]
    half = Diagnosis(FailureCause.DEAD_TIME, "", "", some)
    assert without_symptoms([half, symptom]) == [half, symptom]


def test_flights_that_failed_are_looked_at_first_and_others_beside_them():
    seeds, failed = np.arange(100, 150), np.zeros(50, dtype=bool)
    failed[[3, 40]] = True
    assert telling(seeds, failed).tolist() == [103, 140, *(100 + k for k in range(15) if k != 3)]
    assert len(telling(seeds, ~failed)) == len(set(telling(seeds, ~failed).tolist())) == 16


def test_what_helped_flights_of_which_most_held_already_has_to_help_them_all():
    scenario = make_scenario(noise=NOISE, judge=WIDE)
    seldom = diagnose(scenario, WORLD, np.tile(TUNED, (2, 1)), SEEDS, condition=parse_hold("mass=+30%")[0], before=0.8)
    assert seldom[0].rate >= 0.95
