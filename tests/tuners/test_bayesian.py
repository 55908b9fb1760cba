"""Bayesian optimisation: its opening, its improvement, its regression of costs, and what it finds."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from hotlap.tuners import bayesian
from hotlap.tuners.bayesian import MEMORY, PRESETS, REFIT, WORST, log_expected_improvement, remembered, standardise
from hotlap.tuners.unit_box import latin_hypercube

from .laws import make_scores
from .test_contract import SEGMENTS, SPACE, judge, play, start

RAW = "bayesian:matern"
OPENING = PRESETS["matern"].opening


def unit(asked, name):
    """Points in the unit box of a preset, shape (flights, S K)."""
    raw = (asked - SPACE.low) / (SPACE.high - SPACE.low)
    return (SPACE.to_unit(asked) if name == "log" else raw).reshape(len(asked), -1)


@pytest.mark.parametrize("preset", PRESETS)
def test_the_opening_is_the_first_guess_and_one_flight_in_every_slice_of_every_axis(preset):
    opening = unit(start(f"bayesian:{preset}").ask(64), preset)
    assert len(opening) == OPENING
    slices = np.floor(opening[1:] * (OPENING - 1)).astype(int)
    assert (np.sort(slices, axis=0) == np.arange(OPENING - 1)[:, None]).all()


def test_a_latin_hypercube_differs_from_axis_to_axis():
    points = latin_hypercube(20, 5, np.random.default_rng(0))
    assert np.abs(np.corrcoef(points.T) - np.eye(5)).max() < 0.7


def test_the_opening_may_be_asked_for_in_pieces():
    np.testing.assert_array_equal(play(start(RAW), 30, n=7), play(start(RAW), 30, n=1))


def test_after_the_opening_every_flight_teaches():
    tuner = start(RAW)
    play(tuner, OPENING)
    first = tuner.ask(8)
    assert len(first) == 1
    np.testing.assert_array_equal(tuner.ask(3), first)


def test_hyperparameters_are_looked_at_again_every_ten_flights():
    tuner, looks = start(RAW), []
    for _ in range(35):
        asked = tuner.ask(1)
        looks.append(None if tuner._theta is None else tuple(tuner._theta))
        tuner.tell(asked, judge(asked))
    changed = [flight for flight in range(1, 35) if looks[flight] != looks[flight - 1]]
    assert changed == [10, 20, 30]
    assert REFIT == 10


@pytest.mark.parametrize("incumbent", [-2.0, 0.0, 0.7, 5.0])
@pytest.mark.parametrize("deviation", [0.1, 1.0, 3.0])
def test_expected_improvement_is_an_expectation(incumbent, deviation):
    def gain(y):
        return (incumbent - y) * norm.pdf(y, 0.5, deviation)

    expected = quad(gain, 0.5 - 40 * deviation, incumbent, epsabs=0, points=[0.5, incumbent - deviation], limit=200)[0]
    found = log_expected_improvement(np.array([0.5]), np.array([deviation]), incumbent)[0]
    assert found == pytest.approx(np.log(expected), rel=1e-6)


def test_expected_improvement_falls_steadily_where_its_value_underflows():
    means = np.concatenate([np.linspace(-5, 5, 400), np.geomspace(6, 1e8, 400)])
    found = log_expected_improvement(means, np.ones(800), 0.0)
    assert np.isfinite(found).all()
    assert (np.diff(found) < 0).all()
    z = 1e3
    asymptote = -0.5 * z**2 - 0.5 * np.log(2 * np.pi) - 2 * np.log(z)
    assert log_expected_improvement(np.array([z]), np.ones(1), 0.0)[0] == pytest.approx(asymptote, abs=1e-5)


def test_of_equal_means_the_less_certain_promises_more_and_certainty_is_no_trouble():
    found = log_expected_improvement(np.zeros(3), np.array([0.0, 0.5, 1.0]), 0.0)
    assert found[0] < found[1] < found[2]
    assert log_expected_improvement(np.array([-1.0]), np.zeros(1), 0.0)[0] == pytest.approx(0.0)


def test_costs_are_standardised_and_what_has_none_is_a_little_worse_than_the_worst():
    values = standardise(np.array([1.0, 2.0, np.inf, 4.0, np.inf]))
    assert values.mean() == pytest.approx(0)
    assert values.std() == pytest.approx(1)
    worst, failed = values[3], values[2]
    assert values[4] == failed
    assert 0 < failed - worst < 0.3


@pytest.mark.parametrize("costs", [[np.inf, np.inf], [3.0], [WORST, WORST, WORST], [0.1] * 7])
def test_costs_that_are_all_alike_are_all_nought(costs):
    np.testing.assert_allclose(standardise(np.array(costs)), 0, atol=1e-6)


def test_neither_scale_nor_origin_of_costs_matters():
    plain = play(start(RAW), 40, scores=lambda asked: make_scores(np.round(judge(asked).cost, 6)))
    scaled = play(start(RAW), 40, scores=lambda asked: make_scores(1024 * np.round(judge(asked).cost, 6)))
    np.testing.assert_array_equal(plain, scaled)


def test_an_ordinary_cost_is_fitted_as_it_is():
    """The paper transforms no costs."""
    costs = np.array([1.0, 2.0, 10.0])
    values = standardise(costs)
    assert (values[2] - values[1]) / (values[1] - values[0]) == pytest.approx(8.0)


def test_the_best_and_the_latest_are_remembered():
    costs = np.random.default_rng(0).random(500)
    kept = remembered(costs)
    assert len(kept) <= MEMORY
    assert set(range(500 - MEMORY // 2, 500)) <= set(kept)
    assert set(np.argsort(costs)[:50]) <= set(kept)
    np.testing.assert_array_equal(remembered(costs[:MEMORY]), np.arange(MEMORY))


@pytest.mark.parametrize("preset", PRESETS)
def test_finds_more_than_chance_in_a_noisy_bowl_of_its_box(preset):
    """Costs of the last flights, against as many points spread evenly."""
    noise = np.random.default_rng(0)
    goal = np.linspace(0.2, 0.6, SEGMENTS * SPACE.size)

    def bowl(asked):
        return ((unit(asked, preset) - goal) ** 2).sum(axis=1)

    asked = play(start(f"bayesian:{preset}"), 70, scores=lambda p: make_scores(bowl(p) + 0.02 * noise.standard_normal(len(p))))
    even = ((latin_hypercube(5000, goal.size, noise) - goal) ** 2).sum(axis=1)
    assert np.median(bowl(asked[-20:])) < np.quantile(even, 0.02)


def test_improvement_is_counted_from_what_is_likely_and_not_from_a_lucky_flight(monkeypatch):
    incumbents = []

    def spy(mean, deviation, incumbent):
        incumbents.append(incumbent)
        return log_expected_improvement(mean, deviation, incumbent)

    monkeypatch.setattr(bayesian, "log_expected_improvement", spy)
    tuner, noise = start("bayesian:log"), np.random.default_rng(1)
    play(tuner, 45, scores=lambda p: make_scores(noise.standard_normal(len(p))))
    tuner._theta = [np.log(0.2), np.log(0.5), np.log(0.8)]  # signal, length, noise
    tuner.ask(1)
    assert incumbents[-1] > standardise(np.array(tuner._costs)).min() + 0.5


def test_the_unit_box_is_of_own_units_or_of_logarithms():
    asked = play(start(RAW), OPENING)[1:, :, 0]
    logs = play(start("bayesian:log"), OPENING)[1:, :, 0]
    middle = np.sqrt(SPACE.low[0] * SPACE.high[0])
    assert (asked > middle).mean() > 0.8
    assert 0.3 < (logs > middle).mean() < 0.7


def test_nothing_heavy_is_loaded_before_the_opening_is_flown():
    program = (
        "import sys, numpy as np; from tuners.test_contract import start, judge\n"
        "tuner = start('bayesian'); asked = tuner.ask(64); tuner.tell(asked, judge(asked)); print('sklearn' in sys.modules)\n"
        "tuner.ask(1); print('sklearn' in sys.modules)"
    )
    ran = subprocess.run([sys.executable, "-c", program], cwd=Path(__file__).parents[1], capture_output=True, text=True, check=True)
    assert ran.stdout.split() == ["False", "True"]


def test_the_paper_had_five_kernels():
    assert len({settings.family for settings in PRESETS.values()}) == 5
    assert not any(settings.log for preset, settings in PRESETS.items() if preset != "log")
    assert next(iter(PRESETS)) == "matern"
    assert bayesian.PRESETS["log"].family is PRESETS["matern"].family
