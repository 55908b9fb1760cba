"""Safe Bayesian optimisation keeps to its floor as far as its prior is true, and says how often a flight did not."""

from __future__ import annotations

import numpy as np
import pytest

from hotlap.core.parameters import ParameterSpace
from hotlap.race.controllers import TUNABLE, ControllerKind
from hotlap.tuners import Tuner, build
from hotlap.tuners.safe_bayesian import PRESETS, PRIOR, SafeBayesian, SafeBayesianSettings, choose, expanders
from hotlap.tuners.subspace import SPACING, Direction, axes_of
from hotlap.tuners.surrogates.gaussian_process import Prior, covariance

from .laws import make_scores
from .test_contract import SEGMENTS, SPACE, play, start

EVERY = pytest.mark.parametrize("name", [f"safe_bayesian:{preset}" for preset in PRESETS])
FIRST = -10.0  # performance of the first guess: far from 0, which none exceeds
BASELINE = SafeBayesianSettings().baseline
SPACE_LOW, SPACE_HIGH = (np.log(bound / SPACE.default) / SPACE.log_step for bound in (SPACE.low, SPACE.high))


def points_of(parameters: np.ndarray) -> np.ndarray:
    """Steps of the first segment from the default, shape (B, K)."""
    return np.log(parameters[:, 0] / SPACE.default) / SPACE.log_step


def scores_of(performances: np.ndarray):
    return make_scores(np.expm1(-np.asarray(performances)))


def fly(tuner: Tuner, performance, flights: int, rng: np.random.Generator, noise: float = PRIOR.noise) -> tuple[np.ndarray, np.ndarray]:
    """Points and performances without noise of some flights."""
    points, true = [], []
    for _ in range(flights):
        asked = tuner.ask(1)
        points.append(points_of(asked)[0])
        true.append(performance(points[-1]))
        tuner.tell(asked, scores_of([true[-1] + noise * rng.standard_normal()]))
    return np.array(points), np.array(true)


def path(rng: np.random.Generator, level: float):
    """A function drawn from the prior, point by point, with a given mean and `FIRST` at the origin."""
    points, values = [np.zeros(SPACE.size)], [FIRST]
    exact = Prior(PRIOR.length, PRIOR.signal, 1e-3)

    def performance(point: np.ndarray) -> float:
        mean, deviation = exact.condition(np.array(points), np.array(values), level).predict(point[None])
        points.append(point)
        values.append(float(rng.normal(mean[0], deviation[0])))
        return values[-1]

    return performance


def slope(point: np.ndarray) -> float:
    return FIRST + 0.5 * float(point.sum())


def bounds_without_noise(points, values, noises, candidates, level, prior, beta) -> np.ndarray:
    """Lower bounds by the textbook's formula, each value with a noise of its own."""
    inverse = np.linalg.inv(prior.signal**2 * covariance(points / prior.length, points / prior.length) + np.diag(noises**2))
    across = prior.signal**2 * covariance(candidates / prior.length, points / prior.length)
    variance = prior.signal**2 - np.einsum("ij,jk,ik->i", across, inverse, across)
    return level + across @ inverse @ (values - level) - beta * np.sqrt(np.maximum(variance, 0))


FLOWN = np.random.default_rng(1).normal(size=(12, 3))
PERFORMANCES = -5 + np.random.default_rng(7).normal(size=12)


@pytest.fixture
def posterior():
    return PRIOR.condition(FLOWN, PERFORMANCES, -6.0)


def test_one_value_moves_a_stated_process_by_its_share_of_the_variance():
    prior, at = Prior(2.0, 3.0, 1.5), np.zeros((1, 2))
    mean, deviation = prior.condition(at, np.array([4.0]), 1.0).predict(at)
    assert mean == pytest.approx(1 + 9 / (9 + 2.25) * 3)
    assert deviation**2 == pytest.approx(9 * 2.25 / (9 + 2.25))


def test_covariance_of_a_point_with_itself_is_its_variance(posterior):
    at = np.random.default_rng(2).normal(size=(20, 3))
    np.testing.assert_allclose(np.diag(posterior.covariance(at, at)), posterior.predict(at)[1] ** 2)


