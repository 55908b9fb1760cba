"""Demonstration: sets of parameters flown once more through the same noise, to be shown; nothing is chosen among these flights."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.course import Course
from hotlap.parameters import Parameters
from hotlap.report.scene import Scene, repeat, stage, trace
from hotlap.worlds.world import World

BEST, FIRST, DEFAULT = "best", "first guess", "default"


@dataclass(frozen=True)
class Shown:
    """What is flown.

    Attributes:
        label: what it is ("best").
        parameters: shape (S, K).
    """

    label: str
    parameters: Parameters


def choose(course: Course, first: Parameters, best: Parameters) -> tuple[Shown, ...]:
    """The best parameters, the first guess and the controller's default, as far as they differ; the best come first.

    Args:
        course: what they belong to.
        first: shape (S, K).
        best: shape (S, K).
    """
    shown = [Shown(BEST, best)]
    for label, values in ((FIRST, first), (DEFAULT, course.space.first_guess(len(course.segments)))):
        if not any(np.array_equal(values, known.parameters) for known in shown):
            shown.append(Shown(label, values))
    return tuple(shown)


def demonstrate(course: Course, world: World, shown: Sequence[Shown], seeds: NDArray[np.int64]) -> Scene:
    """Fly each of some parameters through the same noise, and record one flight of each.

    Args:
        course: what is flown.
        world: where.
        shown: at least one, the one that matters most first.
        seeds: shape (N,).
    """
    count = len(seeds)
    parameters = np.concatenate([np.repeat(one.parameters[None], count, axis=0) for one in shown])
    flown = world.fly(course, parameters, np.tile(seeds, len(shown)), log=[i * count for i in range(len(shown))])
    traces = tuple(trace(course, flown, i * count, one.label) for i, one in enumerate(shown))
    repeats = tuple(repeat(flown, slice(i * count, (i + 1) * count), one.label) for i, one in enumerate(shown))
    return stage(course, traces, repeats)
