"""The paper's way: a regressor for each class, that learns from the vehicle that is most like the one to fly."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fake_world import make_scenario
from first_guess.small import AWAY, DEFAULT, GOOD, OTHER, make_piece, make_race, make_set
from hotlap.first_guess.features import OF_A_RACE, race_features
from hotlap.first_guess.regression import REGRESSORS, Regression
from hotlap.reference.segments import SegmentClass, Segments

SCENARIO = make_scenario()  # a flat piece, then an ascent
BOX = tuple(race_features(SCENARIO, (*OF_A_RACE, "mean_speed")).tolist())
FLAT, ASCENT = SegmentClass.FLAT, SegmentClass.ASCENT


def scaled(factor: float) -> tuple[float, ...]:
    return tuple(factor * value for value in GOOD)


def taught_by_speed(kind: SegmentClass = FLAT, count: int = 41) -> list:
    """Races whose best parameters grow with the mean speed of their only piece."""
    speeds = np.linspace(0.5, 1.5, count)
    return [make_race(f"{k}", "080", features=BOX, tuned=scaled(v), pieces=(make_piece(kind, mean_speed=v),)) for k, v in enumerate(speeds)]


def at_speed(speed: float):
    velocity = np.tile([speed, 0.0, 0.0], (len(SCENARIO.reference.velocity), 1))
    return replace(SCENARIO, reference=replace(SCENARIO.reference, velocity=velocity))


@pytest.mark.parametrize("name", [name for name in REGRESSORS if name != "median"])
def test_what_depends_on_a_feature_is_predicted_from_it(name):
    training = make_set(*taught_by_speed())
    slow, fast = (Regression(name, ("mean_speed",))(at_speed(speed), training)[0] for speed in (0.7, 1.3))
    np.testing.assert_allclose(slow, scaled(0.7), rtol=0.1)
    np.testing.assert_allclose(fast, scaled(1.3), rtol=0.1)


def test_a_class_learns_from_its_own_pieces():
    flat, ascent = taught_by_speed(), [race.model_copy(update={"tuned": OTHER}) for race in taught_by_speed(ASCENT)]
    guess = Regression("median")(SCENARIO, make_set(*flat, *ascent))
    np.testing.assert_allclose(guess, [scaled(1.0), OTHER], rtol=1e-9)


def test_a_class_that_nobody_flew_learns_from_all():
    guess = Regression("median")(SCENARIO, make_set(*taught_by_speed()))
    np.testing.assert_allclose(guess[1], scaled(1.0), rtol=1e-9)


def test_few_pieces_give_their_median():
    guess = Regression()(SCENARIO, make_set(*taught_by_speed(count=5)))
    np.testing.assert_allclose(guess[0], scaled(1.0), rtol=1e-9)


def test_other_vehicles_and_what_does_not_hold_are_not_learnt_from():
    own = taught_by_speed(count=3)
    foreign = make_race("x", "080", features=AWAY, tuned=OTHER, vehicle="other")
    loose, failed = (make_race("y", "080", features=BOX, **changes) for changes in ({"tuned": OTHER, "validated": 0.5}, {"tuned": None}))
    guess = Regression("median")(SCENARIO, make_set(*own, foreign, loose, failed))
    np.testing.assert_allclose(guess[0], scaled(1.0), rtol=1e-9)
    with pytest.raises(ValueError, match="no training race holds"):
        Regression()(SCENARIO, make_set(loose, failed))


def test_a_segment_of_several_pieces_gets_the_mean_of_their_logarithms_by_time():
    segments = Segments(np.array([0.0, 2.5, 3.75]), (FLAT, ASCENT, FLAT), 5.0, (0, 1, 0))
    flat = [race.model_copy(update={"tuned": GOOD}) for race in taught_by_speed()]
    ascent = [race.model_copy(update={"tuned": DEFAULT}) for race in taught_by_speed(ASCENT)]
    guess = Regression("median")(replace(SCENARIO, segments=segments), make_set(*flat, *ascent))
    np.testing.assert_allclose(guess, [GOOD, DEFAULT], rtol=1e-9)
