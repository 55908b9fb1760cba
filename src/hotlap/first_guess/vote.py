"""Vote: the parameters that flew best wherever it was like here.

The paper predicts parameters from features of a segment. What was tuned on one race flies many others, though, so the question is
rather which of many tuned parameters to begin with. All of them were flown in all training races; a race speaks for them by how they
did in it, the louder the more it is like the one to come (Nadaraya, Watson, 1964), and for what is near them too, so that what wins is
no lucky exception:

    score(c) = sum_r w(f, f_r) sum_d w(c, d) (passed(d, r) + completed(d, r)) / sum_d w(c, d),    w(a, b) = exp(-|a - b|^2 / 2)

f are features of the vehicle and of the whole reference, in units of how much they differ among the training races, mean squares over
those of each kind; c and d logarithms of parameters, in units of how much these differ. `REACH` divides them all.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hotlap.first_guess.features import OF_A_RACE
from hotlap.first_guess.training_set import TrainingSet

Floats = NDArray[np.float64]

REACH = {"vehicle": 0.5, "flight": 0.3, "parameters": 0.5}  # chosen on the training races, each track left out in turn
LEAST = 1e-6  # weight of a race, however far it is


def vote(training: TrainingSet, features: Floats) -> Floats:
    """The winner, shape (K,).

    Args:
        training: what is known.
        features: of the race to come, shape (F,), in the order of `training.race_features`.
    """
    candidates = np.log(np.array(training.candidates))
    shown = likeness(training, features) @ (training.passed + training.completed)
    scaled = candidates / _spread(candidates) / REACH["parameters"]
    near = np.exp(-((scaled[:, None] - scaled) ** 2).sum(axis=2) / 2)
    return np.array(training.candidates[int(np.argmax(near @ shown / near.sum(axis=1)))])


def likeness(training: TrainingSet, features: Floats) -> Floats:
    """Weight of each training race, shape (races,)."""
    known = np.array([race.features for race in training.races])
    away = ((known - features) / _spread(known)) ** 2
    of_vehicle = np.array([name in OF_A_RACE for name in training.race_features])
    square = np.zeros(len(known))
    for kind, columns in (("vehicle", of_vehicle), ("flight", ~of_vehicle)):
        if columns.any():
            square += away[:, columns].mean(axis=1) / REACH[kind] ** 2
    return np.maximum(np.exp(-square / 2), LEAST)


def _spread(values: Floats) -> Floats:
    """Standard deviation of each column; infinite where it is the same in all rows, and tells nothing."""
    deviation = values.std(axis=0)
    return np.where(deviation > 1e-9 * np.abs(values).max(axis=0), deviation, np.inf)
