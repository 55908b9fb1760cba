"""Planning: the minimum-time reference of a race.

    race -> problem -> point mass -> full quadrotor -> rows every 10 ms -> run-out

Multi-phase direct multiple shooting: a free duration and a fixed number of RK4 intervals for each waypoint, which is
imposed at the end of its phase. That solves the same problem as complementary progress constraints
(Foehn, Romero, Scaramuzza, "Time-optimal planning for quadrotor waypoint flight", Science Robotics 2021), whose
order of waypoints is fixed as well, in seconds. The quadrotor is either the ideal one of that work (`planning.dynamics = "ideal"`:
free body rates at the start, thrust at once, linear drag) or the vehicle with motors, rate loop and all drags (`full_stage`).
CasADi is loaded only when something is planned.
"""

from __future__ import annotations

import time

from hotlap.planning import cache as plan_cache
from hotlap.planning.problem import Problem
from hotlap.race.race import Race
from hotlap.reference.reference import Reference

__all__ = ["plan"]


def plan(race: Race, *, cache: bool = True) -> Reference:
    """Plan a race in minimum time, with a run-out behind its end.

    Args:
        race: its track, planning model and planning settings count, nothing else.
        cache: take the plan from the user's cache if it is there, and leave it there.

    Raises:
        PlanningError: naming the gate, when there is no plan or none was found.
    """
    problem = Problem.of(race)
    key = plan_cache.key(problem) if cache else ""
    reference = plan_cache.load(key) if cache else None
    if reference is None:
        reference = _make(problem)
        if cache:
            plan_cache.save(key, reference)
    return reference


def _make(problem: Problem) -> Reference:
    """Plan, sample and extend."""
    from hotlap.planning.planner import find_plan  # noqa: PLC0415  CasADi is not needed for a cached plan
    from hotlap.planning.sampling import last_acceleration, sample  # noqa: PLC0415
    from hotlap.reference.run_out import extend  # noqa: PLC0415

    start = time.process_time()
    trajectory = find_plan(problem)
    reference = sample(problem, trajectory, cpu_time=time.process_time() - start)
    return extend(reference, gravity=problem.quadrotor.gravity, drag=problem.drag, acceleration=last_acceleration(problem, reference))
