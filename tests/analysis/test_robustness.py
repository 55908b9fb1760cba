"""Changes of the vehicle that a tuned controller is asked to bear."""

import numpy as np
import pytest

from flight.scenarios import TUNED, make_scenario
from hotlap.analysis.robustness import CHANGES, check_robustness
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.race.vehicle_parameters import VEHICLE_PARAMETERS, vehicle_parameters_of
from hotlap.tuning.goal import Goal
from hotlap.tuning.scoring import score
from hotlap.worlds.built_in import BuiltIn

SCENARIO = make_scenario(noise={"position": 0.05, "thrust": 0.02, "rates": 0.1}, judge={"distance": 0.6})
TRUE = vehicle_parameters_of(SCENARIO.race.vehicle)


def change(name: str) -> dict[str, float]:
    """Columns that a change multiplies, with their factors."""
    changed = CHANGES[name](TRUE)
    return {column: new / old for column, new, old in zip(VEHICLE_PARAMETERS, changed, TRUE, strict=True) if new != old and old}


def test_a_heavier_drone_is_heavier_and_turns_more_slowly():
    assert change("10 % heavier") == pytest.approx(dict.fromkeys(("mass", "inertia_x", "inertia_y", "inertia_z"), 1.1))


def test_less_thrust_is_less_acceleration_at_every_command_and_the_same_drag():
    weaker = CHANGES["15 % less thrust"](TRUE)
    mass, thrust = VEHICLE_PARAMETERS.index("mass"), VEHICLE_PARAMETERS.index("rotor_thrust_max")
    assert (weaker[thrust] / weaker[mass]) / (TRUE[thrust] / TRUE[mass]) == pytest.approx(0.85)
    for name in ("rotor_drag", "body_drag_x"):
        column = VEHICLE_PARAMETERS.index(name)
        assert weaker[column] / weaker[mass] == pytest.approx(TRUE[column] / TRUE[mass])


def test_dead_time_is_added():
    assert CHANGES["20 ms more dead time"](TRUE)[VEHICLE_PARAMETERS.index("delay")] == pytest.approx(
        TRUE[VEHICLE_PARAMETERS.index("delay")] + 0.02
    )


def test_every_change_is_flown_as_often_and_the_first_is_none():
    parameters = np.tile(TUNED, (2, 1))
    holds = check_robustness(SCENARIO, BuiltIn(), Goal(), parameters, seed=1, flights=16)
    assert [hold.change for hold in holds] == [*CHANGES, "twice the noise"]
    assert {hold.validation.flights for hold in holds} == {16}
    assert holds[0].validation.successes == 16
    again = check_robustness(SCENARIO, BuiltIn(), Goal(), parameters, seed=1, flights=16)
    assert holds == again


def test_what_is_hard_to_bear_costs_successes():
    tight = make_scenario(noise={"position": 0.05}, judge={"distance": 0.16})
    world, parameters = BuiltIn(), np.tile(TUNED, (2, 1))
    holds = check_robustness(tight, world, Goal(), parameters, 1, flights=16)
    assert min(hold.validation.rate for hold in holds) < holds[0].validation.rate
    flown = world.fly(tight, np.repeat(parameters[None], 16, axis=0), flight_seeds(1, Stream.DEMONSTRATION, 0, 16))
    assert check_robustness(tight, world, Goal(), parameters, 1, 16, score(flown, tight.race.judge)) == holds
