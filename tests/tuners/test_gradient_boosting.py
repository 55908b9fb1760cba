"""Trees are scikit-learn's, what they predict as lowest is flown, and some flights explore."""

from __future__ import annotations

import copy
import json

import numpy as np
import pytest
from sklearn.ensemble import GradientBoostingRegressor

from hotlap import tuners
from hotlap.tuners.gradient_boosting import INITIAL, POOL, REFIT, GradientBoosting, GradientBoostingSettings

from . import laws
from .test_contract import SEGMENTS, SPACE, judge, play, start


def begun(settings: GradientBoostingSettings, flights: int = INITIAL) -> GradientBoosting:
    """A search after some flights."""
    tuner = GradientBoosting("under test", settings)
    tuner.start(SPACE.first_guess(SEGMENTS), SPACE, np.random.default_rng(2))
    play(tuner, flights)
    return tuner


def test_trees_have_the_default_settings_and_know_every_flight_of_the_last_fit():
    tuner = begun(GradientBoostingSettings(), 3 * REFIT + 2)
    default = GradientBoostingRegressor(random_state=tuner._seed)
    assert tuner._fit().get_params() == default.get_params()
    flown = tuner._flown[: 3 * REFIT].reshape(3 * REFIT, -1)
    default.fit(flown, tuner._costs[: 3 * REFIT])
    np.testing.assert_array_equal(tuner._fit().predict(flown), default.predict(flown))


def test_the_lowest_prediction_is_flown():
    tuner = begun(GradientBoostingSettings(exploration=0.0))
    twin = copy.deepcopy(tuner)
    asked, candidates = tuner.ask(1), twin._candidates()
    predictions = tuner._fit().predict(candidates.reshape(POOL, -1))
    np.testing.assert_array_equal(asked[0], candidates[int(np.argmin(predictions))])
    assert np.ptp(predictions) > 0


def test_the_stated_share_of_flights_explores():
    tuner = begun(GradientBoostingSettings(exploration=0.3))
    trees = tuner._fit()
    low = np.quantile(trees.predict(tuner._candidates().reshape(POOL, -1)), 0.01)
    chosen = np.array([tuner._choose() for _ in range(300)])
    assert (trees.predict(chosen.reshape(300, -1)) > low).mean() == pytest.approx(0.3, abs=0.08)


@pytest.mark.parametrize("log", [False, True])
def test_candidates_lie_around_the_best_point_or_anywhere_within_the_bounds(log):
    tuner = begun(GradientBoostingSettings(log=log))

    def scale(values):
        return SPACE.to_unit(values) if log else (values - SPACE.low) / (SPACE.high - SPACE.low)

    best = scale(tuner._flown[int(np.argmin(tuner._costs))])
    away = np.abs(scale(tuner._candidates()) - best).mean(axis=(1, 2))
    assert (away < 0.13).mean() == pytest.approx(0.5, abs=0.1)
    far = scale(tuner._candidates()[away > 0.13])
    assert far.min() < 0.02
    assert far.max() > 0.98


def test_one_fit_serves_until_the_next():
    tuner = begun(GradientBoostingSettings(), INITIAL + 3)
    asked = tuner.ask(64)
    assert len(asked) == REFIT - 3
    before = tuner._trees
    tuner.tell(asked, judge(asked))
    tuner.ask(1)
    assert tuner._trees is not before


def test_restored_with_points_that_are_not_told_yet_it_goes_on_as_it_would():
    kept = begun(GradientBoostingSettings(), INITIAL + 4)
    pending = kept.ask(3)
    resumed = begun(GradientBoostingSettings(), 0)
    resumed.restore(json.loads(json.dumps(kept.state(), allow_nan=False)))
    np.testing.assert_array_equal(resumed.ask(3), pending)
    kept.tell(pending, judge(pending))
    resumed.tell(pending, judge(pending))
    np.testing.assert_array_equal(play(resumed, 20), play(kept, 20))


def test_a_flight_without_a_cost_does_not_drown_the_others():
    tuner = GradientBoosting("under test", GradientBoostingSettings())
    tuner.start(SPACE.first_guess(SEGMENTS), SPACE, np.random.default_rng(2))
    play(tuner, INITIAL, n=1, scores=lambda p: laws.make_scores(np.where(p[:, 0, 0] > 300, np.inf, p[:, 0, 0])))
    predictions = tuner._fit().predict(tuner._flown.reshape(INITIAL, -1))
    proper = tuner._costs < 1e9
    assert 0 < proper.sum() < INITIAL
    np.testing.assert_allclose(predictions[proper], tuner._costs[proper], rtol=0.05)
    assert predictions[~proper].min() > tuner._costs[proper].max()


def test_it_descends_below_what_chance_finds():
    def slope(parameters):
        return laws.make_scores(np.log(parameters[..., 0]).sum(axis=1) + np.log(parameters[..., 3]).sum(axis=1))

    def lowest(name):
        return slope(play(start(name), 150, scores=slope)).cost.min()

    assert tuners.build("gradient_boosting").settings.exploration == 0.1
    assert lowest("gradient_boosting:log") < 0.7 * lowest("random_search:uniform")
