"""GateGp: the default tuner, a random walk guided by one Gaussian process for the miss at each gate.

1. The cost is a sum over the gates, so each gate has a process of its own (composite Bayesian optimisation: Astudillo, Frazier, ICML 2019),
   a function of the parameters of its own and of earlier segments (`surrogates.gate_process`). Flights with the same parameters in all
   segments already show which parameters each gate needs; a proposal with different segments is made when it is predicted to be better.
2. The acquisition function is a lower confidence bound, mean - k sd, of about -log of the probability to pass all gates. Candidates are
   Gaussian steps in logarithms around the flown point that is predicted to be best; most are the same in all segments, the others move a
   range of segments only. The best candidate is the centre of the next generation; the best of the last generation is flown. k is drawn
   anew for each flight.
3. A gate counts as passed only with `MARGIN` to spare, because the noise of the next flight is different.
4. With `restart_probability` a proposal is a step from another good point; with a probability that begins at `exploration` and falls, it is
   drawn uniformly within the bounds: the first guess, or a local minimum, may be far from all parameters that pass the gates.

A cost without gates has one process, of the parameters of all segments.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters, ParameterSpace
from hotlap.core.records import Scores
from hotlap.tuners.surrogates.gate_ensemble import GateEnsemble, Processes, climb, values_of
from hotlap.tuners.surrogates.gate_process import GateKernel, Group, climb_at_random, condition, gate_groups
from hotlap.tuners.surrogates.threads import one_thread
from hotlap.tuners.walk import Walk, WalkSettings, fitted, restart_points

Floats = NDArray[np.float64]

POOL = 300  # candidates of a generation
THRIFTY_POOL = 64  # likewise, of the thrifty form
REMEMBERED = 100  # flights that its processes are conditioned on, and up to `RENEWED` more
RENEWED = 10  # flights between two choices of these
LIKELIEST = 60  # latest of these that enter the likelihood
ROWS_AT_ONCE = 256  # points whose predictions are made at once
THRIFTY_STRIDES = 30  # steps of its random search for the kernel, made when the number of flights has doubled
REFIT = 5  # flights between updates of the kernel; an update is left out where the proposal is drawn uniformly
STRIDES = (20, 6)  # steps of the random search for the kernel: of the first update, and of the later ones
STEP_SIZES = (math.log(0.1), math.log(1.5))  # range of the logarithm of a candidate's step size, in units of `step`
CONFIDENCE = (math.log(0.3), math.log(3.0))  # range of log k of the lower confidence bound
HALF_EXPLORATION, LEAST_EXPLORATION = 20, 0.25  # flights after which the probability of exploration is half; its least share
MARGIN = 0.15  # by which log(D / d) must be below 0 for a gate to count as passed; also the standard deviation of the model's own error
PROBIT = 1.7  # softplus(1.7 z) is close to -log of the probability that a standard normal variable is larger than z


@dataclass(frozen=True)
class GateGpSettings(WalkSettings):
    """Settings of the default tuner.

    Attributes:
        generations: generations of candidates before each flight.
        parted: share of the candidates that move a range of segments only.
        gates: whether each gate has a process; else one process of the cost.
        thrifty: think little between two flights: the kernel is searched for when the number of flights has doubled, the processes see
            about a hundred flights, the best and the latest, and are brought up to date flight by flight. Published results were
            measured without.
    """

    restart_probability: float = 0.1
    exploration: float = 0.4
    generations: int = 3
    parted: float = 0.33
    gates: bool = True
    thrifty: bool = False


PRESETS: Mapping[str, GateGpSettings] = {
    "default": GateGpSettings(thrifty=True),
    "published": GateGpSettings(),
    "whole": GateGpSettings(gates=False),
    "one_generation": GateGpSettings(generations=1),
    "tied": GateGpSettings(parted=0.0),
    "no_restarts": GateGpSettings(restart_probability=0.0, exploration=0.0),
    "no_exploration": GateGpSettings(exploration=0.0),
}


@dataclass(frozen=True)
class Known:
    """What the thrifty form has learnt from flights.

    Attributes:
        base: number of flights at which those that are remembered were chosen.
        until: number of flights that were known.
        points: that are remembered, shape (n, S K).
        ensemble: the processes given these.
    """

    base: int
    until: int
    points: Floats
    ensemble: GateEnsemble


class GateGp(Walk[GateGpSettings]):
    """A random walk guided by a Gaussian process for each gate."""

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Begin at the first guess."""
        super().start(first_guess, space, rng)
        self._misses: list[list[float | None]] = []
        self._gate_segments: list[int] = []
        self._kernel: GateKernel | None = None
        self._searched_at = 0
        self._known: Known | None = None

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:
        """Store points, costs and misses; True where a flight has the lowest cost so far."""
        if self.settings.gates:
            self._misses += [[miss if math.isfinite(miss) else None for miss in flight] for flight in scores.gate_miss.tolist()]
            self._gate_segments = scores.gate_segment[0].tolist()
        return super().tell(parameters, scores)

    def state(self) -> dict[str, Any]:
        """All flights, the kernel, the current proposal and the random generator."""
        return {
            **super().state(),
            "misses": list(self._misses),  # JSON has no NaN
            "gate_segments": self._gate_segments,
            "kernel": None if self._kernel is None else self._kernel.numbers.tolist(),
            "searched_at": self._searched_at,
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from a `state()`."""
        super().restore(state)
        self._misses = [list(flight) for flight in state["misses"]]
        self._gate_segments = list(state["gate_segments"])
        self._kernel = None if state["kernel"] is None else GateKernel(np.array(state["kernel"]))
        self._searched_at = state.get("searched_at", len(self._points))
        self._known = None

    def recommend(self, count: int, rng: np.random.Generator) -> Parameters:
        """Parameters that the processes expect to pass all gates most often, the best first, shape (n, S, K), n at most `count`.

        Half of them were flown; the others are the best of their neighbourhood. Only the thrifty form recommends anything.
        """
        if not self.settings.thrifty or self._kernel is None:
            return np.empty((0, *self._shape_of_parameters))
        with one_thread():
            ensemble = self._condition(self._finite_costs(), search=False).ensemble
            flown = np.array(self._points)
            parts = range(0, len(flown), ROWS_AT_ONCE)
            values = [self._acquisition(*ensemble.predict(self._cube(flown[i : i + ROWS_AT_ONCE])), 0.0) for i in parts]
            best = flown[np.argsort(np.concatenate(values), kind="stable")[: count - count // 2]]
            near = [self._neighbour(centre, ensemble, rng) for centre in best[: count // 2]]
        mixed = np.array([point for pair in zip(best, near, strict=False) for point in pair] + list(best[len(near) :]))
        return np.array([self._decode(point) for point in mixed])

    def _neighbour(self, centre: Floats, ensemble: GateEnsemble, rng: np.random.Generator) -> Floats:
        """The best of some generations of candidates around a point, shape (S K,)."""
        for _ in range(self.settings.generations):
            pool = np.vstack([centre, self._mirror(centre + self._moves(THRIFTY_POOL, rng))])
            centre = pool[int(np.argmin(self._acquisition(*ensemble.predict(self._cube(pool)), 0.0)))]
        return centre

    def _exploration_probability(self, flown: int) -> float:
        """Probability of a uniformly drawn proposal: it falls, but not to 0, so that the walk leaves a region where no parameters pass."""
        return self.settings.exploration * max(LEAST_EXPLORATION, HALF_EXPLORATION / (HALF_EXPLORATION + flown))

    def _steps(self, count: int, rng: np.random.Generator | None = None) -> Floats:
        """Gaussian steps of unit size, the same in all segments, shape (count, S K)."""
        segments, size = self._shape_of_parameters
        return np.tile((rng or self._rng).standard_normal((count, size)), segments)

    def _propose(self, costs: Floats) -> Floats:
        """The best candidate of the last generation, or a restart; shape (S K,)."""
        if self.settings.thrifty:
            return self._propose_thriftily(costs)
        chosen = fitted(costs)
        flat = np.array(self._points)[chosen]
        points, groups = self._cube(flat), self._groups(costs, chosen)
        if self._kernel is None or len(costs) % REFIT == 0:
            first, later = STRIDES
            start, strides = (GateKernel.prior(points.shape[2]), first) if self._kernel is None else (self._kernel, later)
            self._kernel = climb_at_random(points, groups, start, strides, self._rng)
        posterior = condition(points, groups, self._kernel)
        values = self._acquisition(*posterior.predict(points), 0.0)
        if self._rng.random() < self.settings.restart_probability:
            return self._restart(flat[restart_points(values)])
        k = math.exp(self._rng.uniform(*CONFIDENCE))
        centre = flat[int(np.argmin(values))]
        for _ in range(self.settings.generations):
            pool = self._mirror(centre + self._moves())
            centre = pool[int(np.argmin(self._acquisition(*posterior.predict(self._cube(pool)), k)))]
        return centre

    def _propose_thriftily(self, costs: Floats) -> Floats:
        """The same with the processes of all gates computed together."""
        known = self._condition(costs)
        values = self._acquisition(*known.ensemble.predict(self._cube(known.points), means_only=True), 0.0)
        if self._rng.random() < self.settings.restart_probability:
            return self._restart(known.points[restart_points(values)])
        k = math.exp(self._rng.uniform(*CONFIDENCE))
        centre = known.points[int(np.argmin(values))]
        for _ in range(self.settings.generations):
            pool = self._mirror(centre + self._moves(THRIFTY_POOL))
            centre = pool[int(np.argmin(self._acquisition(*known.ensemble.predict(self._cube(pool)), k)))]
        return centre

    def _condition(self, costs: Floats, *, search: bool = True) -> Known:
        """The processes given the flights that are remembered.

        Which these are depends on the number of flights, and on that at which the kernel was searched for, but not on when they were asked
        for: an interrupted run has the same.

        Args:
            costs: of all flights, shape (n,).
            search: whether the kernel is searched for when it is time.
        """
        count, gates = len(costs), bool(self._gate_segments)
        processes = Processes.of_gates(np.array(self._gate_segments)) if gates else Processes.of_cost()
        if self._kernel is None or (search and count >= 2 * self._searched_at):
            latest = remembered(costs)[-LIKELIEST:]
            points, values = self._flown(latest), self._values(processes, costs, latest)
            start = GateKernel.prior(self._shape_of_parameters[1]) if self._kernel is None else self._kernel
            self._kernel = climb(processes, self._cube(points), *values, start, THRIFTY_STRIDES, self._rng)
            self._searched_at, self._known = count, None
        renewed = count // RENEWED * RENEWED if count > REMEMBERED else 0
        base = max(self._searched_at, renewed) if gates else count  # an infinite cost counts as more when a larger one has been seen
        known = self._known
        if known is None or known.base != base:
            chosen = remembered(costs[:base])
            points, values = self._flown(chosen), self._values(processes, costs, chosen)
            known = Known(base, base, points, GateEnsemble(processes, self._kernel, self._cube(points), *values))
        if known.until < count:
            fresh = range(known.until, count)
            known.ensemble.append(self._cube(self._flown(fresh)), *self._values(processes, costs, fresh))
            known = Known(base, count, np.vstack([known.points, self._flown(fresh)]), known.ensemble)
        self._known = known
        return known

    def _flown(self, chosen: Sequence[int]) -> Floats:
        """Points that were flown, shape (n, S K)."""
        return np.array([self._points[i] for i in chosen]).reshape(len(chosen), math.prod(self._shape_of_parameters))

    def _values(self, processes: Processes, costs: Floats, chosen: Sequence[int]) -> tuple[Floats, NDArray[np.bool_]]:
        """The misses of some flights, or their costs, and in which processes each flight counts."""
        if not self._gate_segments:
            return processes.spread(costs[list(chosen), None])
        return values_of(processes, self._missed(chosen))

    def _missed(self, chosen: Sequence[int]) -> Floats:
        """Misses of some flights, shape (n, M)."""
        return np.array([self._misses[i] for i in chosen], dtype=np.float64).reshape(len(chosen), len(self._gate_segments))

    def _groups(self, costs: Floats, chosen: NDArray[np.intp]) -> list[Group]:
        """The data of some flights: the misses at the gates of each segment, or the cost."""
        if self._gate_segments:
            return gate_groups(self._missed(chosen.tolist()), np.array(self._gate_segments))
        return [Group(None, np.arange(1), np.arange(len(chosen)), costs[chosen, None])]

    def _acquisition(self, means: Floats, deviations: Floats, noises: Floats, k: float) -> Floats:
        """Acquisition function of candidates, shape (m,), lower is better: about -log of the probability to pass all gates, less k sd.

        Without gates it is the lower confidence bound of the cost.

        Args:
            means: posterior means of the misses, or of the cost, shape (m, M).
            deviations: posterior standard deviations, shape (m, M).
            noises: standard deviations of the noise, shape (M,).
            k: number of standard deviations.
        """
        if not self._gate_segments:
            return (means - k * deviations)[:, 0]
        steepness = PROBIT / np.hypot(noises, MARGIN)
        exponents = steepness * (means + MARGIN)
        slopes = steepness / (1 + np.exp(-exponents))
        return np.logaddexp(0, exponents).sum(axis=1) - k * np.linalg.norm(slopes * deviations, axis=1)

    def _moves(self, count: int = POOL, rng: np.random.Generator | None = None) -> Floats:
        """Steps of random sizes, half of them along some axes only, a share `parted` in a range of segments only; shape (count, S K)."""
        (segments, size), rng = self._shape_of_parameters, rng or self._rng
        sizes = self.settings.step * np.exp(rng.uniform(*STEP_SIZES, (count, 1)))
        steps = self._cube(sizes * self._steps(count, rng))
        some = (rng.random((count, 1)) < 0.5) & (rng.random((count, size)) < 0.5)
        steps = np.where(some[:, None], 0.0, steps)
        ends = np.sort(rng.integers(segments, size=(count, 2)), axis=1)
        within = (np.arange(segments) >= ends[:, :1]) & (np.arange(segments) <= ends[:, 1:])
        moved = within | (rng.random((count, 1)) >= self.settings.parted)
        return np.where(moved[:, :, None], steps, 0.0).reshape(count, -1)

    def _cube(self, points: Floats) -> Floats:
        """Points of shape (n, S K) as (n, S, K)."""
        return points.reshape(-1, *self._shape_of_parameters)


def remembered(costs: Floats) -> list[int]:
    """Indices of the flights that the thrifty form remembers: at most `REMEMBERED`, half of them the best ones, half the latest.

    Args:
        costs: of all flights, shape (n,).
    """
    if len(costs) <= REMEMBERED:
        return list(range(len(costs)))
    best = np.argsort(costs, kind="stable")[: REMEMBERED // 2]
    return np.union1d(best, np.arange(len(costs) - REMEMBERED // 2, len(costs))).tolist()
