"""The planner: point mass, then quadrotor; what is accepted, and how a failure is worded."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from hotlap.core.errors import PlanningError
from hotlap.planning.clear_search import search_clear
from hotlap.planning.diagnosis import describe, refuse_coarse, refuse_impossible
from hotlap.planning.ipopt import Solution
from hotlap.planning.minimum_time import plan_quadrotor
from hotlap.planning.point_mass import coarse, guess_point_mass, plan_point_mass
from hotlap.planning.problem import Problem, Trajectory
from hotlap.planning.surroundings import Surroundings
from hotlap.planning.warm_start import around_point_mass, hover_along

SLOWER, LATER = 1.06, 0.3  # a plan may take this times the point mass's duration, and this many seconds more
AGREEMENT = 0.01  # relative difference of two plans that confirm each other


def find_plan(problem: Problem) -> Trajectory:
    """The fastest trajectory: states (position, velocity, attitude, rates), controls rotor thrusts [N].

    Raises:
        PlanningError: naming the gate, when there is none, or none was found.
        KeyboardInterrupt: on Ctrl-C.
    """
    refuse_impossible(problem)
    solution = _search(problem) if problem.course is None else _search_course(problem)
    refuse_coarse(problem, solution.trajectory)
    return solution.trajectory


def _search(problem: Problem) -> Solution:
    """From the point-mass plan; where that fails or is suspiciously slow, once more from straight lines.

    Slow means caught in a detour. A sluggish quadrotor is slow from wherever it starts: there two plans that agree are taken.
    """
    mass = plan_point_mass(problem)
    first = plan_quadrotor(problem, around_point_mass(problem, mass.trajectory), barrier=0.01, iterations=300)
    if _accepted(first, mass):
        return first
    second = plan_quadrotor(problem, hover_along(problem), barrier=0.1, iterations=500)
    if _accepted(second, mass):
        return second
    if first.converged and second.converged and abs(first.trajectory.duration / second.trajectory.duration - 1) < AGREEMENT:
        return min(first, second, key=lambda solution: solution.trajectory.duration)
    raise _failure(problem, mass, first, second)


def _search_course(problem: Problem) -> Solution:
    """From the point-mass plan that keeps clear of everything, once more from curves where that fails."""
    surroundings = Surroundings.of(problem)
    surroundings.refuse_blocked()
    mass, surroundings, _ = search_clear(surroundings, partial(plan_point_mass, problem), guess_point_mass(coarse(problem)))
    found = []
    surroundings = replace(surroundings, extra={})
    for guess, barrier in ((around_point_mass(problem, mass.trajectory), 0.01), (hover_along(problem), 0.1)):
        def solve(guess, rows):
            return plan_quadrotor(problem, guess, barrier=barrier, iterations=300, rows=rows)
        solution, around, faults = search_clear(surroundings, solve, guess, led=barrier == 0.01)
        touched = [fault for fault in faults if fault.distance < around.kept[fault.kept].least]
        if _accepted(solution, mass) and not touched:
            return solution
        found.append((solution, around, touched))
    solution, around, touched = next((f for f in found if f[0].converged), found[0])
    if touched:
        fault = min(touched, key=lambda f: f.distance)
        raise problem.error(fault.phase, f"found only a way that touches {around.kept[fault.kept].solid.name}")
    raise _failure(problem, mass, *[f[0] for f in found])


def _accepted(solution: Solution, mass: Solution) -> bool:
    """Converged, and not much slower than the point mass (where that has a plan)."""
    return solution.converged and (not mass.converged or solution.trajectory.duration < SLOWER * mass.trajectory.duration + LATER)


def _failure(problem: Problem, mass: Solution, first: Solution, second: Solution) -> PlanningError:
    """The error for a search without result: the point mass shows best what is impossible for any drone."""
    failed = next((solution for solution in (mass, second, first) if not solution.converged), None)
    if failed is not None and not any(solution.converged for solution in (first, second)):
        return describe(problem, failed)
    best = min((solution for solution in (first, second) if solution.converged), key=lambda solution: solution.trajectory.duration)
    phase = int(np.argmax(best.trajectory.durations - mass.trajectory.durations))
    found, wanted = best.trajectory.durations[phase], mass.trajectory.durations[phase]
    return problem.error(phase, f"found only a detour of {found:.2f} s, where a point mass takes {wanted:.2f} s")
