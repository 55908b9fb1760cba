"""What the controller is asked to track is the reference, wherever its nodes fall."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from hotlap.flight.mpc import Mpc, allocate_mpc
from hotlap.flight.mpc_reference import hover_inputs, plan_as_reference, read_reference, respace_plan

NODES, LANES, LANE = 6, 3, 1
TABLE = np.random.default_rng(3).normal(size=(40, 14))
PERIOD = 0.01


def memory() -> Mpc:
    """Every number differs from every other."""
    mpc = allocate_mpc(NODES, LANES, np.float64)
    for array in (mpc.X, mpc.U, mpc.reference):
        array[:] = np.arange(array.size).reshape(array.shape)
    mpc.constants[:] = 9.81
    return mpc


def read(time: float, spacing: float) -> np.ndarray:
    mpc = memory()
    read_reference.py_func(mpc, LANE, TABLE, PERIOD, time, spacing)
    return mpc.reference[..., LANE]


@pytest.mark.parametrize(("time", "spacing"), [(0.0, 0.03), (0.123, 0.0251), (0.2, 0.001)])
def test_between_rows_the_reference_is_straight(time, spacing):
    times = time + spacing * np.arange(NODES + 1)
    expected = [np.interp(times, PERIOD * np.arange(len(TABLE)), column) for column in TABLE.T]
    assert_allclose(read(time, spacing), np.transpose(expected), atol=1e-12)


@pytest.mark.parametrize(("time", "spacing"), [(0.39, 0.1), (5.0, 0.1), (0.1, 1e300)])
def test_the_last_row_holds_for_ever(time, spacing):
    rows = read(time, spacing)
    assert_allclose(rows[1:], np.tile(TABLE[-1], (NODES, 1)), atol=1e-12)


@pytest.mark.parametrize(
    ("function", "arguments"),
    [
        (read_reference, (TABLE, PERIOD, 0.1, 0.02)),
        (hover_inputs, (9.81,)),
        (plan_as_reference, ()),
        (respace_plan, (0.05, 0.07, 0.01)),
    ],
)
def test_other_lanes_keep_what_they_have(function, arguments):
    mpc, before = memory(), memory()
    function.py_func(mpc, LANE, *arguments)
    changed = [not np.array_equal(a, b) for a, b in zip(mpc, before, strict=True)]
    assert any(changed)
    for now, then in zip(mpc, before, strict=True):
        assert_array_equal(np.delete(now, LANE, axis=-1), np.delete(then, LANE, axis=-1))


def test_hovering_takes_the_place_of_the_inputs_alone():
    mpc, before = memory(), memory()
    hover_inputs.py_func(mpc, LANE, 9.81)
    assert_array_equal(mpc.reference[:, 10:, LANE], np.tile([9.81, 0, 0, 0], (NODES + 1, 1)))
    assert_array_equal(mpc.reference[:, :10], before.reference[:, :10])


def test_the_reference_can_be_the_plan():
    mpc = memory()
    plan_as_reference.py_func(mpc, LANE)
    assert_array_equal(mpc.X[..., LANE], mpc.reference[:, :10, LANE])
    assert_array_equal(mpc.U[..., LANE], mpc.reference[:NODES, 10:, LANE])


def respaced(old: float, new: float, later: float) -> Mpc:
    mpc = memory()
    respace_plan.py_func(mpc, LANE, old, new, later)
    return mpc


def test_the_same_spacing_keeps_the_plan():
    mpc, before = respaced(0.1, 0.1, 0.0), memory()
    assert_allclose(mpc.X[:NODES, :, LANE], before.X[:NODES, :, LANE], rtol=1e-12)
    assert_allclose(mpc.U[..., LANE], before.U[..., LANE], rtol=1e-12)


@pytest.mark.parametrize(("old", "new", "later"), [(0.1, 0.07, 0.01), (0.1, 0.13, 0.01), (0.1, 0.1, 0.03), (0.05, 0.175, 0.0)])
def test_a_plan_is_read_between_its_nodes_and_the_reference_behind_them(old, new, later):
    mpc, before = respaced(old, new, later), memory()
    times, nodes = new * np.arange(NODES + 1) + later, old * np.arange(NODES + 1)
    reached = times < nodes[-1] - 1e-9
    assert reached.any()
    for i in range(10):
        assert_allclose(mpc.X[reached, i, LANE], np.interp(times[reached], nodes, before.X[:, i, LANE]), rtol=1e-9)
    assert_array_equal(mpc.X[~reached, :, LANE], before.reference[~reached, :10, LANE])
    for a in range(4):  # the last input holds for its node
        assert_allclose(mpc.U[reached[:-1], a, LANE], np.interp(times[:-1][reached[:-1]], nodes[:-1], before.U[:, a, LANE]), rtol=1e-9)
    assert_array_equal(mpc.U[~reached[:-1], :, LANE], before.reference[:-1][~reached[:-1], 10:, LANE])


def test_a_finer_grid_and_back_is_the_plan_again():
    mpc, before = memory(), memory()
    respace_plan.py_func(mpc, LANE, 0.1, 0.05, 0.0)
    respace_plan.py_func(mpc, LANE, 0.05, 0.1, 0.0)
    half = NODES // 2
    assert_allclose(mpc.X[:half, :, LANE], before.X[:half, :, LANE], rtol=1e-12)
    assert_allclose(mpc.U[:half, :, LANE], before.U[:half, :, LANE], rtol=1e-12)


def test_spacings_without_proportion_are_no_harm():
    mpc = respaced(1e-300, 1e10, 0.0)
    assert_array_equal(mpc.X[1:, :, LANE], memory().reference[1:, :10, LANE])
