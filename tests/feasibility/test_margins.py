"""What is left of thrust and rates over what a reference needs."""

from __future__ import annotations

import numpy as np
import pytest

from flight.scenarios import make_race, make_reference
from hotlap.feasibility.margins import ENOUGH, in_wind, margin, place_of, planned_vectors
from hotlap.race.hold import parse_hold
from hotlap.reference.reference import PERIOD, Reference

REFERENCE = make_reference()
ROTORS = 4 * 6.0 / 0.716  # m/s^2 of the hummingbird


def under(hold: str, *, offset_free: bool = False, thrust: float = 20.0, **changes):
    race = make_race(controller={"thrust": (0.1, thrust)}, **changes)
    conditions = parse_hold(hold)
    return margin(race, REFERENCE, *conditions, offset_free=offset_free)


def test_a_margin_is_the_thrust_limit_over_the_largest_thrust_that_is_held():
    found = under("")
    assert found.available == pytest.approx(20.0)
    assert found.needed == pytest.approx(REFERENCE.thrust[: REFERENCE.planned_rows].max(), rel=0.01)
    assert found.thrust == found.available / found.needed


def test_rotors_that_give_less_than_the_controller_may_command_decide():
    assert under("", thrust=60.0).available == pytest.approx(ROTORS, rel=0.01)


def test_a_command_does_less_for_a_heavier_drone_and_one_that_is_estimated_makes_up_for_it():
    assert under("mass=+25%").available == pytest.approx(20.0 / 1.25)
    assert under("mass=+25%", offset_free=True).available == pytest.approx(20.0)
    assert under("thrust=-50%", offset_free=True).available == pytest.approx(0.45 * ROTORS, rel=0.01)  # a tenth is for torque
    assert under("mass=-20%").available == pytest.approx(25.0)
    assert under("mass=-20%", offset_free=True).available == pytest.approx(20.0)


def test_a_plan_that_takes_nearly_all_of_the_rotors_leaves_none_to_turn_with():
    bold = under("", thrust=ROTORS)
    assert bold.reserve == pytest.approx(0.9 * bold.thrust)
    tired = under("thrust=-55%", thrust=ROTORS)
    assert 1 < tired.thrust < 1 / 0.9
    assert not tired.enough
    assert not tired.lacking


def test_wind_is_needed_in_its_worst_direction_and_proves_nothing():
    calm, blown = under(""), under("wind=4")
    assert calm.needed < blown.needed <= calm.needed + 4
    assert under("gusts=4").needed == blown.needed
    weak = under("wind=4 & thrust=-15%", thrust=15.0)
    assert weak.thrust < 1
    assert not weak.lacking
    assert under("thrust=-15%", thrust=15.0).lacking


def braking(deceleration: float) -> Reference:
    """Level along x, with the thrust of a plan that leaves half of the deceleration to a drag."""
    times = PERIOD * np.arange(100)
    thrust = np.hypot(9.81, deceleration / 2)
    half = np.arctan2(deceleration / 2, 9.81) / 2
    return Reference(
        position=np.outer(20 * times - deceleration * times**2 / 2, [1.0, 0.0, 0.0]),
        attitude=np.tile([np.cos(half), 0.0, -np.sin(half), 0.0], (100, 1)),
        velocity=np.outer(20 - deceleration * times, [1.0, 0.0, 0.0]),
        rates=np.zeros((100, 3)),
        thrust=np.full(100, thrust),
        rotor_thrusts=np.full((100, 4), thrust / 4),
        gate_times=np.array([0.5]),
        duration=float(times[-1]),
    )


@pytest.mark.parametrize("thrust", [20.0, ROTORS])
def test_a_plan_that_brakes_with_more_drag_than_the_vehicle_has_needs_rotors_that_make_up_for_it(thrust):
    race = make_race(controller={"thrust": (0.1, thrust)})
    dragless = race.vehicle.model_copy(update={"drag": (0.0,) * 3, "rotor_drag": 0.0, "body_drag": (0.0,) * 3})
    race = race.model_copy(update={"vehicle": dragless})
    hard, most = braking(34.0), race.control_model.max_acceleration
    needed = np.hypot(9.81, 34.0)
    found = margin(race, hard, offset_free=True)
    assert found.needed == pytest.approx(needed)
    assert found.thrust == pytest.approx(most / needed)
    assert found.reserve == pytest.approx(0.9 * most / needed)
    assert found.limit is None  # no command makes rotors stronger
    assert found.passing
    assert not found.lacking
    assert margin(race, braking(24.0), offset_free=True).enough  # a limit of 20 m/s^2 cuts some of it, but the rotors have it


def test_what_is_needed_later_does_not_count():
    race, whole = make_race(), under("")
    last = 0.0
    for until in np.linspace(0.3, REFERENCE.duration, 12):
        found = margin(race, REFERENCE, until=until)
        assert found.time <= until + 1e-9
        assert found.needed >= last
        last = found.needed
    assert margin(race, REFERENCE, until=REFERENCE.duration).dump() == margin(race, REFERENCE).dump()
    assert last == whole.needed
    half = [
        margin(race, REFERENCE, *parse_hold("sag=20%"), until=until).available for until in (REFERENCE.duration / 2, REFERENCE.duration)
    ]
    assert half[0] > half[1], "a battery that is half empty by then"


def test_a_battery_sags_towards_the_end():
    fresh, empty = under(""), under("sag=20%")
    assert empty.available == pytest.approx(0.8 * fresh.available, rel=0.02)
    assert empty.time > 0.9 * REFERENCE.duration


def test_what_was_planned_with_is_the_reference_s_thrust_and_a_wind_pushes_level():
    assert np.allclose(in_wind(planned_vectors(REFERENCE), 0.0), REFERENCE.thrust[: REFERENCE.planned_rows])
    assert in_wind(np.array([[3.0, 0.0, 0.0], [0.0, 0.0, 3.0]]), 4.0).tolist() == [7.0, 5.0]


def test_places_are_told_by_gates():
    race, (first, second, *_, last) = make_race(), REFERENCE.gate_times.tolist()
    assert place_of(race, REFERENCE, 0.1) == "before gate 1"
    assert place_of(race, REFERENCE, first - 0.1) == "at gate 1"
    assert place_of(race, REFERENCE, (first + second) / 2) == "between gate 1 and gate 2"
    assert place_of(race, REFERENCE, last + 0.5) == "after gate 5"


def test_the_limit_that_is_named_leaves_enough():
    race = make_race(controller={"thrust": (0.1, 16.0)})
    for offset_free in (False, True):
        found = margin(race, REFERENCE, *parse_hold("mass=+30%"), offset_free=offset_free)
        raised = make_race(controller={"thrust": (0.1, found.limit)})
        assert margin(raised, REFERENCE, *parse_hold("mass=+30%"), offset_free=offset_free).reserve == pytest.approx(ENOUGH, rel=0.01)
