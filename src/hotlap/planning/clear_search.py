"""Clear search: plans that keep clear of obstacles and frames and pass gates in their direction, solved again until they do."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from hotlap.core.errors import PlanningError
from hotlap.planning.detours import along, find_way
from hotlap.planning.diagnosis import describe
from hotlap.planning.guess import guessed_speed
from hotlap.planning.ipopt import Solution
from hotlap.planning.linear_rows import LinearRows
from hotlap.planning.problem import Trajectory
from hotlap.planning.surroundings import DEEP, Fault, Path, Surroundings

ROUNDS, SHRINKS = 6, 2
CLOSED = 1e-3  # largest gap of the equations of motion in a trajectory that counts as one

Solve = Callable[[Trajectory, LinearRows], Solution]


@dataclass(frozen=True)
class Clear:
    """What a search ended with.

    Attributes:
        solution: the last one.
        surroundings: with what was added on the way.
        faults: where the solution comes too near.
    """

    solution: Solution
    surroundings: Surroundings
    faults: list[Fault]

    @property
    def clear(self) -> bool:
        """Whether there is a solution that touches nothing and crosses no opening against its direction."""
        return self.solution.converged and not any(self._hits(fault) for fault in self.faults)

    def error(self) -> PlanningError:
        """Why it is not clear."""
        problem, hits = self.surroundings.problem, [fault for fault in self.faults if self._hits(fault)]
        if not hits or (not self.solution.converged and self.solution.gaps.max() > CLOSED):
            return describe(problem, self.solution)
        worst = min(hits, key=lambda fault: fault.distance)
        solid = self.surroundings.kept[worst.kept].solid
        hit = f"crosses {solid.name} the wrong way" if solid.opening else f"touches {solid.name}"
        return problem.error(worst.phase, f"no way to it was found; the best one {hit}")

    def _hits(self, fault: Fault) -> bool:
        return fault.touched or self.surroundings.kept[fault.kept].solid.opening


def search_clear(surroundings: Surroundings, solve: Solve, guess: Trajectory, *, led: bool = False) -> Clear:
    """Solve, look where the result comes too near, keep it away from there, and solve again.

    Args:
        surroundings: what to keep clear of.
        solve: takes a guess and rows.
        guess: where to begin.
        led: whether the guess itself keeps clear, so that rows can be made around it.
    """
    rows = surroundings.rows(Path.of(guess)) if led else LinearRows.none()
    solution, shrinks = solve(guess, rows), 0
    for _ in range(ROUNDS):
        if not solution.converged and (not rows.count or shrinks == SHRINKS or surroundings.problem.clearance_given):
            break
        if not solution.converged:
            surroundings, shrinks = surroundings.shrunk(), shrinks + 1
            rows = surroundings.rows(Path.of(guess))
            solution = solve(guess, rows)
            continue
        result = _looked_at(solution, surroundings)
        surroundings, faults = result.surroundings, result.faults
        if not faults:
            return result
        guess = led_around(surroundings, solution.trajectory, faults)
        surroundings = surroundings.with_extra([fault for fault in faults if not _deep(surroundings, fault)])
        rows = surroundings.rows(Path.of(guess))
        solution = solve(guess, rows)
    return _looked_at(solution, surroundings)


def _looked_at(solution: Solution, surroundings: Surroundings) -> Clear:
    """Where a solution comes too near, and which openings it crosses against their direction."""
    path = Path.of(solution.trajectory)
    if solution.converged:
        surroundings = surroundings.with_plugs(path)
    return Clear(solution, surroundings, surroundings.faults(path))


def _deep(surroundings: Surroundings, fault: Fault) -> bool:
    return fault.distance < DEEP * surroundings.kept[fault.kept].margin


def led_around(surroundings: Surroundings, trajectory: Trajectory, faults: list[Fault]) -> Trajectory:
    """The trajectory, where it runs through something led around it along straight lines; as it is where there is no way around."""
    problem, states, durations = surroundings.problem, trajectory.states.copy(), trajectory.durations.copy()
    ends, speed = trajectory.ends, guessed_speed(surroundings.problem)
    for phase in sorted({fault.phase for fault in faults if _deep(surroundings, fault)}):
        for place in (phase, phase + 1):
            node = 0 if place == 0 else int(ends[place - 1])
            if place and surroundings.lacks(states[node : node + 1, :3])[0][0] > 0:
                target = problem.targets[place - 1]
                beside = states[int(ends[place - 1] - trajectory.intervals[place - 1]), :3] if target.inside else states[node, :3]
                states[node, :3] = surroundings.free_place(target, beside)
        first, last = int(ends[phase] - trajectory.intervals[phase]), int(ends[phase])
        way = find_way(surroundings, states[first, :3], states[last, :3])
        if way is None:
            continue
        places, directions = along(way, np.linspace(0, 1, last - first + 1))
        states[first + 1 : last, :3] = places[1:-1]
        states[first + 1 : last, 3:6] = speed * directions[1:-1]
        length = float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum())
        durations[phase] = max(durations[phase], length / speed)
    return replace(trajectory, states=states, durations=durations)
