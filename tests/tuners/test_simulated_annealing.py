"""Annealing is the sampler, at a temperature that falls by the schedule."""

from __future__ import annotations

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


class Chance:
    """A random generator whose next threshold of a decision, -log u, is set."""

    def __init__(self) -> None:
        self.rng, self.threshold = np.random.default_rng(5), np.inf

    def __getattr__(self, name):
        return getattr(self.rng, name)

    def standard_exponential(self) -> float:
        return self.threshold


@pytest.mark.parametrize("cooling", list(Cooling))
@pytest.mark.parametrize("turn", range(6))
def test_each_decision_is_taken_at_the_temperature_of_its_turn(cooling, turn):
    """A cost of 3 more is accepted where u < exp(-3 / T_k), k the decision's number."""
    settings = SimulatedAnnealingSettings(WALK, cooling, factor=0.6, coldest=1.0)
    limit, space, verdicts = 3.0 / settings.temperature(turn), laws.make_space(), []
    for threshold in (limit * (1 - 1e-9), limit * (1 + 1e-9)):
        tuner, rng = SimulatedAnnealing("under test", settings), Chance()
        tuner.start(space.first_guess(1), space, rng)
        for k in range(turn + 2):  # the first guess, and decisions that all accept but for the last
            rng.threshold = threshold if k == turn + 1 else np.inf
            [accepted] = tuner.tell(tuner.ask(1), laws.make_scores(np.array([3.0 * k])))
        verdicts.append(bool(accepted))
    assert verdicts == [False, True]


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
