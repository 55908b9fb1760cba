import numpy as np
import pytest
from numpy.testing import assert_allclose

from hotlap.reference.reference import PERIOD, Reference, row_times


def make_reference(duration: float, rows: int) -> Reference:
    """Rows along x at 2 m/s, then faster and faster."""
    times = PERIOD * np.arange(rows)
    zeros = np.zeros((rows, 3))
    speed = np.where(times <= duration + 1e-9, 2.0, 50.0)
    return Reference(
        position=np.stack([2 * times, 0 * times, 0 * times], axis=1),
        attitude=np.tile([1.0, 0.0, 0.0, 0.0], (rows, 1)),
        velocity=np.stack([speed, 0 * times, 0 * times], axis=1),
        rates=zeros,
        thrust=np.full(rows, 9.81),
        rotor_thrusts=np.full((rows, 4), 2.5),
        gate_times=np.array([0.1, 0.155]),
        duration=duration,
    )


@pytest.mark.parametrize(("duration", "rows"), [(0.2, 21), (0.209, 21), (0.07, 8), (0.29, 30), (1.1, 111), (0.0, 1)])
def test_planned_rows_go_up_to_the_duration_whatever_the_rounding(duration, rows):
    assert make_reference(duration, 150).planned_rows == rows == len(row_times(duration))


def test_times_are_those_of_the_rows():
    reference = make_reference(0.2, 50)
    assert_allclose(reference.times, np.linspace(0, 0.49, 50))
    np.testing.assert_array_equal(reference.times[:21], row_times(0.2))


def test_speeds_are_those_of_the_plan_not_of_the_run_out():
    reference = make_reference(0.2, 50)
    assert (len(reference.speeds), reference.max_speed, reference.mean_speed) == (21, 2.0, pytest.approx(2.0))


def test_the_lap_ends_at_the_last_gate():
    assert make_reference(0.2, 50).lap_time == 0.155


def test_positions_between_rows_are_interpolated():
    assert_allclose(make_reference(0.2, 50).position_at(np.array([0.0, 0.155])), [[0, 0, 0], [0.31, 0, 0]], atol=1e-12)


def test_the_table_holds_state_thrust_and_rates_in_columns():
    reference = make_reference(0.2, 50)
    assert reference.table.shape == (50, 14)
    assert_allclose(reference.table[3], [0.06, 0, 0, 1, 0, 0, 0, 2, 0, 0, 9.81, 0, 0, 0])
