"""The policy is fitted to weighted samples in closed form, and never stops exploring."""

import json
from dataclasses import replace

import numpy as np
import pytest

from hotlap import tuners
from hotlap.tuners.weighted_likelihood import Policy, weigh

from .laws import make_scores
from .test_contract import SEGMENTS, SPACE, judge, play, start

N = 10


def told(tuner, costs):
    tuner.tell(tuner.ask(len(costs)), make_scores(np.asarray(costs, float)))
    return tuner


def distance(tuner):
    """From the mean of the policy to the bottom of the contract's bowl, which lies at the default / 1.5."""
    return np.linalg.norm(np.log(tuner._offsets.decode(tuner._policy.mean[None])[0] / SPACE.default * 1.5))


def test_weights_are_exponential_in_the_reward_between_the_worst_and_the_best():
    costs = np.array([0.0, 3.0, 1.0])
    np.testing.assert_allclose(weigh(costs, 4.0), np.exp(-4.0 * np.log1p(costs) / np.log(4.0)))


@pytest.mark.parametrize("lost", [np.nan, np.inf])
def test_a_cost_that_is_no_number_weighs_as_the_worst(lost):
    np.testing.assert_array_equal(weigh(np.array([5.0, lost, 2.0]), 3.0), weigh(np.array([5.0, 5.0, 2.0]), 3.0))


@pytest.mark.parametrize("costs", [[7.0, 7.0], [np.nan, np.inf]])
def test_where_no_cost_differs_all_weigh_the_same(costs):
    np.testing.assert_array_equal(weigh(np.array(costs), 3.0), 1.0)


def test_a_fit_to_many_equal_samples_is_their_mean_and_covariance():
    samples = np.random.default_rng(0).standard_normal((100_000, 2)) @ np.array([[1.0, 0.4], [0.0, 0.5]]) + [3.0, -1.0]
    fitted = Policy(np.zeros(2), np.eye(2)).fit(samples, np.ones(len(samples)), floor=0.0)
    np.testing.assert_allclose(fitted.mean, samples.mean(axis=0))
    np.testing.assert_allclose(fitted.covariance, np.cov(samples.T), atol=1e-3)


def test_a_fit_is_the_weighted_maximum_likelihood_and_the_old_covariance():
    rng = np.random.default_rng(1)
    samples, weights, old = rng.standard_normal((6, 3)), rng.random(6), 2.0 * np.eye(3)
    mean = sum(d * z for d, z in zip(weights, samples, strict=True)) / weights.sum()
    scatter = sum(d * np.outer(z - mean, z - mean) for d, z in zip(weights, samples, strict=True))
    scatter /= (weights.sum() ** 2 - (weights**2).sum()) / weights.sum()
    share = 1 / (1 + 3 * (weights**2).sum() / weights.sum() ** 2)
    fitted = Policy(np.zeros(3), old).fit(samples, weights, floor=0.1)
    np.testing.assert_allclose(fitted.mean, mean)
    np.testing.assert_allclose(fitted.covariance, share * (scatter + 0.01 * np.eye(3)) + (1 - share) * old)


def test_weights_of_any_scale_give_the_same_fit():
    rng = np.random.default_rng(2)
    samples, weights, policy = rng.standard_normal((6, 3)), rng.random(6), Policy(np.zeros(3), np.eye(3))
    np.testing.assert_allclose(policy.fit(samples, weights, 0.1).covariance, policy.fit(samples, 50 * weights, 0.1).covariance)


@pytest.mark.parametrize("size", [1, 5, 40])
def test_however_often_the_samples_agree_exploration_keeps_its_floor(size):
    policy = Policy(np.zeros(size), np.eye(size))
    for _ in range(400):
        policy = policy.fit(np.ones((4, size)), np.ones(4), floor=0.1)
    np.testing.assert_allclose(np.linalg.eigvalsh(policy.covariance), 0.01, rtol=1e-3)


def test_the_first_iteration_lies_around_the_first_guess():
    steps = np.concatenate([np.log(start("weighted_likelihood", seed).ask(N)[1:, 0] / SPACE.default) for seed in range(40)])
    np.testing.assert_allclose(steps.std(axis=0) / SPACE.log_step, 0.5, rtol=0.2)
    np.testing.assert_allclose(steps.mean(axis=0), 0.0, atol=0.1)


def test_tied_steps_keep_the_differences_of_the_segments():
    guess = SPACE.first_guess(SEGMENTS) * np.array([[0.9], [1.0], [1.1]])
    ratios = {}
    for preset in ("tied", "segments"):
        tuner = tuners.build(f"weighted_likelihood:{preset}")
        tuner.start(guess, SPACE, np.random.default_rng(0))
        asked = tuner.ask(N)[:, :, 2:4]  # those two stay away from their bounds
        inside = (asked < SPACE.high[2:4]).all(axis=(1, 2))
        ratios[preset] = asked[inside] / asked[inside, :1]
    np.testing.assert_allclose(ratios["tied"], np.broadcast_to(guess[:, 2:4] / guess[0, 2:4], ratios["tied"].shape))
    assert not np.allclose(ratios["segments"], ratios["segments"][0])


def test_an_iteration_may_be_asked_for_in_pieces():
    np.testing.assert_array_equal(play(start("weighted_likelihood"), 60, n=3), play(start("weighted_likelihood"), 60, n=20))


def test_the_mean_moves_to_the_better_samples():
    tuner = start("weighted_likelihood")
    samples = tuner._samples
    told(tuner, np.where(samples[:, 0] > np.median(samples[:, 0]), 0.0, 100.0))
    assert tuner._policy.mean[0] > samples[:, 0].mean()


@pytest.mark.parametrize("cost", [4.0, np.nan])
def test_an_iteration_that_tells_nothing_leaves_the_policy(cost):
    tuner = start("weighted_likelihood")
    before = tuner._policy
    told(tuner, [cost] * N)
    assert tuner._policy is before


@pytest.mark.parametrize("preset", ["tied", "segments", "dense"])
def test_it_finds_the_bottom_of_a_bowl(preset):
    tuner = start(f"weighted_likelihood:{preset}")
    before = distance(tuner)
    play(tuner, 600, n=20)
    assert distance(tuner) < 0.35 * before


def test_dense_listens_to_the_dense_cost_alone():
    for name, ignored in (("weighted_likelihood:dense", "cost"), ("weighted_likelihood:tied", "dense")):
        for field in ("cost", "dense"):
            asked = play(start(name), 60, scores=lambda p, field=field: replace(judge(p), **{field: np.ones(len(p))}))
            assert np.array_equal(asked, play(start(name), 60)) == (field == ignored)


def test_what_is_asked_for_and_not_told_is_asked_for_again_after_a_restore():
    tuner, other = start("weighted_likelihood"), start("weighted_likelihood", seed=99)
    told(tuner, [1.0, 2.0, np.inf])
    pending = tuner.ask(4)
    other.restore(json.loads(json.dumps(tuner.state(), allow_nan=False)))
    np.testing.assert_array_equal(other.ask(4), pending)
    np.testing.assert_array_equal(play(told(other, range(4)), 30), play(told(tuner, range(4)), 30))
