"""GateGp: hotlap's own tuner, a walk guided by a Gaussian process for every gate.

1. A cost is the sum of what happens at the gates, and is modelled as such (composite Bayesian optimisation: Astudillo, Frazier, ICML 2019):
   one process for each gate, of the parameters flown until then (`gate_process`). Flights in which all segments are alike are enough to
   learn which segment likes what, so that the segments part when it pays, and not before.
2. Candidates around the visited point that is expected to be best are judged by mean - k sd of the sum of the gates' chances to be missed;
   the best one is the centre of the next generation of candidates, and the last one is flown. Steps are Gaussian in logarithms and of all
   sizes; most are the same in all segments, some move a range of segments alone. k differs from flight to flight.
3. A gate counts as passed only with a little to spare, since the next flight has another noise.
4. With a small probability it leaves from another good point, or flies anywhere, at first more often: the first guess, or the place
   where it is at work, may be far from everything that holds.

A cost that says nothing of gates has one process, of all parameters.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters, ParameterSpace
from hotlap.core.records import Scores
from hotlap.tuners.surrogates.gate_process import GateKernel, Group, climb_at_random, condition, gate_groups
from hotlap.tuners.walk import Walk, WalkSettings, fitted, leaping_points

Floats = NDArray[np.float64]

POOL = 300  # candidates of a generation
REFIT = 5  # flights between climbs of the likelihood, or twice as many where the walk exploration just then
STRIDES = (20, 6)  # of the first climb, and of the later ones
STEP_SIZES = (math.log(0.1), math.log(1.5))  # of a candidate, in units of `step`
EAGERNESS = (math.log(0.3), math.log(3.0))  # of k
HALF_ROAMING, LEAST_ROAMING = 20, 0.25  # flights in which the chance to roam halves, and the share of it that is left for ever
SPARE = 0.15  # of the logarithm of a gate's distance: to pass with, and standard deviation of what no process knows
PROBIT = 1.7  # softplus(1.7 z) is nearly -log of the chance that a standard normal is larger than z


@dataclass(frozen=True)
class GateGpSettings(WalkSettings):
    """What tells one from another.

    Attributes:
        generations: of candidates before each flight.
        parted: share of the candidates that move a range of segments alone.
        gates: whether there is a process for each gate; else one for the cost.
    """

    restart_probability: float = 0.1
    exploration: float = 0.4
    generations: int = 3
    parted: float = 0.33
    gates: bool = True


PRESETS: Mapping[str, GateGpSettings] = {
    "default": GateGpSettings(),
    "whole": GateGpSettings(gates=False),
    "one_generation": GateGpSettings(generations=1),
    "tied": GateGpSettings(parted=0.0),
    "no_restarts": GateGpSettings(restart_probability=0.0, exploration=0.0),
    "no_exploration": GateGpSettings(exploration=0.0),
}


class GateGp(Walk[GateGpSettings]):
    """A walk guided by a process for every gate."""

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Begin at the first guess."""
        super().start(first_guess, space, rng)
        self._misses: list[list[float]] = []
        self._gate_segments: list[int] = []
        self._kernel: GateKernel | None = None

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:
        """Remember; true where a flight is the best so far."""
        if self.settings.gates:
            self._misses += scores.gate_miss.tolist()
            self._gate_segments = scores.gate_segment[0].tolist()
        return super().tell(parameters, scores)

    def state(self) -> dict[str, Any]:
        """Every flight, the kernel, a proposal under way and the random generator."""
        return {
            **super().state(),
            "misses": [[miss if math.isfinite(miss) else None for miss in flight] for flight in self._misses],
            "gate_segments": self._gate_segments,
            "kernel": None if self._kernel is None else self._kernel.numbers.tolist(),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go on where `state()` was taken."""
        super().restore(state)
        self._misses = [[math.nan if miss is None else miss for miss in flight] for flight in state["misses"]]
        self._gate_segments = list(state["gate_segments"])
        self._kernel = None if state["kernel"] is None else GateKernel(np.array(state["kernel"]))

    def _roaming(self, flown: int) -> float:
        """Chance of a flight anywhere: it falls, but not to nothing, lest the walk stay where no set of parameters holds."""
        return self.settings.exploration * max(LEAST_ROAMING, HALF_ROAMING / (HALF_ROAMING + flown))

    def _steps(self, count: int) -> Floats:
        """Gaussian steps of unit size, the same in all segments, shape (count, S K)."""
        segments, size = self._shape_of_parameters
        return np.tile(self._rng.standard_normal((count, size)), segments)

    def _propose(self, costs: Floats) -> Floats:
        """The best candidate of the last generation, or a leap."""
        chosen = fitted(costs)
        flat = np.array(self._points)[chosen]
        points, groups = self._cube(flat), self._groups(costs, chosen)
        if self._kernel is None or len(costs) % REFIT == 0:
            first, later = STRIDES
            start, strides = (GateKernel.prior(points.shape[2]), first) if self._kernel is None else (self._kernel, later)
            self._kernel = climb_at_random(points, groups, start, strides, self._rng)
        posterior = condition(points, groups, self._kernel)
        values = self._value(*posterior.predict(points), 0.0)
        if self._rng.random() < self.settings.restart_probability:
            return self._leap(flat[leaping_points(values)])
        k = math.exp(self._rng.uniform(*EAGERNESS))
        centre = flat[int(np.argmin(values))]
        for _ in range(self.settings.generations):
            pool = self._mirror(centre + self._moves())
            centre = pool[int(np.argmin(self._value(*posterior.predict(self._cube(pool)), k)))]
        return centre

    def _groups(self, costs: Floats, chosen: NDArray[np.intp]) -> list[Group]:
        """What some flights say: the gates of each segment, or the cost as a whole."""
        if self._gate_segments:
            return gate_groups(np.array(self._misses)[chosen], np.array(self._gate_segments))
        return [Group(None, np.arange(1), np.arange(len(chosen)), costs[chosen, None])]

    def _value(self, means: Floats, deviations: Floats, noises: Floats, k: float) -> Floats:
        """What candidates are worth, less is better, shape (m,): about -log of the chance to pass all gates, lowered by k deviations.

        Args:
            means: of the gates' misses, or of the cost, shape (m, M).
            deviations: likewise.
            noises: shape (M,).
            k: how much is hoped for.
        """
        if not self._gate_segments:
            return (means - k * deviations)[:, 0]
        steepness = PROBIT / np.hypot(noises, SPARE)
        exponents = steepness * (means + SPARE)
        slopes = steepness / (1 + np.exp(-exponents))
        return np.logaddexp(0, exponents).sum(axis=1) - k * np.linalg.norm(slopes * deviations, axis=1)

    def _moves(self) -> Floats:
        """Steps of all sizes, half of them along some axes only, some in a range of segments alone, shape (`POOL`, S K)."""
        segments, size = self._shape_of_parameters
        sizes = self.settings.step * np.exp(self._rng.uniform(*STEP_SIZES, (POOL, 1)))
        steps = self._cube(sizes * self._steps(POOL))
        some = (self._rng.random((POOL, 1)) < 0.5) & (self._rng.random((POOL, size)) < 0.5)
        steps = np.where(some[:, None], 0.0, steps)
        ends = np.sort(self._rng.integers(segments, size=(POOL, 2)), axis=1)
        within = (np.arange(segments) >= ends[:, :1]) & (np.arange(segments) <= ends[:, 1:])
        moved = within | (self._rng.random((POOL, 1)) >= self.settings.parted)
        return np.where(moved[:, :, None], steps, 0.0).reshape(POOL, -1)

    def _cube(self, points: Floats) -> Floats:
        """Points of shape (n, S K) as (n, S, K)."""
        return points.reshape(-1, *self._shape_of_parameters)
