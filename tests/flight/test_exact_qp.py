"""In flight, two sweeps come near the exact solution of the controller's quadratic problem, and three nearly always reach it."""

from __future__ import annotations

import numpy as np
import pytest

from hotlap.planning.preparation import prepare

from . import scenarios
from .exact_qp import closed_loop, exact, is_bounded, problems, swept

RANGES = np.array([19.9, 20.0, 20.0, 6.0])  # of the inputs: thrust per mass, body rates


def gather(races: tuple[str, ...], wanted: int, every: int, seed: int = 0):
    """Problems with active bounds from flights with scattered weights, with their exact inputs."""
    rng, found = np.random.default_rng(seed), []
    flights = 0
    while len(found) < wanted:
        scenario = prepare(races[flights % len(races)])
        middle = scenario.space.default if flights % 2 else np.array(scenarios.TUNED)
        scattered = scenario.space.clip(middle * np.exp(0.5 * scenario.space.log_step * rng.standard_normal(5)))
        for problem in problems(scenario, np.tile(scattered, (len(scenario.segments), 1)), seed=flights, every=every):
            best = exact(problem)
            if is_bounded(problem, best):
                found.append((problem, best))
        flights += 1
    return found[:wanted]


def errors(found, sweeps: int) -> np.ndarray:
    """Largest difference of the first input from the exact one, in shares of the inputs' ranges."""
    return np.array([np.abs((swept(problem, sweeps)[0] - best[0]) / RANGES).max() for problem, best in found])


@pytest.fixture(scope="module")
def found():
    return gather(("circle-34",), wanted=150, every=20)


@pytest.mark.check
def test_two_sweeps_come_near_and_three_reach_it(found):
    assert np.median(errors(found, 2)) < 1e-3
    assert np.median(errors(found, 3)) < 1e-6


@pytest.mark.check
def test_more_sweeps_come_nearer(found):
    means = [errors(found, sweeps).mean() for sweeps in (1, 2, 3, 6)]
    assert means == sorted(means, reverse=True)
    assert means[-1] < 0.2 * means[0]


@pytest.mark.check
def test_the_oracle_keeps_the_bounds_and_bounds_are_active(found):
    at_bound = 0
    for problem, best in found:
        assert (best >= problem.low[:, 0] - 1e-9).all()
        assert (best <= problem.high[:, 0] + 1e-9).all()
        at_bound += is_bounded(problem, best)
    assert at_bound == len(found)


@pytest.mark.slow
def test_on_two_thousand_problems_of_four_races(record_property):
    many = gather(("circle-34", "qualifier-20", "flip-16", "drop-20"), wanted=2000, every=10)
    table = {sweeps: errors(many, sweeps) for sweeps in (1, 2, 3, 5)}
    for sweeps, each in table.items():
        record_property(f"{sweeps} sweeps", f"median {np.median(each):.1e}, 90 % {np.quantile(each, 0.9):.1e}, largest {each.max():.1e}")
    assert np.median(table[2]) < 1e-3
    assert np.median(table[3]) < 1e-6


@pytest.mark.slow
def test_a_flight_with_sweeps_is_the_flight_with_an_exact_solver(record_property):
    """Tuned weights on circle-34 and qualifier-20, with noise and an unknown dead time, for six seconds."""
    for race in ("circle-34", "qualifier-20"):
        scenario = prepare(race)
        parameters = np.tile(scenarios.TUNED, (len(scenario.segments), 1))
        for seed in range(2):
            best = closed_loop(scenario, parameters, seed, steps=600, sweeps=None)
            apart = {n: np.linalg.norm(closed_loop(scenario, parameters, seed, 600, n) - best, axis=1).max() for n in (1, 2, 3)}
            record_property(f"{race}, seed {seed}", ", ".join(f"{n} sweeps {distance:.1e} m" for n, distance in apart.items()))
            assert apart[2] < 0.05
            assert apart[3] < 0.03
