"""Rows of a plan do not depend on how its nodes happen to be written."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.testing import assert_allclose

from hotlap.planning.sampling import sample, states_at

from . import small


def test_signs_of_quaternions_at_the_nodes_do_not_matter():
    _, problem, trajectory, reference = small.planned("drag")
    states = trajectory.states.copy()
    states[20:, 6:10] *= -1
    states[31, 6:10] *= -1
    found = sample(problem, dataclasses.replace(trajectory, states=states), cpu_time=1.5)
    assert_allclose(found.table, reference.table, atol=1e-12)
    assert found.cpu_time == 1.5


def test_states_at_the_nodes_are_those_of_the_nodes():
    _, problem, trajectory, _ = small.planned("drag")
    states, intervals = states_at(problem, trajectory, trajectory.times)
    assert_allclose(states, trajectory.states, atol=1e-4)
    assert intervals[0] == 0
    assert intervals[-1] == len(trajectory.controls) - 1
    assert np.all(np.diff(intervals) >= 0)
