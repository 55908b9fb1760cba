"""Conditions of a flight: what they change of vehicle and noise, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from hotlap.core.errors import InputError
from hotlap.files.descriptions import load_race
from hotlap.race.conditions import AS_TUNED, DEFAULT_CONDITIONS, UNCHANGED, Condition, check_conditions, join_conditions
from hotlap.race.hold import parse_hold
from hotlap.race.race import NoiseSettings
from hotlap.race.vehicle_parameters import VEHICLE_PARAMETERS, vehicle_parameters_of

RACE = load_race("circle-34")
TRUE = vehicle_parameters_of(RACE.vehicle.model_copy(update={"body_drag": (0.1, 0.1, 0.2), "drag": (0.3, 0.2, 0.1)}))


def one(text: str) -> Condition:
    (condition,) = parse_hold(text)
    return condition


def factors(text: str) -> dict[str, float]:
    """Columns that a condition multiplies, with their factors."""
    changed = one(text).vehicle_parameters(TRUE)
    return {column: new / old for column, new, old in zip(VEHICLE_PARAMETERS, changed, TRUE, strict=True) if new != old and old}


def test_without_changes_everything_is_as_tuned():
    assert UNCHANGED.name == AS_TUNED
    assert_array_equal(UNCHANGED.vehicle_parameters(TRUE), TRUE)
    assert UNCHANGED.noise(RACE.noise) == RACE.noise


def test_a_heavier_drone_is_heavier_and_turns_more_slowly():
    assert factors("mass=+10%") == pytest.approx(dict.fromkeys(("mass", "inertia_x", "inertia_y", "inertia_z"), 1.1))


def test_less_thrust_is_less_acceleration_at_every_command_and_the_same_drag():
    weaker = one("thrust=-15%").vehicle_parameters(TRUE)
    mass, thrust = VEHICLE_PARAMETERS.index("mass"), VEHICLE_PARAMETERS.index("rotor_thrust_max")
    assert (weaker[thrust] / weaker[mass]) / (TRUE[thrust] / TRUE[mass]) == pytest.approx(0.85)
    for name in ("rotor_drag", "body_drag_x"):
        column = VEHICLE_PARAMETERS.index(name)
        assert weaker[column] / weaker[mass] == pytest.approx(TRUE[column] / TRUE[mass])


def test_dead_time_is_added():
    column = VEHICLE_PARAMETERS.index("delay")
    assert one("delay=+20ms").vehicle_parameters(TRUE)[column] == pytest.approx(TRUE[column] + 0.02)


@pytest.mark.parametrize(
    ("text", "changed"),
    [
        ("drag=+50%", {"drag_x", "drag_y", "drag_z", "rotor_drag", "body_drag_x", "body_drag_y", "body_drag_z"}),
        ("motor=+50%", {"motor_time_up", "motor_time_down"}),
        ("inertia=+50%", {"inertia_x", "inertia_y", "inertia_z"}),
        ("rate_gain=+50%", {"rate_gain_x", "rate_gain_y", "rate_gain_z"}),
        ("wind=3", set()),
    ],
)
def test_a_share_multiplies_what_it_names_alone(text, changed):
    assert factors(text) == pytest.approx(dict.fromkeys(changed, 1.5))


def test_a_sag_is_the_share_of_thrust_that_is_lost():
    changed = one("sag=15%").vehicle_parameters(np.tile(TRUE, (2, 1)))
    assert_array_equal(changed[:, VEHICLE_PARAMETERS.index("sag")], 0.15)


def test_wind_gusts_and_noise_change_the_noise_alone():
    gusty = one("wind=3 & gusts=2").noise(RACE.noise)
    assert gusty == RACE.noise.model_copy(update={"steady_wind": 3.0, "wind": 2.0})
    noisy = one("noise=x2").noise(NoiseSettings(thrust=0.1, wind=1.0, wind_time=3.0))
    assert (noisy.thrust, noisy.wind, noisy.wind_time) == (0.2, 2.0, 3.0)
    assert_array_equal(one("noise=x2").vehicle_parameters(TRUE), TRUE)


def test_the_defaults_are_what_their_words_say():
    text = ", ".join(condition.text for condition in DEFAULT_CONDITIONS)
    assert parse_hold(text) == DEFAULT_CONDITIONS
    names = ["10 % lighter", "10 % heavier", "15 % less thrust", "20 ms more dead time", "twice the noise"]
    assert [condition.name for condition in DEFAULT_CONDITIONS] == names


def test_joined_lists_hold_each_condition_once_the_first_first():
    asked = parse_hold("wind=3, mass=+10%")
    joined = join_conditions(asked, DEFAULT_CONDITIONS)
    assert joined[:2] == asked
    assert len(joined) == len(set(joined)) == len(DEFAULT_CONDITIONS) + 1


def test_a_dead_time_that_no_vehicle_has_is_refused_with_the_item():
    vehicle = RACE.vehicle.model_copy(update={"delay": 0.045})
    race = RACE.model_copy(update={"vehicle": vehicle})
    check_conditions(parse_hold("delay=+-45ms"), race)
    for text in ("delay=-50ms", "delay=+210ms"):
        with pytest.raises(InputError, match=r"hold: 'delay=.*ms': .*has 45 ms.*between 0 and 250 ms"):
            check_conditions(parse_hold(text), race)
