"""Estimates are gradients, gains fall as they should, and descent descends."""

import json
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from hotlap import tuners
from hotlap.tuners.gradient import PRESETS, GradientSettings

from .laws import make_scores, make_space
from .test_contract import SEGMENTS, SPACE, play, start

K = SPACE.size
SLOPE = np.array([3.0, -1.0, 0.5, 2.0, 1.0])  # of log(1 + cost) by the logarithm of each parameter, in units of `log_step`


def slanted(parameters):
    """Scores whose log(1 + cost) is linear in logarithms: differences are exact."""
    offsets = np.log(parameters / SPACE.default) / SPACE.log_step
    return make_scores(np.expm1(50.0 + (offsets.mean(axis=1) * SLOPE).sum(axis=1)))


def opened(name, seed=3):
    """A descent that has flown the first guess."""
    tuner = start(name, seed)
    tuner.tell(tuner.ask(1), slanted(SPACE.first_guess(SEGMENTS)[None]))
    return tuner


def gradient_of(tuner, scores=slanted):
    tuner._values = np.log1p(scores(tuner._offsets.decode(tuner._points())).dense).tolist()
    return tuner._gradient()


def climb(tuner, plus, minus):
    """Tell a pair."""
    tuner.tell(tuner.ask(2), make_scores(np.array([plus, minus])))


def test_finite_differences_of_a_slope_are_the_slope():
    np.testing.assert_allclose(gradient_of(opened("gradient:finite_differences")), SLOPE)
    each = gradient_of(opened("gradient:finite_differences_segments")).reshape(SEGMENTS, K)
    np.testing.assert_allclose(each, np.tile(SLOPE / SEGMENTS, (SEGMENTS, 1)))


def test_the_mean_of_simultaneous_estimates_over_all_signs_is_the_slope():
    tuner = opened("gradient:spsa")
    estimates = []
    for signs in product([-1.0, 1.0], repeat=K):
        tuner._directions = np.array([signs])
        estimates.append(gradient_of(tuner))
    np.testing.assert_allclose(np.mean(estimates, axis=0), SLOPE)


def test_averages_are_the_mean_of_their_estimates():
    tuner = opened("gradient:spsa_averaged")
    directions, whole = tuner._directions, gradient_of(tuner)
    parts = []
    for direction in directions:
        tuner._directions = direction[None]
        parts.append(gradient_of(tuner))
    np.testing.assert_allclose(whole, np.mean(parts, axis=0))


@pytest.mark.parametrize(
    ("preset", "flights"),
    [
        ("spsa", 2),
        ("spsa_segments", 2),
        ("spsa_averaged", 8),
        ("finite_differences", 2 * K),
        ("finite_differences_segments", 2 * SEGMENTS * K),
    ],
)
def test_a_step_costs_so_many_flights_in_one_ask(preset, flights):
    tuner = opened(f"gradient:{preset}")
    asked = tuner.ask(64)
    assert len(asked) == flights
    tuner.tell(asked, slanted(asked))
    assert tuner._steps == 1