@pytest.mark.parametrize("floor", [-6.4, -6.0, -5.5])
def test_expanders_are_those_whose_best_case_makes_another_point_safe(posterior, floor):
    at, beta = np.random.default_rng(3).normal(size=(60, 3)), 2.0
    mean, deviation = posterior.predict(at)
    unsafe = at[mean - beta * deviation < floor]
    expected = []
    for point, upper in zip(at, mean + beta * deviation, strict=True):
        noises = np.append(np.full(len(FLOWN), PRIOR.noise), 1e-6)
        known = np.vstack([FLOWN, point]), np.append(PERFORMANCES, upper)
        expected.append((bounds_without_noise(*known, noises, unsafe, posterior.mean, PRIOR, beta) >= floor).any())
    assert expanders(posterior, at, unsafe, floor, beta).tolist() == expected
    assert sum(expected) > 0


@pytest.mark.parametrize("optimistic", [True, False])
@pytest.mark.parametrize("floor", [-6.5, -6.0, -5.0, 0.0])
def test_what_is_chosen_is_safe_or_the_first_point(posterior, optimistic, floor):
    at = np.random.default_rng(4).normal(size=(200, 3))
    chosen = choose(posterior, at, floor, SafeBayesianSettings(optimistic=optimistic))
    mean, deviation = posterior.predict(at)
    assert chosen == 0 or mean[chosen] - 2 * deviation[chosen] >= floor
    assert chosen == 0 or floor < 0.0


def test_safeopt_asks_for_what_it_knows_less_of_than_the_optimist_does(posterior):
    at = np.random.default_rng(4).normal(size=(200, 3))
    careful, eager = (choose(posterior, at, -6.5, SafeBayesianSettings(optimistic=optimistic)) for optimistic in (False, True))
    mean, deviation = posterior.predict(at)
    assert deviation[careful] >= deviation[eager]
    assert mean[eager] + 2 * deviation[eager] >= mean[careful] + 2 * deviation[careful]


@EVERY
def test_where_the_prior_is_true_the_floor_is_kept_and_the_flights_become_better(name):
    below, late, flights = 0, [], 60
    for seed in range(5):
        rng, tuner = np.random.default_rng([seed, 1]), start(name, seed)
        floor = FIRST - np.log(tuner.settings.tolerance)
        true = fly(tuner, path(rng, floor), flights, rng)[1]
        below += int((true < floor).sum())
        late.append(true[-10:].mean())
    assert below / (5 * flights) < 0.03  # one side of two standard deviations is 2.3 %
    assert np.mean(late) > FIRST + 0.5


def test_a_tuner_that_knows_no_floor_falls_below_it_often():
    below = 0
    for seed in range(5):
        rng = np.random.default_rng([seed, 1])
        floor = FIRST - np.log(SafeBayesianSettings().tolerance)
        below += int((fly(start("cma_es:tied", seed), path(rng, floor), 60, rng)[1] < floor).sum())
    assert below / 300 > 0.06


@EVERY
def test_the_first_guess_is_flown_until_its_floor_is_known(name):
    tuner = start(name)
    points = fly(tuner, slope, BASELINE + 1, np.random.default_rng(0), noise=0.1)[0]
    assert not points[:BASELINE].any()
    assert points[BASELINE].any()


def leave(tuner: Tuner, rng: np.random.Generator, noise: float) -> tuple[int, np.ndarray]:
    """The first flight of sixty that is not of the first guess, and its point."""
    for flight in range(60):
        [point] = fly(tuner, slope, 1, rng, noise)[0]
        if point.any():
            return flight, point
    raise AssertionError("it never leaves the first guess")


def first_step(noise: float = 0.1, **changes) -> float:
    """Distance of the first point that is not the first guess."""
    tuner, rng = SafeBayesian("under test", SafeBayesianSettings(optimistic=True, **changes)), np.random.default_rng(5)
    tuner.start(SPACE.first_guess(SEGMENTS), SPACE, np.random.default_rng(6))
    return float(np.linalg.norm(leave(tuner, rng, noise)[1]))


def test_the_first_step_is_short_and_longer_where_more_is_tolerated():
    assert first_step() < 0.25 * PRIOR.length
    assert first_step(tolerance=2.0) < first_step(tolerance=9.0)
    assert first_step(beta=3.0) < first_step(beta=1.0)


def test_noise_of_the_first_guess_is_believed_where_it_exceeds_the_prior():
    first = []
    for noise in (0.1, 3.0):
        tuner, rng = start("safe_bayesian:plane"), np.random.default_rng(5)
        first.append(leave(tuner, rng, noise)[0])
    assert first[0] < first[1]


