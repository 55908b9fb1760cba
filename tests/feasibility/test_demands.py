"""What a reference asks of its vehicle: thrust with the vehicle's own drags, body rates, and both at the first moment."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from hotlap.feasibility.demands import advice, demands
from hotlap.files.descriptions import load_quadrotor
from hotlap.race.flight_performance import steady_thrust
from hotlap.reference.reference import PERIOD, Reference
from planning import small

RACE = small.RACES["ramp"]


def level(speed: float, pitch: float = 0.0, rows: int = 200) -> Reference:
    """Straight and level along x, nose down by a constant angle."""
    ones, times = np.ones(rows), PERIOD * np.arange(rows)
    along = np.array([1.0, 0.0, 0.0])
    return Reference(
        position=speed * times[:, None] * along,
        attitude=np.outer(ones, [np.cos(pitch / 2), 0.0, np.sin(pitch / 2), 0.0]),
        velocity=speed * np.outer(ones, along),
        rates=np.zeros((rows, 3)),
        thrust=9.81 * ones,
        rotor_thrusts=np.ones((rows, 4)),
        gate_times=np.array([1.0]),
        duration=float(times[-1]),
    )


def flown_by(name: str):
    return RACE.model_copy(update={"vehicle": load_quadrotor(name)})


@pytest.mark.parametrize("name", ["hummingbird", "airsim", "split-s-racer"])
def test_hovering_takes_the_weight(name):
    race = flown_by(name)
    assert demands(race, level(0.0)).thrust_share == pytest.approx(1 / race.vehicle.thrust_to_weight)


@pytest.mark.parametrize("name", ["hummingbird", "airsim"])
def test_level_flight_takes_what_the_vehicle_needs_at_that_speed_with_its_own_drags(name):
    race = flown_by(name)
    thrust = steady_thrust(race.vehicle, 10.0)
    pitch = float(np.arccos(min(9.81 / np.hypot(9.81, 1.0), 1.0)))
    found = demands(race, level(10.0, pitch)).mean_share * race.vehicle.max_acceleration
    assert found == pytest.approx(thrust, rel=0.03)


@pytest.mark.check
def test_a_plan_takes_about_the_share_of_the_thrust_that_it_was_planned_with():
    race, _, _, reference = small.planned("ramp")
    found = demands(race, reference)
    share = race.planning_model.max_acceleration / race.vehicle.max_acceleration
    assert 0.9 * share < found.thrust_share < 1.01 * share  # turning takes some of it
    assert found.full_time == 0
    assert not found.exhausting


@pytest.mark.check
def test_rates_are_compared_with_what_the_controller_may_command():
    race, _, _, reference = small.planned("ramp")
    found = demands(race, reference)
    assert_allclose(found.rates, np.abs(reference.rates).max(axis=0))
    tight = race.controller.model_copy(update={"rates": (0.5 * found.rates[0], 100.0, 100.0)})
    assert demands(race.model_copy(update={"controller": tight}), reference).too_quick
    wide = race.controller.model_copy(update={"rates": (100.0, 100.0, 100.0)})
    assert not demands(race.model_copy(update={"controller": wide}), reference).too_quick


def test_a_flying_start_is_seen_at_the_first_moment():
    found = demands(RACE, level(7.0))
    assert found.first_speed == pytest.approx(7.0)
    assert found.length == pytest.approx(7.0 * found.duration)


def test_what_no_weights_make_up_for_is_said():
    race, _, _, reference = small.planned("ramp")
    gentle = reference.rates[0] * 0
    assert advice(race, replace(reference, rates=np.vstack([gentle, reference.rates[1:]]))) == ()
    weak = race.vehicle.model_copy(update={"rotor_thrust": (0.0, 0.7 * race.vehicle.rotor_thrust[1])})
    tight = race.controller.model_copy(update={"rates": (1.0, 100.0, 100.0), "thrust": (0.1, 12.0)})
    said = advice(race.model_copy(update={"vehicle": weak, "controller": tight}), reference)
    assert any("of the vehicle's thrust: no tuner will help" in line for line in said)
    assert not any("controller.thrust" in line for line in said), "the vehicle has no more to give"
    said = advice(race.model_copy(update={"controller": tight}), reference)
    assert any(line.startswith("it asks for a roll rate of up to ") and line.endswith("which allow 1") for line in said)
    assert not any("pitch rate" in line for line in said)
    assert any("raise controller.thrust, which allows 12" in line for line in said)


def test_a_reference_that_begins_in_flight_is_said():
    assert any("it begins at 7.0 m/s; set track.start_velocity" in said for said in advice(RACE, level(7.0)))
    flying = RACE.model_copy(update={"track": RACE.track.model_copy(update={"start_velocity": (7.0, 0.0, 0.0)})})
    assert not any("it begins at" in said for said in advice(flying, level(7.0)))