def test_the_points_of_a_pair_lie_on_both_sides_of_the_place():
    pair = np.log(opened("gradient:spsa").ask(2) / SPACE.default)
    np.testing.assert_allclose(pair.mean(axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.abs(pair), np.broadcast_to(0.3 * SPACE.log_step, pair.shape))


@pytest.mark.parametrize("preset", PRESETS)
def test_at_a_bound_the_place_steps_back_so_that_pairs_stay_whole(preset):
    tuner = tuners.build(f"gradient:{preset}")
    tuner.start(np.tile(SPACE.high, (SEGMENTS, 1)), SPACE, np.random.default_rng(0))
    tuner.tell(tuner.ask(1), make_scores(np.ones(1)))
    points = tuner._points()
    np.testing.assert_allclose((points[::2] + points[1::2]) / 2, np.broadcast_to(tuner._place, points[::2].shape))
    np.testing.assert_allclose(np.abs(points[::2] - points[1::2]).max(axis=1), 0.6)
    assert SPACE.contains(tuner._offsets.decode(points))


def test_a_box_narrower_than_a_pair_is_searched_within():
    space = make_space(low=1.0, high=1.2)
    tuner = tuners.build("gradient:spsa")
    tuner.start(space.first_guess(1), space, np.random.default_rng(0))
    for _ in range(30):
        asked = tuner.ask(2)
        assert space.contains(asked)
        tuner.tell(asked, make_scores(asked[:, 0, 0]))


def test_gains_fall_as_spall_says():
    settings = GradientSettings(step=0.4, shake=0.2, stability=10)
    assert settings.gain(0) == pytest.approx(0.4)
    assert settings.gain(99) / settings.gain(9) == pytest.approx((20 / 110) ** 0.602)
    assert settings.width(0) == 0.2
    assert settings.width(9) == pytest.approx(0.2 / 10**0.101)


@pytest.mark.parametrize("name", ["gradient:spsa", "gradient:spsa_adam"])
def test_the_first_step_moves_every_parameter_by_its_size_away_from_the_worse_point(name):
    tuner = opened(name)
    worse = tuner._points()[1]
    climb(tuner, 5.0, 70.0)
    np.testing.assert_allclose(np.abs(tuner._place), tuner.settings.step, rtol=1e-6)
    assert (np.sign(tuner._place) == -np.sign(worse)).all()


def test_adam_steps_on_where_it_was_going():
    adam, gains = opened("gradient:spsa_adam"), opened("gradient:spsa")
    for tuner in (adam, gains):
        climb(tuner, 5.0, 70.0)
        before = tuner._place
        climb(tuner, 6.0, 6.0)
        assert np.array_equal(before, tuner._place) == (tuner is gains)


@pytest.mark.parametrize("lost", [np.nan, np.inf])
def test_a_cost_that_is_no_number_is_worse_than_any_known(lost):
    for known in (2.0, 1e30):
        hidden, shown = opened("gradient:spsa"), opened("gradient:spsa")
        climb(hidden, lost, known)
        climb(shown, 1e31, known)
        np.testing.assert_allclose(hidden._place, shown._place)


@pytest.mark.parametrize("preset", PRESETS)
def test_a_flat_cost_moves_nothing(preset):
    tuner = start(f"gradient:{preset}")
    play(tuner, 100, n=8, scores=lambda parameters: make_scores(np.full(len(parameters), 3.0)))
    assert (tuner._place == 0).all()


@pytest.mark.parametrize("preset", PRESETS)
def test_it_descends(preset):
    def bowl(parameters):
        return make_scores((np.log(parameters / SPACE.default * 1.5) ** 2).mean(axis=1).sum(axis=1) * 10)

    tuner = start(f"gradient:{preset}")
    play(tuner, 400, n=8, scores=bowl)
    before, after = bowl(SPACE.first_guess(SEGMENTS)[None]).cost[0], bowl(tuner._offsets.decode(tuner._place[None])).cost[0]
    assert after < 0.3 * before


def test_differences_take_every_parameter_once_in_an_order_by_chance():
    tuner = opened("gradient:finite_differences")
    orders = []
    for _ in range(5):
        np.testing.assert_array_equal(tuner._directions.sum(axis=0), 1.0)
        np.testing.assert_array_equal(tuner._directions.sum(axis=1), 1.0)
        orders.append(tuner._directions)
        play(tuner, 2 * K, n=2 * K, scores=slanted)
    assert any(not np.array_equal(orders[0], order) for order in orders)


def test_only_the_metric_preset_listens_to_the_metric():
    def scores(parameters):
        return replace(slanted(parameters), cost=np.ones(len(parameters)))

    for preset, moves in (("spsa", True), ("spsa_metric", False)):
        tuner = start(f"gradient:{preset}")
        play(tuner, 9, scores=scores)
        assert (tuner._place != 0).any() == moves


@pytest.mark.parametrize("preset", PRESETS)
def test_a_step_may_be_asked_for_in_pieces(preset):
    name = f"gradient:{preset}"
    np.testing.assert_array_equal(play(start(name), 60, n=1, scores=slanted), play(start(name), 60, n=64, scores=slanted))


@pytest.mark.parametrize("preset", PRESETS)
def test_what_is_asked_for_and_not_told_is_asked_for_again_after_a_restore(preset):
    tuner, other = start(f"gradient:{preset}"), start(f"gradient:{preset}", seed=99)
    play(tuner, 4, n=1, scores=slanted)
    pending = tuner.ask(4)
    other.restore(json.loads(json.dumps(tuner.state(), allow_nan=False)))
    np.testing.assert_array_equal(other.ask(4), pending)
    np.testing.assert_array_equal(play(other, 30, scores=slanted), play(tuner, 30, scores=slanted))
