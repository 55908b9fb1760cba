"""Sensitivity: parameters that matter lose completion, those that do not lose none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fake_world import OPTIMUM, FakeWorld, make_scenario
from hotlap.analysis.sensitivity import FACTORS, survey_sensitivity
from hotlap.core.seeds import Stream, flight_seeds


class OnlyTheFirst(FakeWorld):
    """A world in which only the first parameter of the second segment counts."""

    def fly(self, scenario, parameters, seeds, *, vehicle_parameters=None, log=()):
        self.seen = parameters, seeds
        counted = np.tile(OPTIMUM, (*parameters.shape[:2], 1))
        counted[:, 1, 0] = parameters[:, 1, 0]
        return super().fly(scenario, counted, seeds, vehicle_parameters=vehicle_parameters, log=log)


@pytest.fixture
def found():
    return survey_sensitivity(make_scenario(), OnlyTheFirst(noise=0.1), np.tile(OPTIMUM, (2, 1)), seed=3)


def test_what_does_not_count_loses_nothing(found):
    np.testing.assert_array_equal(found.completion[1:], 1.0)
    np.testing.assert_array_equal(found.complete[1:], 1.0)
    assert (found.by_segment[:, 1:] == 0).all()
    assert found.by_segment[0, 0] == 0


def test_what_counts_loses_the_more_the_further(found):
    middle = FACTORS.index(1.0)
    assert found.completion[0, middle] == 1
    assert (np.diff(found.completion[0, : middle + 1]) >= 0).all()
    assert (np.diff(found.completion[0, middle:]) <= 0).all()
    assert found.by_segment[1, 0] > 0.1


def test_the_cost_tells_values_apart_where_no_gate_is_passed():
    found = survey_sensitivity(make_scenario(), FakeWorld(), np.tile(20 * OPTIMUM, (2, 1)), seed=3)
    assert np.ptp(found.completion) == 0
    assert (np.ptp(found.cost, axis=1) > 0).any()


def test_shapes_and_shares(found):
    assert found.completion.shape == found.complete.shape == (5, len(FACTORS))
    assert found.cost.shape == found.completion.shape
    assert found.by_segment.shape == found.cost_by_segment.shape == (2, 5)
    assert ((found.complete >= 0) & (found.complete <= found.completion)).all()


def test_nothing_leaves_its_bounds_and_all_meet_the_same_noise():
    scenario, world = make_scenario(), OnlyTheFirst()
    survey_sensitivity(scenario, world, np.tile(scenario.space.high, (2, 1)), seed=3, flights=4)
    parameters, seeds = world.seen
    assert scenario.space.contains(parameters)
    assert set(seeds.tolist()) <= set(flight_seeds(3, Stream.DEMONSTRATION, 0, 4).tolist())


def test_a_point_that_occurs_twice_is_flown_once():
    world = FakeWorld()
    survey_sensitivity(make_scenario(), world, np.tile(OPTIMUM, (2, 1)), seed=0, flights=3)
    by_segment = 2 * 5 * 2 * 3  # in each segment each parameter, down and up
    assert world.batches == [(5 * 6 + 1) * 3 - 3 * _clipped() + by_segment]


def _clipped() -> int:
    """Points that bounds move onto each other: none but those beyond both of a pair of factors."""
    space, points = make_scenario().space, OPTIMUM[:, None] * np.array(FACTORS)
    kept = [len(np.unique(np.clip(row, low, high))) for row, low, high in zip(points, space.low, space.high, strict=True)]
    return 5 * len(FACTORS) - sum(kept)


def test_the_cost_tells_only_where_completion_tells_nothing(found):
    assert not found.flat
    assert not found.cost_tells
    whole = np.ones_like(found.completion)
    same = replace(found, completion=whole, by_segment=np.zeros_like(found.by_segment))
    for level in (0.0, 0.5, 1.0):
        told = replace(same, completion=level * whole)
        assert (told.flat, told.cost_tells, told.cost_tells_by_segment) == (True, True, True)
    alone = replace(same, by_segment=np.full_like(found.by_segment, 0.1))
    assert (alone.cost_tells, alone.cost_tells_by_segment) == (True, False)
    unknown = replace(same, cost=np.full_like(found.cost, np.inf), cost_by_segment=np.full_like(found.cost_by_segment, np.nan))
    assert (unknown.flat, unknown.cost_tells, unknown.cost_tells_by_segment) == (True, False, False)
