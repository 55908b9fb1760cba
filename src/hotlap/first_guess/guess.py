"""Guess: where a search begins, by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from hotlap.course import Course
from hotlap.errors import UnknownNameError
from hotlap.first_guess.features import race_features
from hotlap.first_guess.regression import Regression
from hotlap.first_guess.training_set import TrainingSet, shipped
from hotlap.first_guess.vote import vote
from hotlap.parameters import Parameters

LEARNED, PAPER, DEFAULT = "learned", "paper", "default"
NAMES = (LEARNED, PAPER, DEFAULT)

Method = Callable[[Course, TrainingSet], Parameters]


def voted(course: Course, training: TrainingSet) -> Parameters:
    """What flew best in the training races that are like this one, the same in all segments, shape (S, K)."""
    chosen = vote(training, race_features(course, training.race_features))
    return np.tile(chosen, (len(course.segments), 1))


METHODS: Mapping[str, Method] = {LEARNED: voted, PAPER: Regression()}


def first_guess(course: Course, name: str = LEARNED, training: TrainingSet | None = None) -> Parameters:
    """Where a search begins.

    Args:
        course: what is to be flown.
        name: "learned", by vote; "paper", by gradient boosting for each class of segments; "default", the controller's default.
        training: what it is learnt from; None: what comes with hotlap.

    Returns:
        Shape (S, K), within the bounds; the default where nothing was learnt about the course's controller.

    Raises:
        UnknownNameError: there is no guess of that name.
        ValueError: for "paper", where no training race holds.
    """
    if name not in NAMES:
        raise UnknownNameError("first guess", name, NAMES)
    default = course.space.first_guess(len(course.segments))
    if name == DEFAULT:
        return default
    training = training or shipped()
    return guess_by(METHODS[name], course, training) if teaches(training, course) else default


def teaches(training: TrainingSet, course: Course) -> bool:
    """Whether a training set is about the parameters of a course's controller."""
    return training.names == course.space.names


def guess_by(method: Method, course: Course, training: TrainingSet) -> Parameters:
    """What a method says, in the units of the course's controller and within its bounds."""
    values = np.array(method(course, training))
    if "horizon" in training.names:
        values[:, training.names.index("horizon")] *= training.horizon_unit / course.race.controller.horizon_unit
    return course.space.clip(values)
