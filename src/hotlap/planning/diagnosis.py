"""Diagnosis: which gate makes a plan impossible, and why."""

from __future__ import annotations

import numpy as np

from hotlap.core.errors import PlanningError
from hotlap.planning.ipopt import Solution
from hotlap.planning.minimum_time import model_parameters, stage_of
from hotlap.planning.problem import LONGEST, Problem, Trajectory
from hotlap.planning.targets import Target

REFINEMENT = 8  # a coarse interval is told by integrating it in so many parts

REASONS = {
    "Infeasible_Problem_Detected": "no trajectory within the limits was found",
    "Maximum_Iterations_Exceeded": "the optimiser did not converge",
    "Restoration_Failed": "the optimiser got stuck",
}


def refuse_impossible(problem: Problem) -> None:
    """Refuse what no trajectory can do, before one is sought.

    Raises:
        PlanningError: for a start or waypoint below the floor, or a leg that takes too long at any speed.
    """
    if problem.start[2] < problem.floor:
        raise PlanningError(problem.track, None, f"the start at z = {problem.start[2]:g} m lies below the floor at {problem.floor:g} m")
    for phase, target in enumerate(problem.targets):
        if _top(target) < problem.floor:
            place = f"z = {target.position[2]:g} m lies more than {target.radius:g} m" if target.plane is None else "its opening lies"
            raise problem.error(phase, f"{place} below the floor at {problem.floor:g} m")
    acceleration = problem.quadrotor.max_acceleration + problem.quadrotor.gravity
    fastest = acceleration * LONGEST * np.arange(1, problem.phases + 1)  # falling all the way under full thrust
    if problem.drag > 0:
        fastest = np.minimum(fastest, acceleration / problem.drag)
    far = problem.legs - 2 * np.where(np.isfinite(problem.radii), problem.radii, 0.0) > fastest * LONGEST
    if far.any():
        phase = int(np.argmax(far))
        even = f"more than {LONGEST:g} s even at {fastest[phase]:.0f} m/s (gates are in metres)"
        raise problem.error(phase, f"{problem.legs[phase]:.0f} m away from the point before it: {even}")


def _top(target: Target) -> float:
    """[m] (world) height up to which a target reaches."""
    if target.plane is None:
        return float(target.position[2]) + target.radius
    return float(target.plane.outline()[:, 2].max() + target.along * target.plane.normal[2])


def refuse_coarse(problem: Problem, plan: Trajectory) -> None:
    """Refuse a plan whose intervals are too long for its integrator.

    Raises:
        PlanningError: where an interval, integrated in finer steps, ends further off than the tolerance.
    """
    states, model = plan.states[:-1].T, model_parameters(problem)
    step = stage_of(problem).step.map(len(plan.controls))
    for _ in range(REFINEMENT):
        states = step(states, plan.controls.T, plan.steps[None] / REFINEMENT, np.tile(model[:, None], len(plan.controls)))
    errors = np.linalg.norm(np.asarray(states).T[:, :3] - plan.states[1:, :3], axis=1)
    worst = int(np.argmax(errors))
    if errors[worst] > problem.tolerance:
        reason = f"intervals of {plan.steps[worst]:.2g} s are too coarse on the way to it ({errors[worst]:.2g} m off): raise planning.nodes"
        raise problem.error(int(plan.owners[worst]), reason)


def describe(problem: Problem, solution: Solution) -> PlanningError:
    """The error for a search that ended without a solution: the phase that is furthest from one."""
    misses, gaps = solution.misses, solution.gaps
    reason = REASONS.get(solution.status, f"the optimiser failed ({solution.status})")
    phase = int(np.argmax(np.maximum(misses, gaps)))
    if misses[phase] >= gaps[phase] and np.isfinite(problem.radii[phase]):
        return problem.error(phase, f"{reason}; the best one misses it by {misses[phase] + problem.radii[phase]:.2g} m")
    return problem.error(phase, f"{reason}; on the way to it the equations of motion fail by {gaps[phase]:.2g}")
