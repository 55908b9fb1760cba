"""What to try is told in one list, each thing once."""

from __future__ import annotations

from dataclasses import replace

from hotlap.analysis.diagnosis import Diagnosis
from hotlap.analysis.remedies import failures_of, what_to_try, why
from hotlap.analysis.robustness import Robustness
from hotlap.core.success_rate import Validation
from hotlap.feasibility.causes import FailureCause
from hotlap.race.conditions import UNCHANGED
from hotlap.race.hold import parse_hold

HEAVY, WEAK = parse_hold("mass=+10%, thrust=-15%")
BLIND = Diagnosis(FailureCause.DEAD_TIME, "20 ms that it does not know of", "set controller.predict = true", Validation(12, 12))
LATE = Diagnosis(FailureCause.LATE, "0.3 m behind", "set controller.offset_free = true", Validation(12, 9))


def lacking(share: float) -> Diagnosis:
    change = f"planning.thrust_share = {share}"
    words = f"set {change}, estimated"
    return Diagnosis(FailureCause.NO_MARGIN, f"{share} of the thrust", words, Validation(12, 12), "with enough of it", change=change)


def row(condition, *causes):
    return Robustness(condition, Validation(50, 10), causes=causes)


def test_the_same_advice_for_several_conditions_is_told_once_with_all_of_them():
    failures = failures_of([row(UNCHANGED, BLIND, LATE), row(HEAVY, BLIND, LATE)])
    assert what_to_try(failures) == (
        "set controller.predict = true (as tuned: 12 of 12 flights hold; 10 % heavier: 12 of 12 flights hold)",
        "set controller.offset_free = true (as tuned: 9 of 12 flights hold)",
    )
    assert next(iter(why(failures))) == "as tuned, 10 % heavier: unknown dead time: 20 ms that it does not know of"


def test_of_several_values_of_a_share_the_calmest_is_told_which_does_for_all():
    (line,) = what_to_try(failures_of([row(HEAVY, lacking(0.78)), row(WEAK, lacking(0.72))]))
    assert line.startswith("set planning.thrust_share = 0.72, estimated (10 % heavier: 0.78, ")
    assert line.count("planning.thrust_share") == 1


def test_what_a_tuned_plan_has_shown_comes_first_and_takes_the_place_of_an_estimate():
    further = ("it begins at 7.0 m/s", "a calmer plan holds: planning.thrust_share = 0.65: 3.60 s (found in 40 more flights)")
    lines = what_to_try(failures_of([row(UNCHANGED, lacking(0.6))]), further)
    assert lines[0] == further[0]
    assert lines[1].startswith(f"{further[1]} (as tuned: 0.6, ")
    assert len(lines) == 2


def test_causes_of_flights_of_their_own_take_the_place_of_those_as_tuned():
    lines = what_to_try(failures_of([row(UNCHANGED, LATE), row(HEAVY, LATE)], (BLIND,)))
    assert [line.partition(" (")[0] for line in lines] == ["set controller.predict = true", "set controller.offset_free = true"]
    assert "as tuned: 9" not in lines[1]


def test_flights_alone_need_no_name_of_a_condition():
    failures = failures_of((), (BLIND,))
    assert list(why(failures)) == ["unknown dead time: 20 ms that it does not know of"]
    assert what_to_try(failures) == ("set controller.predict = true (12 of 12 flights hold)",)


def test_where_nothing_fails_there_is_nothing_to_try():
    assert what_to_try(failures_of([row(UNCHANGED)])) == ()


def vain(cause: FailureCause, change: str, verb: str = "set") -> Diagnosis:
    return Diagnosis(cause, "found", f"{verb} {change}", Validation(12, 0), change=change)


def test_slower_plans_that_held_in_no_flight_are_said_once_not_to_help():
    plans = [vain(FailureCause.NO_MARGIN, f"a plan that takes at most {most} m/s^2", "fly") for most in (9.0, 8.2, 7.6)]
    rows = [row(condition, plan) for condition, plan in zip((UNCHANGED, HEAVY, WEAK), plans, strict=True)]
    assert what_to_try(failures_of(rows)) == (
        "slower plans (as tuned, 10 % heavier, 15 % less thrust) alone do not help: 0 of 12 flights hold",
    )
    assert what_to_try(failures_of((), plans)) == ("slower plans alone do not help: 0 of 12 flights hold",)


def test_what_does_not_help_is_one_line_behind_what_does():
    share = vain(FailureCause.NO_MARGIN, "planning.thrust_share = 0.5")
    damped = vain(FailureCause.CHATTERING, "controller.input_weights = [1, 10, 10]")
    assert what_to_try(failures_of([row(UNCHANGED, share, BLIND), row(HEAVY, damped)])) == (
        "set controller.predict = true (as tuned: 12 of 12 flights hold)",
        "slower plans (as tuned), controller.input_weights = [1, 10, 10] (10 % heavier) alone do not help: 0 of 12 flights hold",
    )
    assert what_to_try(failures_of((), (damped,))) == ("controller.input_weights = [1, 10, 10] alone does not help: 0 of 12 flights hold",)


def test_of_several_largest_thrusts_of_a_plan_the_least_is_told():
    plans = [replace(lacking(0), advice=f"fly a plan that takes at most {most} m/s^2") for most in (14.2, 13.1)]
    (line,) = what_to_try(failures_of([row(HEAVY, plans[0]), row(WEAK, plans[1])]))
    assert line.startswith("fly a plan that takes at most 13.1 m/s^2 (10 % heavier: 14.2, 12 of 12 flights hold")


def test_stronger_rotors_that_do_not_help_are_named_by_what_they_give():
    weak = vain(FailureCause.NO_MARGIN, "more thrust")
    stronger = replace(weak, advice="take stronger rotors: no slower plan leaves enough thrust", supposed="with enough of it")
    assert what_to_try(failures_of((), (stronger,))) == ("more thrust alone does not help: 0 of 12 flights hold with enough of it",)
    assert stronger.words.endswith("; more thrust alone does not help (0 of 12 flights hold with enough of it)")
    some = replace(stronger, passed=5, gate="gate 3")
    (line,) = what_to_try(failures_of((), (some,)))
    assert line.startswith(f"{some.advice} (5 of 12 flights pass gate 3 with enough of it, none of them to the end")
