"""Regression: parameters of each segment predicted from features of its pieces, one regressor for each class (Sec. IV-D of the paper).

The regressors predict logarithms of parameters. They learn only from the races of the vehicle that is most similar to the race's, as in
the paper, whose training flights are those of its drone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters
from hotlap.first_guess.features import OF_A_RACE, PAPER, piece_features, race_features
from hotlap.first_guess.training_set import TrainingRace, TrainingSet
from hotlap.reference.scenario import Scenario

Floats = NDArray[np.float64]

VALIDATED = 0.9  # least success rate in fresh flights of the parameters of a training race
NEIGHBOURS = 5


def _boosting() -> Any:
    from sklearn.ensemble import GradientBoostingRegressor  # noqa: PLC0415  it takes a second to load
    from sklearn.multioutput import MultiOutputRegressor  # noqa: PLC0415

    return MultiOutputRegressor(GradientBoostingRegressor(random_state=0))


def _forest() -> Any:
    from sklearn.ensemble import RandomForestRegressor  # noqa: PLC0415

    return RandomForestRegressor(random_state=0)


def _ridge() -> Any:
    from sklearn.linear_model import RidgeCV  # noqa: PLC0415
    from sklearn.pipeline import make_pipeline  # noqa: PLC0415
    from sklearn.preprocessing import StandardScaler  # noqa: PLC0415

    return make_pipeline(StandardScaler(), RidgeCV(np.logspace(-2, 3, 11)))


def _nearest() -> Any:
    from sklearn.neighbors import KNeighborsRegressor  # noqa: PLC0415
    from sklearn.pipeline import make_pipeline  # noqa: PLC0415
    from sklearn.preprocessing import StandardScaler  # noqa: PLC0415

    return make_pipeline(StandardScaler(), KNeighborsRegressor(NEIGHBOURS))


class _Median:
    """A regressor that predicts the median of all values, whatever the features."""

    def fit(self, _: Floats, values: Floats) -> _Median:
        """Store the median of values of shape (n, K)."""
        self._median = np.median(values, axis=0)
        return self

    def predict(self, features: Floats) -> Floats:
        """The median, shape (m, K), for features of shape (m, F)."""
        return np.tile(self._median, (len(features), 1))


REGRESSORS: Mapping[str, Callable[[], Any]] = {
    "boosting": _boosting,
    "forest": _forest,
    "ridge": _ridge,
    "nearest": _nearest,
    "median": _Median,
}


@dataclass(frozen=True)
class Regression:
    """A regressor and its features.

    Attributes:
        regressor: a name in `REGRESSORS`; the paper's is gradient boosting with default settings.
        features: names of the features of a piece; the paper has five.
    """

    regressor: str = "boosting"
    features: tuple[str, ...] = PAPER

    def __call__(self, scenario: Scenario, training: TrainingSet) -> Parameters:
        """Predicted parameters, shape (S, K); a class that no training race has is predicted from the pieces of all classes.

        Raises:
            ValueError: no training race has validated parameters.
        """
        races = validated_races(training, race_features(scenario, training.race_features))
        rows = piece_features(scenario, self.features)
        kinds = [piece.kind for piece in scenario.segments.pieces]
        predicted = np.empty((len(kinds), len(training.names)))
        for kind in dict.fromkeys(kinds):
            own = [i for i, other in enumerate(kinds) if other is kind]
            features, values = self._table(training, races, kind)
            predicted[own] = self._fitted(features, values).predict(rows[own])
        return np.exp(_of_segments(scenario, predicted))

    def _table(self, training: TrainingSet, races: Sequence[TrainingRace], kind: str) -> tuple[Floats, Floats]:
        """Features, shape (n, F), and logarithms of parameters, shape (n, K), of the pieces of a class, or of all where there are none."""
        columns = [training.piece_features.index(name) for name in self.features]
        found = [(piece, race) for race in races for piece in race.pieces if piece.kind == kind]
        found = found or [(piece, race) for race in races for piece in race.pieces]
        features = np.array([[piece.features[column] for column in columns] for piece, _ in found])
        return features, np.log(np.array([race.tuned for _, race in found]))

    def _fitted(self, features: Floats, values: Floats) -> Any:
        """The fitted regressor; the median where there are at most `NEIGHBOURS` rows."""
        few = len(features) <= NEIGHBOURS
        return (_Median() if few else REGRESSORS[self.regressor]()).fit(features, values)


def validated_races(training: TrainingSet, features: Floats) -> list[TrainingRace]:
    """Training races with validated parameters, of the vehicle whose features are nearest to the race's.

    Raises:
        ValueError: there is none.
    """
    races = [race for race in training.races if race.tuned is not None and race.validated >= VALIDATED]
    if not races:
        raise ValueError("no training race holds")
    columns = [i for i, name in enumerate(training.race_features) if name in OF_A_RACE]
    known = np.array([[race.features[i] for i in columns] for race in races])
    deviation = known.std(axis=0)
    spread = np.where(deviation > 1e-9 * np.abs(known).max(axis=0), deviation, np.inf)
    square = (((known - features[columns]) / spread) ** 2).sum(axis=1)
    nearest = races[int(np.argmin(square))].vehicle
    return [race for race in races if race.vehicle == nearest]


def _of_segments(scenario: Scenario, predicted: Floats) -> Floats:
    """Means over the pieces of each segment, weighted by their durations, shape (S, K)."""
    totals, weights = np.zeros((len(scenario.segments), predicted.shape[1])), np.zeros(len(scenario.segments))
    for piece, row in zip(scenario.segments.pieces, predicted, strict=True):
        totals[piece.segment] += (piece.end - piece.start) * row
        weights[piece.segment] += piece.end - piece.start
    return totals / weights[:, None]
