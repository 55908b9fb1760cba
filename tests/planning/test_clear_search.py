"""Searches among obstacles accept what is clear, and look at the last plan as at the first."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np
import pytest

from hotlap.planning.clear_search import ROUNDS, SHRINKS, search_clear
from hotlap.planning.ipopt import Solution
from hotlap.planning.linear_rows import LinearRows
from hotlap.planning.point_mass import guess_point_mass
from hotlap.planning.problem import Problem, Trajectory
from hotlap.planning.surroundings import Path, Surroundings

from .test_openings import SQUARE, make_race

FLIPPED = Problem.of(make_race({**SQUARE, "yaw": np.pi}, poles=({"position": (2.0, 1.0), "radius": 0.5},)))
THROUGH = guess_point_mass(FLIPPED)  # through the gate against its direction, 0.5 m beside the pole


def moved(distance: float) -> Trajectory:
    """The way, aside by a distance [m]."""
    states = THROUGH.states.copy()
    states[:, 1] += distance
    return dataclasses.replace(THROUGH, states=states)


def found(trajectory: Trajectory) -> Solution:
    return Solution(trajectory, True, "", 1, np.zeros(2), np.zeros(2))


def test_a_way_through_an_opening_against_its_direction_is_not_clear():
    result = search_clear(Surroundings.of(FLIPPED), lambda _guess, _rows: found(THROUGH), THROUGH)
    assert not result.clear
    assert "gate 1: no way to it was found; the best one crosses gate 1 the wrong way" in str(result.error())


def test_an_opening_that_is_crossed_too_fast_to_see_is_crossed():
    few = np.append(0, THROUGH.ends)  # places 0.4 m apart
    fast = Trajectory(np.full(2, 0.01), THROUGH.states[few], THROUGH.controls[:2])
    assert np.linalg.norm(np.diff(Path.of(fast).points, axis=0), axis=1).max() > 0.3
    surroundings = Surroundings.of(FLIPPED).with_plugs(Path.of(fast))
    faults = surroundings.faults(Path.of(fast))
    assert [surroundings.kept[fault.kept].solid.name for fault in faults] == ["gate 1"]


@pytest.mark.parametrize("times", range(1, SHRINKS + 1))
def test_an_opening_stays_closed_where_clearances_shrink(times):
    surroundings = Surroundings.of(FLIPPED).with_plugs(Path.of(THROUGH))
    for _ in range(times):
        surroundings = surroundings.shrunk()
    assert any(surroundings.kept[fault.kept].solid.opening for fault in surroundings.faults(Path.of(THROUGH)))


def test_the_last_plan_of_a_search_is_looked_at():
    ways: Iterator[Trajectory] = iter([moved(-1.2)] * ROUNDS + [THROUGH])  # all but the last near the frame

    def solve(_guess: Trajectory, _rows: LinearRows) -> Solution:
        return found(next(ways))

    assert not search_clear(Surroundings.of(FLIPPED), solve, THROUGH).clear
