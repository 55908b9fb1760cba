"""Vote: of many tuned parameter sets, the one with the highest success in similar training races.

The paper predicts parameters from features of a segment. But parameters tuned on one race often fly other races as well, so here the
question is which of many tuned parameter sets to begin with. Each of them (a candidate) was flown in all training races. Its score is a
kernel regression (Nadaraya, Watson, 1964): the mean of its success over the races, weighted by their similarity to the new race, and
averaged over similar candidates, so that a candidate with a few lucky flights does not win:

    score(c) = sum_r w(f, f_r) sum_d w(c, d) (passed(d, r) + completed(d, r)) / sum_d w(c, d),    w(a, b) = exp(-|a - b|^2 / 2)

f are the features of the vehicle and of the whole reference, each divided by its standard deviation over the training races, with the mean
square over those of each kind; c and d are logarithms of parameters, divided by their standard deviations. `REACH` is the bandwidth.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hotlap.first_guess.features import OF_A_RACE
from hotlap.first_guess.training_set import TrainingSet

Floats = NDArray[np.float64]

REACH = {"vehicle": 0.5, "flight": 0.3, "parameters": 0.5}  # by cross-validation on the training races, one track left out at a time
LEAST = 1e-6  # smallest weight of a race


def vote(training: TrainingSet, features: Floats) -> Floats:
    """The candidate of highest score, shape (K,).

    Args:
        training: races and candidates.
        features: features of the new race, shape (F,), in the order of `training.race_features`.
    """
    candidates = np.log(np.array(training.candidates))
    shown = similarity(training, features) @ (training.passed + training.completed)
    scaled = candidates / _spread(candidates) / REACH["parameters"]
    near = np.exp(-((scaled[:, None] - scaled) ** 2).sum(axis=2) / 2)
    return np.array(training.candidates[int(np.argmax(near @ shown / near.sum(axis=1)))])


def similarity(training: TrainingSet, features: Floats) -> Floats:
    """Weight of each training race by its similarity, shape (races,)."""
    known = np.array([race.features for race in training.races])
    away = ((known - features) / _spread(known)) ** 2
    of_vehicle = np.array([name in OF_A_RACE for name in training.race_features])
    square = np.zeros(len(known))
    for kind, columns in (("vehicle", of_vehicle), ("flight", ~of_vehicle)):
        if columns.any():
            square += away[:, columns].mean(axis=1) / REACH[kind] ** 2
    return np.maximum(np.exp(-square / 2), LEAST)


def _spread(values: Floats) -> Floats:
    """Standard deviation of each column, shape (columns,); infinite where all rows are equal, so that the column has no influence."""
    deviation = values.std(axis=0)
    return np.where(deviation > 1e-9 * np.abs(values).max(axis=0), deviation, np.inf)
