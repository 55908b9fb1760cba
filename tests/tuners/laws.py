"""The laws of a sampler, in one place: what any tuner that claims to be a Metropolis-Hastings chain must obey."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import erf, sqrt

import numpy as np

from hotlap.core.parameters import Parameters, ParameterSpace
from hotlap.core.records import Scores
from hotlap.tuners import Tuner
from hotlap.tuners.metropolis_hastings import MetropolisHastingsSettings, Reach, accepts, propose

FORGET = 100  # steps after which a chain has forgotten where it began


def make_space(low: float = 1.0, high: float = np.e, size: int = 1) -> ParameterSpace:
    """`size` alike parameters; by default their logarithms run from 0 to 1."""
    one = np.ones(size)
    return ParameterSpace(tuple("abcdefgh"[:size]), low * one, high * one, np.sqrt(low * high) * one, one)


def make_scores(costs: np.ndarray, completion: float = 0.5, failed_segment: int = 0) -> Scores:
    """Scores with given costs and otherwise equal flights."""
    count = len(costs)
    flown = Scores.of_costs(np.asarray(costs, float))
    return replace(flown, completion=np.full(count, completion), failed_segment=np.full(count, failed_segment))


@dataclass(frozen=True)
class Chain:
    """What a chain did.

    Attributes:
        states: shape (steps, S, K) after each step; of many chains (steps, chains, K).
        proposals: likewise.
        accepted: shape (steps,), or (steps, chains).
    """

    states: np.ndarray
    proposals: np.ndarray
    accepted: np.ndarray


def run_chain(tuner: Tuner, space: ParameterSpace, cost: Callable[[Parameters], float], steps: int, segments: int = 1) -> Chain:
    """Run a tuner as a chain on a cost; a state is the last accepted proposal."""
    tuner.start(space.first_guess(segments), space, np.random.default_rng(7))
    states, proposals, accepted = [], [], []
    for _ in range(steps):
        asked = tuner.ask(1)
        took = bool(tuner.tell(asked, make_scores(np.array([cost(asked[0])])))[0])
        proposals.append(asked[0])
        accepted.append(took)
        states.append(asked[0] if took else states[-1])
    return Chain(np.array(states), np.array(proposals), np.array(accepted))


def run_chains(
    settings: MetropolisHastingsSettings, space: ParameterSpace, cost: Callable[[np.ndarray], np.ndarray], steps: int, chains: int = 200
) -> Chain:
    """Many independent chains side by side, each of one segment: the steps and the decisions of `MetropolisHastings`.

    Args:
        settings: of the sampler; segments are moved apart, since each is a chain.
        space: what is sampled.
        cost: of parameters of shape (chains, K), shape (chains,).
        steps: of each chain.
        chains: how many; all begin at the first guess.
    """
    assert (settings.tied, settings.rollback, settings.reach) == (0.0, True, Reach.ALL)
    rng, current = np.random.default_rng(7), space.first_guess(chains)
    costs, flown = cost(current), []
    rng.standard_exponential(chains)  # of the first guess, which is accepted whatever it costs
    for _ in range(steps):
        proposal = propose(settings, space, rng, current, failed=-1)
        proposed = cost(proposal)
        accepted = accepts(settings.score, settings.temperature, proposed, costs, rng.standard_exponential(chains))
        current, costs = np.where(accepted[:, None], proposal, current), np.where(accepted, proposed, costs)
        flown.append((current, proposal, accepted))
    return Chain(*(np.array(each) for each in zip(*flown, strict=True)))


def cell_of(unit: np.ndarray, cells: int) -> np.ndarray:
    """Which of equally wide cells of [0, 1] each value lies in."""
    return np.minimum((unit * cells).astype(int), cells - 1)


def check_two_point_ratio(
    settings: MetropolisHastingsSettings,
    space: ParameterSpace,
    unit: Callable[[np.ndarray], np.ndarray],
    costs: tuple[float, float],
    ratio: float,
) -> None:
    """Moves to the worse half are accepted with the ratio of densities, moves to the better half always."""
    chain = run_chains(settings, space, lambda w: np.array(costs)[cell_of(unit(w[:, 0]), 2)], 100)
    worse = unit(chain.proposals)[1:, :, 0] >= 0.5
    was_worse = unit(chain.states)[:-1, :, 0] >= 0.5
    climbs = chain.accepted[1:][worse & ~was_worse]
    assert len(climbs) > 3000
    assert abs(climbs.mean() - ratio) < 4 * sqrt(ratio * (1 - ratio) / len(climbs))
    assert chain.accepted[1:][~worse].all()


def check_discrete_stationarity(
    settings: MetropolisHastingsSettings, space: ParameterSpace, unit: Callable[[np.ndarray], np.ndarray], costs: np.ndarray
) -> None:
    """Time spent in each cell is proportional to its density, and as many moves lead from one cell to another as back."""
    cells = len(costs)
    chain = run_chains(settings, space, lambda w: costs[cell_of(unit(w[:, 0]), cells)], FORGET + 300)
    visited = cell_of(unit(chain.states)[FORGET:, :, 0], cells)
    density = np.exp(-costs / settings.temperature)
    np.testing.assert_allclose(np.bincount(visited.ravel(), minlength=cells) / visited.size, density / density.sum(), atol=0.01)
    moves = np.zeros((cells, cells))
    np.add.at(moves, (visited[:-1], visited[1:]), 1)
    assert (np.abs(moves - moves.T) <= 5 * np.sqrt(moves + moves.T) + 1).all()


def check_gaussian_stationarity(
    settings: MetropolisHastingsSettings, space: ParameterSpace, unit: Callable[[np.ndarray], np.ndarray]
) -> None:
    """A quadratic cost gives normally distributed samples."""
    centre, width = 0.5, 0.07
    chain = run_chains(settings, space, lambda w: settings.temperature * (unit(w[:, 0]) - centre) ** 2 / (2 * width**2), FORGET + 300)
    values = np.sort(unit(chain.states)[FORGET:, :, 0], axis=None)
    expected = np.array([0.5 * (1 + erf((value - centre) / (width * sqrt(2)))) for value in values[::10]])
    assert np.abs(expected - np.arange(0, len(values), 10) / len(values)).max() < 0.015  # Kolmogorov's distance
    assert abs(values.std() / width - 1) < 0.025


def check_rejection_returns_old_state(tuner: Tuner, space: ParameterSpace, step: float) -> None:
    """However many proposals are rejected, the next one starts from the same sample.

    Args:
        tuner: with Gaussian steps.
        space: many steps wide.
        step: standard deviation of a step, relative to the default.
    """
    first = space.first_guess(2)
    chain = run_chain(tuner, space, lambda w: 0.0 if np.array_equal(w, first) else 1e6, 400, segments=2)
    assert chain.accepted.sum() == 1
    np.testing.assert_array_equal(chain.states[-1], first)
    strayed = np.abs(chain.proposals[1:] / first - 1)
    assert strayed.max() < 6 * step
    assert strayed.mean() > 0.5 * step
