import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hotlap.files.descriptions import load_quadrotor, load_race
from hotlap.race.flight_performance import (
    corner_radii,
    hover_share,
    max_tilt,
    rate_damping,
    roll_acceleration,
    rough_top_speed,
    steady_share,
    steady_thrust,
    top_speed,
)
from hotlap.race.quadrotor import Quadrotor

BARE = Quadrotor(name="q", mass=1.0, inertia=(0.01, 0.01, 0.01), arm=0.2, rotor_thrust=(0.0, 5.0), torque_ratio=0.02)


def test_hovering_and_tilting_follow_from_thrust_to_weight():
    assert hover_share(BARE) == pytest.approx(9.81 / 20)
    assert math.cos(max_tilt(BARE)) == pytest.approx(9.81 / 20)


@given(st.floats(0, 30), st.floats(-3, 3))
def test_without_drag_steady_flight_takes_the_weight(speed, climb):
    assert steady_thrust(BARE, speed, climb) == pytest.approx(9.81, rel=1e-6)


@given(st.floats(1, 15), st.floats(0.05, 0.5))
def test_isotropic_linear_drag_adds_to_the_weight_as_a_vector(speed, drag):
    dragged = BARE.model_copy(update={"drag": (drag, drag, drag)})
    assert steady_thrust(dragged, speed) == pytest.approx(math.hypot(9.81, drag * speed), rel=1e-6)
    climbing = math.hypot(9.81 + drag * 2.0, drag * speed)
    assert steady_thrust(dragged, speed, 2.0) == pytest.approx(climbing, rel=1e-6)


def test_top_speed_with_isotropic_drag_is_where_tilted_full_thrust_meets_it():
    dragged = BARE.model_copy(update={"drag": (0.5, 0.5, 0.5)})
    assert top_speed(dragged) == pytest.approx(math.sqrt(20**2 - 9.81**2) / 0.5, rel=1e-6)


def test_top_speed_is_unlimited_without_drag():
    assert top_speed(BARE) == math.inf


@pytest.mark.parametrize(("speed", "climb", "thrust"), [(19.9, 0, 12.8), (19.9, 2.5, 16.4), (18, 2.5, 14.5), (20.8, 2.5, 17.5)])
def test_airsims_drag_box_takes_what_its_source_says(speed, climb, thrust):
    assert steady_thrust(load_quadrotor("airsim"), speed, climb) == pytest.approx(thrust, abs=0.05)


def test_the_final_is_beyond_airsims_quadrotor_at_22_but_not_at_21():
    fast, slow = steady_share(load_race("airsim-final-22")), steady_share(load_race("airsim-final-21"))
    assert fast is not None
    assert slow is not None
    assert slow < 0.93
    assert fast > 0.97


def test_a_track_of_short_legs_has_no_steady_flight():
    assert steady_share(load_race("circle-34")) is None


def test_roll_acceleration_is_two_rotors_on_their_levers():
    assert roll_acceleration(BARE) == pytest.approx(2 * 5.0 * 0.2 * math.sqrt(0.5) / 0.01)


def test_damping_falls_with_gain_and_motor_time():
    assert rate_damping(BARE.model_copy(update={"rate_gain": (25.0, 25, 8), "motor_time": (0.01, 0.01)})) == pytest.approx(1.0)
    assert rate_damping(BARE.model_copy(update={"motor_time": (0.0, 0.0)})) == math.inf


def test_corners_of_a_circle_have_its_radius():
    angles = np.array([0.1, 0.7, 1.9, 3.0])
    points = 7 * np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    assert corner_radii(points) == pytest.approx([7, 7])


def test_straight_on_has_no_radius_and_straight_back_none_either():
    assert corner_radii(np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])) == pytest.approx([np.inf])
    assert corner_radii(np.array([[0.0, 0, 0], [1, 0, 0], [0, 0, 0]])) == pytest.approx([0])


def test_the_rough_speed_is_within_a_fifth_of_the_plans():
    for name, planned in (("circle-20", 17.1), ("circle-34", 22.0), ("spiral-53", 14.3), ("qualifier-20", 22.5), ("final-22", 20.0)):
        assert rough_top_speed(load_race(name)) == pytest.approx(planned, rel=0.2)