@EVERY
def test_all_segments_move_alike_and_by_their_own_factor(name):
    tuner = build(name)
    guess = SPACE.first_guess(2) * [[1.0], [1.1]]
    tuner.start(guess, SPACE, np.random.default_rng(1))
    factors = play(tuner, 20) / guess
    inside = ((factors * guess > SPACE.low) & (factors * guess < SPACE.high)).all(axis=1)
    np.testing.assert_allclose(factors[:, 0][inside], factors[:, 1][inside])


def test_the_plane_turns_all_weights_by_one_factor_and_the_horizon_by_another():
    asked = play(start("safe_bayesian:plane"), 40)
    factors = asked[:, 0] / SPACE.default
    free = (asked[:, 0, :4] > SPACE.low[:4]).all(axis=1) & (asked[:, 0, :4] < SPACE.high[:4]).all(axis=1)
    np.testing.assert_allclose(factors[free, :4], factors[free, :1].repeat(4, axis=1))
    assert len(np.unique(factors[free, 0])) > 3
    assert len(np.unique(factors[:, 4])) > 3


def test_a_line_is_followed_before_another_is_laid():
    tuner, line = start("safe_bayesian:lines"), SafeBayesianSettings().line
    points = fly(tuner, lambda _: FIRST, BASELINE + 4 * line, np.random.default_rng(0), noise=0.1)[0][BASELINE:]
    inside = ((points > SPACE_LOW + 1e-9) & (points < SPACE_HIGH - 1e-9) & points.any(axis=1, keepdims=True)).all(axis=1)
    assert inside.sum() > 2 * line
    for k in range(4):
        on_line = points[k * line : (k + 1) * line][inside[k * line : (k + 1) * line]]
        assert np.linalg.matrix_rank(on_line - on_line[0], tol=1e-9) <= 1
    assert np.linalg.matrix_rank(points[inside], tol=1e-9) > 1


def test_a_direction_that_a_controller_does_not_have_is_left_out():
    geometric = TUNABLE[ControllerKind.GEOMETRIC]
    assert len(axes_of((Direction.GAIN, Direction.HORIZON), geometric.names)) == 1
    assert len(axes_of((Direction.GAIN, Direction.DAMPING), geometric.names)) == 2
    space = ParameterSpace(geometric.names, *(np.array(value) for value in (geometric.low, geometric.high, geometric.default)), np.ones(6))
    tuner = build("safe_bayesian:plane")
    tuner.start(space.first_guess(1), space, np.random.default_rng(0))
    for _ in range(12):
        asked = tuner.ask(1)
        tuner.tell(asked, scores_of([FIRST]))
    assert space.contains(asked)
    assert not np.array_equal(asked[0], space.first_guess(1))


@EVERY
def test_where_the_first_guess_crashes_it_creeps_and_takes_the_first_flight_that_does_not_for_its_first_guess(name):
    tuner, flown = start(name), []
    for k in range(30):
        asked = tuner.ask(1)
        flown.append(points_of(asked)[0])
        crashes = k < 20
        tuner.tell(asked, make_scores(np.array([np.nan if crashes else 20.0]), completion=0.0 if crashes else 0.5))
        assert crashes == ("no safe parameters are known" in tuner.report())
    known = np.array(flown)
    nearest = [np.linalg.norm(known[:k] - known[k], axis=1).min() for k in range(1, 21)]
    assert max(nearest) < SPACING * 1.001
    assert len(np.unique(known[:21], axis=0)) > 15
    np.testing.assert_array_equal(known[20 : 20 + BASELINE], known[20:21].repeat(BASELINE, axis=0))
    assert tuner.floor == pytest.approx(-np.log1p(20.0) - np.log(tuner.settings.tolerance))


def test_where_a_flight_had_no_cost_none_is_flown_again():
    tuner, rng = start("safe_bayesian:plane"), np.random.default_rng(0)
    fly(tuner, slope, 15, rng, noise=0.1)
    asked = tuner.ask(1)
    tuner.tell(asked, make_scores(np.array([np.inf])))
    later = fly(tuner, slope, 30, rng, noise=0.1)[0]
    assert np.linalg.norm(later - points_of(asked)[0], axis=1).min() > 0.2


def test_every_flight_below_the_floor_is_counted_and_reported():
    tuner, rng = start("safe_bayesian:plane"), np.random.default_rng(3)
    told = []
    for _ in range(40):
        asked = tuner.ask(1)
        told.append(FIRST + rng.standard_normal())
        tuner.tell(asked, scores_of(told[-1:]))
    expected = int((np.array(told) < tuner.floor).sum())
    assert tuner.violations == tuner.state()["violations"] == expected > 0
    assert tuner.report().startswith(f"{expected} of 40 flights below the floor")
