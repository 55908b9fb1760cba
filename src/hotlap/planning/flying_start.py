"""Flying starts that end in something, whatever the vehicle does: told before a plan is sought."""

from __future__ import annotations

import numpy as np

from hotlap.core.errors import PlanningError
from hotlap.planning.problem import Floats, Problem
from hotlap.race.bodies import Wall
from hotlap.race.flight_performance import FASTEST
from hotlap.race.solids import Solid, floor_at, solids_of

MOMENTS = 400  # at which the vehicle is looked at, until it could have stopped
TOUCH = 1e-6  # m


def refuse_flying_start(problem: Problem) -> None:
    """Refuse a start so fast that no thrust keeps the vehicle from obstacles, frames, walls or floor.

    After t seconds it is within a ball of radius (T / m + drag) t^2 / 2 around start + v t + g t^2 / 2. Where that ball lies within
    something, the vehicle cannot have avoided it. In front of a wall this is v^2 / (2 a).

    Raises:
        PlanningError: naming the start velocity and what is in the way.
    """
    speed = float(np.linalg.norm(problem.start_velocity))
    if speed == 0:
        return
    if speed > FASTEST:
        raise PlanningError(
            problem.track, None, f"start_velocity: {speed:.3g} m/s is more than the {FASTEST:g} m/s that plans are made for"
        )
    quadrotor = problem.quadrotor
    times = np.linspace(0, speed / (quadrotor.max_acceleration - quadrotor.gravity), MOMENTS)
    centres = problem.start + times[:, None] * problem.start_velocity - 0.5 * quadrotor.gravity * times[:, None] ** 2 * [0.0, 0.0, 1.0]
    speeds = speed + (quadrotor.max_acceleration + quadrotor.gravity) * times
    reached = 0.5 * (quadrotor.max_acceleration + _largest_drag(problem, speeds)) * times**2
    under_way = times < _earliest_end(problem, times, centres, reached)
    for solid, kept in _in_the_way(problem):
        least = min(kept, float(solid.measure(problem.start[None])[0][0]))
        if (solid.measure(centres)[0] + reached < least - TOUCH)[under_way].any():
            reason = f"start_velocity: at {speed:.3g} m/s even full thrust does not keep the vehicle from {solid.name}"
            raise PlanningError(problem.track, None, reason)


def _largest_drag(problem: Problem, speeds: Floats) -> Floats:
    """[m/s^2] at speeds (n,) [m/s], in whatever attitude."""
    quadrotor = problem.quadrotor
    if not problem.full:
        return problem.drag * speeds
    rotors = quadrotor.rotor_drag * quadrotor.rotor_count * np.sqrt(quadrotor.rotor_thrust[1])
    return (max(quadrotor.drag) + (rotors + max(quadrotor.body_drag) * speeds) / quadrotor.mass) * speeds


def _earliest_end(problem: Problem, times: Floats, centres: Floats, reached: Floats) -> float:
    """[s] before which some target is out of reach, so that the plan cannot have ended; infinite where one is at all times.

    Args:
        problem: its targets count.
        times: shape (n,) [s].
        centres: shape (n, 3) [m] (world) middles of where the vehicle can be.
        reached: shape (n,) [m] radii of that.
    """
    earliest = 0.0
    for target in problem.targets:
        wide = target.radius if target.plane is None else float(np.linalg.norm(target.plane.outline() - target.position, axis=1).max())
        near = np.linalg.norm(centres - target.position, axis=1) <= reached + wide
        earliest = max(earliest, float(times[near.argmax()]) if near.any() else np.inf)
    return earliest


def _in_the_way(problem: Problem) -> list[tuple[Solid, float]]:
    """Solids, each with the distance [m] that the vehicle's centre keeps from it: from walls what every phase of a plan keeps."""
    found = [(floor_at(problem.floor), 0.0)] if np.isfinite(problem.floor) else []
    for axis in range(3):
        for side, places in ((1.0, problem.walls[0]), (-1.0, problem.walls[1])):
            if np.isfinite(places[axis]):
                wall = Solid(f"the wall at {'xyz'[axis]} = {places[axis]:g} m", (Wall(side * np.eye(3)[axis], side * places[axis]),))
                found.append((wall, min(problem.margin, float(wall.measure(problem.points)[0].min()))))
    obstacles = () if problem.course is None else solids_of(problem.course, problem.tolerance)
    return found + [(solid, problem.radius) for solid in obstacles]
