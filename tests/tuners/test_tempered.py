"""Every chain samples its own temperature's density, whether chains swap, try several proposals, or neither."""

from __future__ import annotations

import numpy as np
import pytest

from hotlap.core.records import Scores
from hotlap.tuners.metropolis_hastings import MetropolisHastingsSettings as Walk
from hotlap.tuners.metropolis_hastings import Scale
from hotlap.tuners.tempered import PRESETS, Tempered, TemperedSettings

from . import laws
from .test_contract import play, start

WALK = Walk(1.0, Scale.LOG, tied=0.0)  # as wide as the bounds: few steps are alike, so few are enough
COSTS = np.array([1.0, 0.0, 2.0, 0.5, 3.0])
SPACE = laws.make_space()


def visits(settings: TemperedSettings, rounds: int) -> np.ndarray:
    """Share of its time that each chain spends in each cell of a discrete target, shape (chains, cells)."""
    tuner, counts = Tempered("under test", settings), np.zeros((len(settings.temperatures), len(COSTS)))
    tuner.start(SPACE.first_guess(1), SPACE, np.random.default_rng(11))
    for _ in range(rounds):
        asked = tuner.ask(100)
        tuner.tell(asked, Scores.of_costs(COSTS[laws.cell_of(np.log(asked[:, 0, 0]), len(COSTS))]))
        if tuner._phase == "tries":
            np.add.at(counts, (np.arange(len(counts)), laws.cell_of(np.log(tuner._samples[:, 0, 0]), len(COSTS))), 1)
    return counts / counts.sum(axis=1, keepdims=True)


@pytest.mark.parametrize(
    ("settings", "rounds"),
    [
        (TemperedSettings(WALK, (0.5, 1.0, 3.0), swaps=True), 5_000),
        (TemperedSettings(WALK, (0.5, 1.0, 3.0)), 5_000),
        (TemperedSettings(WALK, (1.0,), tries=3), 8_000),
        (TemperedSettings(WALK, (0.5, 2.0), swaps=True, tries=2), 6_000),
    ],
    ids=["swaps", "independent", "tries", "both"],
)
def test_every_chain_is_stationary_at_its_temperature(settings, rounds):
    density = np.exp(-COSTS / np.array(settings.temperatures)[:, None])
    np.testing.assert_allclose(visits(settings, rounds), density / density.sum(axis=1, keepdims=True), atol=0.025)


def test_swaps_happen_as_often_as_the_ratio_of_densities():
    settings, taken, runs = TemperedSettings(WALK, (1.0, 4.0), swaps=True), 0, 4000
    tuner = Tempered("under test", settings)
    tuner.start(SPACE.first_guess(1), SPACE, np.random.default_rng(2))
    for _ in range(runs):
        tuner._energies[:], tuner._steps = [1.0, 3.0], 0
        tuner._swap()
        taken += tuner._energies[0] == 3.0
    assert taken / runs == pytest.approx(np.exp((1 - 1 / 4) * (1.0 - 3.0)), abs=0.025)


def test_a_better_sample_always_goes_to_the_colder_chain():
    tuner = Tempered("under test", TemperedSettings(WALK, (1.0, 4.0, 9.0), swaps=True))
    tuner.start(SPACE.first_guess(1), SPACE, np.random.default_rng(2))
    tuner._energies[:] = [5.0, 4.0, 1.0]
    tuner._swap()
    assert tuner._energies.tolist() == [4.0, 5.0, 1.0]
    tuner._swap()
    assert tuner._energies.tolist() == [4.0, 1.0, 5.0]


def test_the_first_guess_is_flown_once_and_then_every_chain_proposes():
    tuner = start("tempered:independent")
    assert [len(tuner.ask(9))] == [1]
    play(tuner, 1)
    assert len(tuner.ask(9)) == 4
    assert len(np.unique(tuner.ask(9), axis=0)) == 4


def test_a_step_of_three_tries_takes_five_flights():
    tuner, sizes = start("tempered:multiple_try"), []
    for _ in range(5):
        sizes.append(len(tuner.ask(9)))
        play(tuner, sizes[-1], n=9)
    assert sizes == [1, 3, 2, 3, 2]


@pytest.mark.parametrize("name", [f"tempered:{preset}" for preset in PRESETS])
def test_a_round_may_be_asked_for_in_pieces(name):
    np.testing.assert_array_equal(play(start(name), 60, n=20), play(start(name), 60, n=1))


@pytest.mark.parametrize("name", [f"tempered:{preset}" for preset in PRESETS if preset != "swapping_paper"])
def test_chains_come_down_a_bowl(name):
    tuner = start(name)
    asked = play(tuner, 400)
    costs = (np.log(asked / tuner._space.default * 1.5) ** 2).sum(axis=(1, 2))
    assert costs[-50:].min() < 0.5 * costs[0]
