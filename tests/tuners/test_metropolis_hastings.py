"""The sampler obeys the laws of Metropolis-Hastings in every setting, and each preset is what it says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hotlap.tuners.metropolis_hastings import PRESETS, MetropolisHastings, MetropolisHastingsSettings, Reach, Scale, Score, window

from . import laws

BOTH = pytest.mark.parametrize("scale", list(Scale))


def untied(sigma: float, scale: Scale, **more) -> MetropolisHastingsSettings:
    return MetropolisHastingsSettings(sigma, scale, **{"tied": 0.0, **more})


def sampler(sigma: float, scale: Scale, **more) -> MetropolisHastings:
    return MetropolisHastings("under test", untied(sigma, scale, **more))


def unit_of(scale: Scale):
    """The coordinate in which the chain steps, over [1, e] or, for logarithms of it, over [0, 1]."""
    return np.log if scale is Scale.LOG else lambda w: (w - 1) / (np.e - 1)


@BOTH
def test_rejection_returns_the_old_state(scale):
    laws.check_rejection_returns_old_state(sampler(0.01, scale), laws.make_space(0.5, 2.0, 3), step=0.01)


def test_without_rollback_a_rejected_proposal_is_gone_on_from():
    tuner, space = sampler(0.01, Scale.RAW, rollback=False), laws.make_space(0.5, 2.0, 3)
    chain = laws.run_chain(tuner, space, lambda w: 0.0 if np.array_equal(w, space.first_guess(2)) else 1e6, 400, segments=2)
    assert chain.accepted.sum() == 1
    assert np.abs(chain.proposals[-1] - 1).max() > 0.06


@BOTH
@pytest.mark.parametrize("score", list(Score))
def test_many_chains_side_by_side_are_the_sampler_bit_for_bit(scale, score):
    """So that the laws below, which many chains obey, are laws of the sampler."""
    settings, space = untied(0.3, scale, temperature=1.5, score=score), laws.make_space(size=3)
    [many, one] = [
        laws.run_chains(settings, space, lambda w: 5 * (w**2).sum(axis=-1), 300, chains=1),
        laws.run_chain(MetropolisHastings("under test", settings), space, lambda w: float(5 * (w**2).sum()), 301),
    ]
    np.testing.assert_array_equal(one.proposals[1:], many.proposals)
    np.testing.assert_array_equal(one.states[1:], many.states)
    np.testing.assert_array_equal(one.accepted[1:], many.accepted[:, 0])
    assert 0.1 < one.accepted.mean() < 0.9


@BOTH
@pytest.mark.parametrize(("temperature", "difference"), [(1.0, 1.0), (2.0, 3.0)])
def test_acceptance_frequency_equals_the_ratio_of_densities(scale, temperature, difference):
    settings = untied(2.0, scale, temperature=temperature)
    laws.check_two_point_ratio(settings, laws.make_space(), unit_of(scale), (0.0, difference), np.exp(-difference / temperature))


@BOTH
def test_acceptance_ratio_holds_where_scores_underflow(scale):
    """exp(-m) of 1000 and 1001 is 0; their ratio is not."""
    laws.check_two_point_ratio(untied(2.0, scale), laws.make_space(), unit_of(scale), (1000.0, 1001.0), np.exp(-1.0))


@BOTH
@pytest.mark.parametrize("sigma", [0.3, 1.0])
def test_stationary_on_a_discrete_target_whatever_the_step(scale, sigma):
    sigma = sigma if scale is Scale.LOG else sigma * (np.e - 1)
    costs = np.array([1.0, 0.0, 2.0, 0.5])
    laws.check_discrete_stationarity(untied(sigma, scale, temperature=1.5), laws.make_space(), unit_of(scale), costs)


@BOTH
def test_flat_target_is_visited_evenly_up_to_the_bounds(scale):
    """Proposals mirrored at the bounds are symmetric; clipped or redrawn ones would crowd or thin the edges."""
    laws.check_discrete_stationarity(untied(0.4, scale), laws.make_space(), unit_of(scale), np.zeros(8))


@BOTH
def test_stationary_on_a_gaussian(scale):
    laws.check_gaussian_stationarity(untied(0.2, scale, temperature=2.0), laws.make_space(), unit_of(scale))


def test_horizon_takes_half_steps_in_logarithms():
    space = replace(laws.make_space(0.01, 100.0, 2), log_step=np.array([1.0, 0.5]))
    chain = laws.run_chain(sampler(0.3, Scale.LOG), space, lambda _: 0.0, 3000)
    steps = np.log(chain.proposals[1:] / chain.states[:-1])
    inside = np.all(
        (chain.proposals[1:] > 0.05) & (chain.proposals[1:] < 20) & (chain.states[:-1] > 0.05) & (chain.states[:-1] < 20), axis=(1, 2)
    )
    np.testing.assert_allclose(steps[inside].std(axis=(0, 1)), [0.3, 0.15], rtol=0.08)


def test_tied_share_of_the_moves_takes_one_step_for_all_segments():
    space = laws.make_space(0.01, 100.0, 2)
    chain = laws.run_chain(sampler(0.01, Scale.LOG, tied=0.3), space, lambda _: 0.0, 2000, segments=3)
    steps = np.log(chain.proposals[1:] / chain.states[:-1])
    together = np.ptp(steps, axis=1).max(axis=1) < 1e-9
    assert together.mean() == pytest.approx(0.3, abs=0.05)


def test_preset_paper_takes_independent_steps_of_five_in_raw_units():
    space = laws.make_space(1.0, 1e5, 5)
    chain = laws.run_chain(
        MetropolisHastings("paper", PRESETS["paper"]), space, lambda w: float(w[0, 0] != space.default[0]) * 1e9, 1500, 2
    )
    steps = (chain.proposals[1:] - space.default).reshape(-1, 10)
    np.testing.assert_allclose(steps.std(axis=0), 5.0, rtol=0.08)
    correlation = np.corrcoef(steps.T) - np.eye(10)
    assert np.abs(correlation).max() < 0.12


def test_default_preset_ties_all_segments():
    assert next(iter(PRESETS)) == "tied"
    chain = laws.run_chain(MetropolisHastings("tied", PRESETS["tied"]), laws.make_space(1.0, 100.0, 5), lambda _: 0.0, 200, segments=4)
    assert np.ptp(chain.proposals, axis=1).max() < 1e-9


@pytest.mark.parametrize("worst", [np.nan, np.inf, -np.inf])
def test_a_cost_that_is_no_number_is_accepted_only_from_another_such(worst):
    tuner, space = sampler(0.1, Scale.LOG), laws.make_space()
    tuner.start(space.first_guess(1), space, np.random.default_rng(0))
    verdicts = [bool(tuner.tell(tuner.ask(1), laws.make_scores(np.array([cost])))[0]) for cost in (worst, worst, 1e300, worst, worst)]
    assert verdicts == [True, True, True, False, False]


def test_proposal_stays_until_it_is_told():
    tuner, space = sampler(0.1, Scale.LOG), laws.make_space()
    tuner.start(space.first_guess(1), space, np.random.default_rng(0))
    tuner.tell(tuner.ask(1), laws.make_scores(np.array([1.0])))
    np.testing.assert_array_equal(tuner.ask(1), tuner.ask(5))


WIDE = replace(laws.make_space(0.01, 100.0, 3), names=("a", "b", "horizon"))


def steps_after_failing_in(segment: int, settings: MetropolisHastingsSettings, segments: int = 6, count: int = 1500) -> np.ndarray:
    """Logarithmic steps, shape (count, S, K), from a first guess that failed in a segment and is never left."""
    tuner, first = MetropolisHastings("under test", settings), WIDE.first_guess(segments)
    tuner.start(first, WIDE, np.random.default_rng(1))
    tuner.tell(tuner.ask(1), laws.make_scores(np.zeros(1), failed_segment=segment))
    asked = []
    for _ in range(count):
        asked.append(tuner.ask(1)[0])
        tuner.tell(asked[-1][None], laws.make_scores(np.array([1e9]), failed_segment=0))
    return np.log(np.array(asked) / first)


LOCAL = MetropolisHastingsSettings(0.2, Scale.LOG, tied=0.0, reach=Reach.FAILED, horizon=0.1)


@pytest.mark.parametrize(
    ("failed", "shares"),
    [
        (0, (1, 0, 0, 0, 0, 0)),
        (2, (0.5, 0.75, 1, 0, 0, 0)),
        (4, (0, 0.25, 0.5, 0.75, 1, 0)),
        (-1, (0, 0, 0.25, 0.5, 0.75, 1)),
    ],
)
def test_local_steps_move_the_failed_segment_and_the_three_before_it_and_nothing_else(failed, shares):
    steps = steps_after_failing_in(failed, LOCAL)
    shares = np.array(shares, float)
    assert (steps[:, shares == 0] == 0).all()
    np.testing.assert_allclose(steps.std(axis=0), 0.2 * shares[:, None] * [1, 1, 0.1], rtol=0.1)
    np.testing.assert_array_equal(window(6, failed), shares)


def test_the_released_rules_are_settings_of_their_own():
    released = PRESETS["released"]
    assert (released.sigma, released.scale, released.tied) == (5.0, Scale.RAW, 0.0)
    assert (released.score, released.reach, released.horizon, released.rollback) == (Score.ROOT, Reach.FAILED, 0.1, False)
    assert PRESETS["released_rollback"] == replace(released, rollback=True)
    assert PRESETS["paper"] == MetropolisHastingsSettings(5.0, Scale.RAW, 0.0)
    horizon_only = steps_after_failing_in(2, replace(LOCAL, reach=Reach.ALL))
    np.testing.assert_allclose(horizon_only.std(axis=0), np.tile([0.2, 0.2, 0.02], (6, 1)), rtol=0.1)


def test_the_released_score_takes_ten_seconds_more_one_time_in_six():
    """exp(-2 (sqrt(34) - sqrt(24))), where exp(-10) would take it never."""
    ratio = np.exp(-2 * (np.sqrt(34) - np.sqrt(24)))
    assert 1 / 7 < ratio < 1 / 5
    laws.check_two_point_ratio(untied(2.0, Scale.LOG, score=Score.ROOT), laws.make_space(), np.log, (24.0, 34.0), ratio)
