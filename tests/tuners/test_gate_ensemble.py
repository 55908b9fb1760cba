"""Gate processes that are computed together are the gate processes, however they came to know their flights."""

from __future__ import annotations

import numpy as np
import pytest

from hotlap.tuners.surrogates import gate_process
from hotlap.tuners.surrogates.gate_ensemble import GateEnsemble, Processes, _standardise, climb, log_posterior, values_of
from hotlap.tuners.surrogates.gate_process import UNKNOWN, GateKernel

SEGMENTS, SIZE = 4, 3
GATE_SEGMENTS = np.array([0, 0, 1, 2, 2, 3, 3, 3])
PROCESSES = Processes.of_gates(GATE_SEGMENTS)
KERNEL = GateKernel(np.array([0.8, 1.1, 1.4, 0.3, -1.5]))


def flights(count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Points and misses, some unknown."""
    rng = np.random.default_rng(seed)
    points = 2 * rng.standard_normal((count, SEGMENTS, SIZE))
    misses = 0.3 * points[:, GATE_SEGMENTS].sum(axis=2) + 0.2 * rng.standard_normal((count, len(GATE_SEGMENTS)))
    misses[rng.random(count) < 0.4, 3:] = np.nan
    misses[rng.random(count) < 0.3, 6] = np.nan
    return points, misses


@pytest.fixture(scope="module")
def ensemble() -> GateEnsemble:
    points, misses = flights(40)
    return GateEnsemble(PROCESSES, KERNEL, points, *values_of(PROCESSES, misses))


def test_it_predicts_what_each_process_predicts_alone(ensemble):
    points, misses = flights(40)
    alone = gate_process.condition(points, gate_process.gate_groups(misses, GATE_SEGMENTS), KERNEL)
    for mine, theirs in zip(ensemble.predict(flights(30, seed=1)[0]), alone.predict(flights(30, seed=1)[0]), strict=True):
        np.testing.assert_allclose(mine, theirs, atol=1e-5)


def test_flights_that_are_added_one_by_one_teach_it_the_same(ensemble):
    points, misses = flights(40)
    values, seen = values_of(PROCESSES, misses)
    grown = GateEnsemble(PROCESSES, KERNEL, points[:25], values[:, :25], seen[:, :25])
    grown.append(points[25:30], values[:, 25:30], seen[:, 25:30])
    grown.append(points[30:], values[:, 30:], seen[:, 30:])
    assert len(grown) == len(ensemble) == 40
    for mine, theirs in zip(grown.predict(flights(30, seed=1)[0]), ensemble.predict(flights(30, seed=1)[0]), strict=True):
        np.testing.assert_allclose(mine, theirs, atol=1e-5)


def test_means_alone_are_the_same_means(ensemble):
    elsewhere = flights(30, seed=1)[0]
    means, deviations, _ = ensemble.predict(elsewhere, means_only=True)
    np.testing.assert_array_equal(means, ensemble.predict(elsewhere)[0])
    assert not deviations.any()


def test_the_density_of_a_kernel_is_that_of_all_processes():
    points, misses = flights(40)
    values, seen = values_of(PROCESSES, misses)
    groups = gate_process.gate_groups(misses, GATE_SEGMENTS)
    mine = log_posterior(PROCESSES, points, _standardise(values, seen)[2], seen, KERNEL)
    assert mine == pytest.approx(gate_process.log_posterior(points, groups, KERNEL))


def test_a_gate_that_was_reached_fewer_than_twice_is_not_known():
    points, misses = flights(10)
    misses[1:, 5:] = np.nan
    means, deviations, noises = GateEnsemble(PROCESSES, KERNEL, points, *values_of(PROCESSES, misses)).predict(points)
    assert (means[:, 5:] == UNKNOWN[0]).all()
    assert (deviations[:, 5:] == UNKNOWN[1]).all()
    assert (noises[5:] == UNKNOWN[2]).all()
    assert not (means[:, :5] == UNKNOWN[0]).any()


def test_the_search_for_a_kernel_finds_a_likelier_one():
    points, misses = flights(40)
    values, seen = values_of(PROCESSES, misses)
    start = GateKernel.prior(SIZE)
    found = climb(PROCESSES, points, values, seen, start, 30, np.random.default_rng(0))
    standard = _standardise(values, seen)[2]
    assert log_posterior(PROCESSES, points, standard, seen, found) > log_posterior(PROCESSES, points, standard, seen, start) + 5
