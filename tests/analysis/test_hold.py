"""Changes of the truth that a tuned controller is asked to bear."""

import numpy as np
import pytest

from flight.courses import TUNED, make_course
from hotlap.analysis.hold import CHANGES, will_it_hold
from hotlap.goal import Goal
from hotlap.truth import TRUTH, truth_of
from hotlap.worlds.built_in import BuiltIn

COURSE = make_course(noise={"position": 0.05, "thrust": 0.02, "rates": 0.1}, judge={"distance": 0.6})
TRUE = truth_of(COURSE.race.vehicle)


def change(name: str) -> dict[str, float]:
    """Columns that a change multiplies, with their factors."""
    changed = CHANGES[name](TRUE)
    return {column: new / old for column, new, old in zip(TRUTH, changed, TRUE, strict=True) if new != old and old}


def test_a_heavier_drone_is_heavier_and_turns_more_slowly():
    assert change("10 % heavier") == pytest.approx(dict.fromkeys(("mass", "inertia_x", "inertia_y", "inertia_z"), 1.1))


def test_less_thrust_is_less_acceleration_at_every_command_and_the_same_drag():
    weaker = CHANGES["15 % less thrust"](TRUE)
    mass, thrust = TRUTH.index("mass"), TRUTH.index("rotor_thrust_max")
    assert (weaker[thrust] / weaker[mass]) / (TRUE[thrust] / TRUE[mass]) == pytest.approx(0.85)
    for name in ("rotor_drag", "body_drag_x"):
        column = TRUTH.index(name)
        assert weaker[column] / weaker[mass] == pytest.approx(TRUE[column] / TRUE[mass])


def test_dead_time_is_added():
    assert CHANGES["20 ms more dead time"](TRUE)[TRUTH.index("delay")] == pytest.approx(TRUE[TRUTH.index("delay")] + 0.02)


def test_every_change_is_flown_as_often_and_the_first_is_none():
    parameters = np.tile(TUNED, (2, 1))
    holds = will_it_hold(COURSE, BuiltIn("float32x8"), Goal(), parameters, seed=1, flights=16)
    assert [hold.change for hold in holds] == [*CHANGES, "twice the noise"]
    assert {hold.validation.flights for hold in holds} == {16}
    assert holds[0].validation.successes == 16
    again = will_it_hold(COURSE, BuiltIn("float32x8"), Goal(), parameters, seed=1, flights=16)
    assert holds == again


def test_what_is_hard_to_bear_costs_successes():
    tight = make_course(noise={"position": 0.05}, judge={"distance": 0.16})
    rates = [hold.validation.rate for hold in will_it_hold(tight, BuiltIn("float32x8"), Goal(), np.tile(TUNED, (2, 1)), 1, flights=16)]
    assert min(rates) < rates[0]
