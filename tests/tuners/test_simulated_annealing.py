"""Annealing is the sampler, at a temperature that falls by the schedule."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from hotlap.tuners.metropolis_hastings import MetropolisHastings, Scale
from hotlap.tuners.metropolis_hastings import MetropolisHastingsSettings as Walk
from hotlap.tuners.simulated_annealing import PRESETS, Cooling, SimulatedAnnealing, SimulatedAnnealingSettings

from . import laws
from .test_contract import play, start

WALK = Walk(2.0, Scale.LOG, tied=0.0, temperature=8.0)


def test_geometric_cooling_falls_by_its_factor_to_the_coldest():
    settings = SimulatedAnnealingSettings(WALK, factor=0.5, coldest=0.7)
    assert [settings.temperature(k) for k in range(6)] == [8.0, 4.0, 2.0, 1.0, 0.7, 0.7]


def test_logarithmic_cooling_falls_as_the_logarithm():
    settings = SimulatedAnnealingSettings(WALK, Cooling.LOGARITHMIC, coldest=0.0)
    assert settings.temperature(0) == 8.0
    assert settings.temperature(1022) == pytest.approx(0.8)


@pytest.mark.parametrize("cooling", list(Cooling))
def test_each_decision_is_taken_at_the_temperature_of_its_turn(cooling):
    """Over many runs, the k-th decision takes a cost of 3 more with probability exp(-3 / T_k)."""
    settings = SimulatedAnnealingSettings(WALK, cooling, factor=0.6, coldest=1.0)
    space, runs, taken = laws.make_space(), 3000, np.zeros(6)
    tuner, rng = SimulatedAnnealing("under test", settings), np.random.default_rng(5)
    for _ in range(runs):
        tuner.start(space.first_guess(1), space, rng)
        tuner.tell(tuner.ask(1), laws.make_scores(np.zeros(1)))
        for k in range(6):
            cost = tuner._chain._cost  # of where it stands
            taken[k] += tuner.tell(tuner.ask(1), laws.make_scores(np.array([cost + 3.0])))[0]
    expected = np.array([math.exp(-3.0 / settings.temperature(k)) for k in range(6)])
    np.testing.assert_array_less(np.abs(taken / runs - expected), 4 * np.sqrt(expected * (1 - expected) / runs))


def test_without_cooling_it_is_the_sampler_bit_for_bit():
    walk = replace(WALK, temperature=1.0)
    annealing = SimulatedAnnealing("under test", SimulatedAnnealingSettings(walk, factor=1.0, coldest=0.0))
    sampler, space = MetropolisHastings("under test", walk), laws.make_space(size=2)
    chains = [laws.run_chain(tuner, space, lambda w: float(w.sum()), 300, segments=2) for tuner in (annealing, sampler)]
    np.testing.assert_array_equal(chains[0].proposals, chains[1].proposals)
    np.testing.assert_array_equal(chains[0].accepted, chains[1].accepted)


@pytest.mark.parametrize("name", [f"simulated_annealing:{preset}" for preset in PRESETS])
def test_the_temperature_survives_a_restore(name):
    tuner, other = start(name), start(name, seed=99)
    play(tuner, 20)
    other.restore(tuner.state())
    for each in (tuner, other):
        play(each, 1)
    assert tuner._chain.temperature == other._chain.temperature < tuner.settings.walk.temperature
