"""Guess: the initial parameters of a search, by the name of the method."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from hotlap.core.errors import UnknownNameError
from hotlap.core.parameters import Parameters
from hotlap.first_guess.features import race_features
from hotlap.first_guess.names import DEFAULT, LEARNED, NAMES, PAPER
from hotlap.first_guess.regression import Regression
from hotlap.first_guess.training_set import TrainingSet, shipped
from hotlap.first_guess.vote import vote
from hotlap.race.race import PlanDynamics
from hotlap.reference.scenario import Scenario

Method = Callable[[Scenario, TrainingSet], Parameters]


def voted(scenario: Scenario, training: TrainingSet) -> Parameters:
    """The parameters that flew best in similar training races, the same in all segments, shape (S, K)."""
    chosen = vote(training, race_features(scenario, training.race_features))
    return np.tile(chosen, (len(scenario.segments), 1))


METHODS: Mapping[str, Method] = {LEARNED: voted, PAPER: Regression()}


def first_guess(scenario: Scenario, name: str = LEARNED, training: TrainingSet | None = None) -> Parameters:
    """The initial parameters of a search.

    Args:
        scenario: race, reference and segments to be flown.
        name: "learned", by vote; "paper", by gradient boosting for each class of segments; "default", the controller's default.
        training: races that were tuned before; None: the training set that comes with hotlap.

    Returns:
        Shape (S, K), within the bounds; the default where the training set is for another controller.

    Raises:
        UnknownNameError: there is no method of that name.
        ValueError: for "paper", where no training race has validated parameters.
    """
    if name not in NAMES:
        raise UnknownNameError("first guess", name, NAMES, key="first_guess")
    default = scenario.space.first_guess(len(scenario.segments))
    if name == DEFAULT:
        return default
    training = training or shipped()
    return guess_by(METHODS[name], scenario, training) if teaches(training, scenario) else default


def rival_of(scenario: Scenario, guess: Parameters) -> Parameters | None:
    """The default, shape (S, K), where a learnt guess has to prove itself against it; None where it need not, or where they are equal.

    All training races are planned with ideal dynamics. On plans with full dynamics the default is often the better one, and sometimes not.

    Args:
        scenario: what is to be flown.
        guess: shape (S, K), learnt.
    """
    default = scenario.space.first_guess(len(scenario.segments))
    alike = scenario.race.planning.dynamics is PlanDynamics.IDEAL or np.array_equal(guess, default)
    return None if alike else default


def teaches(training: TrainingSet, scenario: Scenario) -> bool:
    """Whether a training set has the parameters of a scenario's controller."""
    return training.names == scenario.space.names


def guess_by(method: Method, scenario: Scenario, training: TrainingSet) -> Parameters:
    """The result of a method, shape (S, K), in the units of the scenario's controller and within its bounds."""
    values = np.array(method(scenario, training))
    if "horizon" in training.names:
        values[:, training.names.index("horizon")] *= training.horizon_unit / scenario.race.controller.horizon_unit
    return scenario.space.clip(values)
