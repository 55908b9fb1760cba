"""Laps: the plan of many laps begins with that of three, whose second lap is repeated."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from hotlap.planning.full_stage import BODY, COMMANDED
from hotlap.planning.minimum_time import RATES
from hotlap.planning.problem import Floats, Problem, Trajectory
from hotlap.planning.stage import ATTITUDE
from hotlap.reference.attitude import CONJUGATE, product

FEW, MANY = 3, 6  # laps: of the short plan; from how many on it is made


def few_laps(problem: Problem) -> Problem | None:
    """The first, the second and the last lap of a course; None where it has not many laps, or laps differ in their intervals."""
    if problem.course is None or problem.course.laps < MANY:
        return None
    laps = _laps(problem)
    kept = (laps < FEW - 1) | (laps >= problem.course.laps - 1)
    targets = tuple(target for target, keep in zip(problem.targets, kept, strict=True) if keep)
    few = dataclasses.replace(problem, targets=targets, course=problem.course.model_copy(update={"laps": FEW}))
    counts = np.array(problem.counts or (problem.intervals,) * problem.phases)
    return few if np.array_equal(counts[kept], few.counts or (few.intervals,) * few.phases) else None


def repeat_lap(problem: Problem, few: Problem, plan: Trajectory) -> Trajectory:
    """A plan of few laps with its second lap repeated, each time turned about body z as far as that lap ends from how it begins.

    Args:
        problem: with many laps.
        few: what `few_laps` made of it.
        plan: for that.
    """
    laps, ends = np.minimum(_laps(few), FEW - 1), np.append(0, plan.ends)
    first, last = int((laps < 1).sum()), int((laps < FEW - 1).sum())  # phases
    begin, end = ends[first], ends[last]
    times = (problem.phases - few.phases) // (last - first)
    turn = _turn(plan.states[begin], plan.states[end])
    again = [_turned(plan.states[begin + 1 : end + 1], k * turn) for k in range(1, times + 1)]
    return Trajectory(
        durations=np.concatenate([plan.durations[:last], np.tile(plan.durations[first:last], times), plan.durations[last:]]),
        states=np.vstack([plan.states[: end + 1], *again, _turned(plan.states[end + 1 :], times * turn)]),
        controls=np.vstack([plan.controls[:end], np.tile(plan.controls[begin:end], (times, 1)), plan.controls[end:]]),
        counts=problem.counts,
    )


def _laps(problem: Problem) -> NDArray[np.intp]:
    """The lap of each target, from 0; what comes behind the last lap counts as one more."""
    gates = 1 if problem.course is None else len(problem.course.gates)
    return np.array([target.index for target in problem.targets]) // gates


def _turn(before: Floats, after: Floats) -> float:
    """Angle [rad] about body z from one state to another."""
    between = product(before[ATTITUDE] * CONJUGATE, after[ATTITUDE])
    return float(2 * np.arctan2(between[3], between[0]))


def _turned(states: Floats, angle: float) -> Floats:
    """The same flight of a body that is turned about its z by an angle [rad]."""
    turned, cos, sin = states.copy(), np.cos(angle), np.sin(angle)
    turned[:, ATTITUDE] = product(states[:, ATTITUDE], np.array([np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)]))
    for rates in (RATES, COMMANDED)[: 1 + (states.shape[1] > BODY.stop)]:
        x, y = states[:, rates.start], states[:, rates.start + 1]
        turned[:, rates.start], turned[:, rates.start + 1] = cos * x + sin * y, cos * y - sin * x
    return turned
