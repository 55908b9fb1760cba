import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from hotlap.race.quadrotor import Quadrotor
from hotlap.race.rotors import RotorLayout


def quadrotor(**changes):
    values = {
        "name": "q",
        "mass": 0.85,
        "inertia": [1e-3, 1e-3, 1.7e-3],
        "arm": 0.15,
        "rotor_thrust": [0, 6.9],
        "torque_ratio": 0.05,
    }
    return Quadrotor(**{**values, **changes})


def positions(layout, arm):
    """Rotors (x forward, y left) in the order that the conventions state."""
    if layout is RotorLayout.X:
        return arm * np.sqrt(0.5) * np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]])
    return arm * np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])


@pytest.mark.parametrize("layout", list(RotorLayout))
@given(arm=st.floats(0.05, 0.5), thrusts=st.tuples(*[st.floats(0, 5)] * 4))
def test_roll_and_pitch_torques_are_lever_cross_thrust(layout, arm, thrusts):
    matrix = quadrotor(layout=layout, arm=arm).torque_matrix
    levers = np.column_stack([positions(layout, arm), np.zeros(4)])
    forces = np.column_stack([np.zeros((4, 2)), thrusts])
    expected = np.cross(levers, forces).sum(axis=0)
    assert matrix[:2] @ thrusts == pytest.approx(expected[:2], abs=1e-9)


@pytest.mark.parametrize("layout", list(RotorLayout))
def test_four_equal_thrusts_make_no_torque_and_torques_are_independent(layout):
    matrix = quadrotor(layout=layout).torque_matrix
    assert matrix @ np.ones(4) == pytest.approx([0, 0, 0], abs=1e-15)
    assert np.linalg.matrix_rank(np.vstack([matrix, np.ones(4)])) == 4


@pytest.mark.parametrize("layout", list(RotorLayout))
def test_opposite_rotors_turn_the_same_way(layout):
    yaw = quadrotor(layout=layout).torque_matrix[2]
    assert yaw[0] == yaw[2] == -yaw[1] == -yaw[3]
    assert abs(yaw[0]) == 0.05


def test_thrust_to_weight_is_full_thrust_over_weight():
    assert quadrotor().thrust_to_weight == pytest.approx(4 * 6.9 / (0.85 * 9.81))
    assert quadrotor().max_acceleration == pytest.approx(quadrotor().thrust_to_weight * 9.81)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"mass": 700}, r"did you mean 0\.7\?"),
        ({"arm": 150}, r"did you mean 0\.15\?"),
        ({"motor_time": [20, 40]}, "in seconds"),
        ({"inertia": [1e-3, 1e-3, 3e-3]}, "inertia: no body has"),
        ({"inertia": [1.0, 1.0, 1.0]}, "inertia: 1 kg m"),
        ({"rotor_thrust": [7, 6.9]}, "rotor_thrust: the least"),
        ({"rotor_thrust": [0, 2.0]}, "rotor_thrust: cannot hover, thrust-to-weight is 0.96"),
        ({"rotor_thrust": [0, 690]}, "rotor_thrust: thrust-to-weight of 331"),
        ({"delay": 45}, "less than or equal to 0.25"),
    ],
)
def test_an_impossible_quadrotor_is_refused(changes, message):
    with pytest.raises(ValidationError, match=message):
        quadrotor(**changes)


def test_a_flat_plate_is_a_possible_body():
    assert quadrotor(inertia=[1e-3, 1e-3, 2e-3]).inertia_vector == pytest.approx([1e-3, 1e-3, 2e-3])
