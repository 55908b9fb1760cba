"""The planner: point mass, then quadrotor; what is accepted, and how a failure is worded."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from hotlap.core.errors import PlanningError
from hotlap.planning.clear_search import Clear, search_clear
from hotlap.planning.diagnosis import describe, refuse_coarse, refuse_impossible
from hotlap.planning.flying_start import refuse_flying_start
from hotlap.planning.ipopt import Solution
from hotlap.planning.laps import few_laps, repeat_lap
from hotlap.planning.linear_rows import LinearRows
from hotlap.planning.minimum_time import plan_quadrotor
from hotlap.planning.point_mass import coarse, guess_point_mass, plan_point_mass
from hotlap.planning.problem import Problem, Trajectory
from hotlap.planning.surroundings import Surroundings
from hotlap.planning.warm_start import around_point_mass, hover_along

SLOWER, LATER = 1.06, 0.3  # a plan may take this times the point mass's duration, and this many seconds more
MOST_FAILURES = 2  # searches among obstacles that may fail before the next is not tried
AGREEMENT = 0.01  # relative difference of two plans that confirm each other


def find_plan(problem: Problem) -> Trajectory:
    """The fastest trajectory: states (position, velocity, attitude, rates), controls rotor thrusts [N].

    Raises:
        PlanningError: naming the gate, when there is none, or none was found.
        KeyboardInterrupt: on Ctrl-C.
    """
    refuse_impossible(problem)
    refuse_flying_start(problem)
    solution = _search(problem) if problem.course is None else _search_course(problem)
    refuse_coarse(problem, solution.trajectory)
    return solution.trajectory


def _search(problem: Problem) -> Solution:
    """From the point-mass plan; where that fails or is suspiciously slow, once more from straight lines, upright and turned over.

    Slow means caught in a detour, or upright on the way down. A sluggish quadrotor is slow from wherever it starts: there two plans that
    agree are taken. Without a plan of the point mass nothing tells what is slow: the best of all is taken.
    """
    mass = plan_point_mass(problem)
    found: list[Solution] = []
    for guess, barrier, iterations in _guesses(problem, mass):
        found.append(plan_quadrotor(problem, guess, barrier=barrier, iterations=iterations))
        if mass.converged and _accepted(found[-1], mass):
            return found[-1]
        if mass.converged and _confirmed(found):
            return _fastest(found)
    if not mass.converged and any(solution.converged for solution in found):
        return _fastest(found)
    raise _failure(problem, mass, found)


def _guesses(problem: Problem, mass: Solution) -> Iterator[tuple[Trajectory, float, int]]:
    """Where to search from, with the first barrier and the number of iterations."""
    few = few_laps(problem)
    if few is not None:
        yield repeat_lap(problem, few, find_plan(few)), 1e-4, 300
    yield around_point_mass(problem, mass.trajectory), 0.01, 300
    yield hover_along(problem), 0.1, 500
    yield hover_along(problem, inverted=True), 0.1, 500


def _confirmed(found: list[Solution]) -> bool:
    """Whether the last plan agrees with one before it."""
    last = found[-1]
    others = [solution.trajectory.duration for solution in found[:-1] if solution.converged]
    return last.converged and any(abs(duration / last.trajectory.duration - 1) < AGREEMENT for duration in others)


def _fastest(found: list[Solution]) -> Solution:
    """The shortest plan of those that converged."""
    return min((solution for solution in found if solution.converged), key=lambda solution: solution.trajectory.duration)


def _search_course(problem: Problem) -> Solution:
    """As `_search`, every time until the plan keeps clear of obstacles, frames, and openings that are not to be crossed."""
    surroundings = Surroundings.of(problem)
    surroundings.refuse_blocked()
    rough = search_clear(surroundings, partial(plan_point_mass, problem), guess_point_mass(coarse(problem)))
    mass, found, failed = rough.solution, list[Solution](), list[Clear]()
    for guess, barrier, iterations in _guesses(problem, mass):
        solve = partial(_solve, problem, barrier=barrier, iterations=iterations)
        result = search_clear(rough.surroundings.without_extra(), solve, guess, led=not found and not failed)
        if result.clear:
            found.append(result.solution)
            if mass.converged and (_accepted(found[-1], mass) or _confirmed(found)):
                return _fastest(found)
        else:
            failed.append(result)
            if len(failed) == MOST_FAILURES:
                break
    if found and not mass.converged:
        return _fastest(found)
    raise _failure(problem, mass, found) if found else failed[0].error()


def _solve(problem: Problem, guess: Trajectory, rows: LinearRows, *, barrier: float, iterations: int) -> Solution:
    return plan_quadrotor(problem, guess, barrier=barrier, iterations=iterations, rows=rows)


def _accepted(solution: Solution, mass: Solution) -> bool:
    """Converged, and not much slower than the point mass."""
    return solution.converged and solution.trajectory.duration < SLOWER * mass.trajectory.duration + LATER


def _failure(problem: Problem, mass: Solution, found: list[Solution]) -> PlanningError:
    """The error for a search without result: the point mass shows best what is impossible for any drone."""
    if not any(solution.converged for solution in found):
        return describe(problem, next(solution for solution in (mass, *reversed(found)) if not solution.converged))
    best = _fastest(found)
    phase = int(np.argmax(best.trajectory.durations - mass.trajectory.durations))
    took, wanted = best.trajectory.durations[phase], mass.trajectory.durations[phase]
    return problem.error(phase, f"found only a detour of {took:.2f} s, where a point mass takes {wanted:.2f} s")
