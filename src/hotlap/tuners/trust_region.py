"""TuRBO-1: Bayesian optimisation in one trust region (Eriksson, Pearce, Gardner, Turner, Poloczek, NeurIPS 2019).

The trust region is a box around the best point, longer along axes of longer length scale; its sides double after successes and halve
after failures. The next flight is the candidate in the box at which a function drawn from a Gaussian process is lowest (Thompson
sampling). When the box is too small, the search restarts from new points. Parameters are scaled to a unit box, of logarithms or of
their own units.

Differs from the released code: the centre is the point of lowest posterior mean, as in the paper for noisy costs; a function is
drawn by Matheron's rule and without noise; the kernel is fitted again every `REFIT` flights, beginning at the last one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters, ParameterSpace
from hotlap.core.records import Scores
from hotlap.tuners.surrogates.gaussian_process import Kernel, climb
from hotlap.tuners.surrogates.posterior_paths import draw_paths
from hotlap.tuners.unit_box import UnitBox, latin_hypercube

Floats = NDArray[np.float64]

FIRST_SIDE, LEAST_SIDE, LARGEST_SIDE = 0.8, 2**-7, 1.6  # L_init, L_min, L_max
SUCCESSES = 3  # consecutive ones, after which the sides double
LEAST_FAILURES = 4  # consecutive flights, or as many as axes if these are more, after which the sides halve
GAIN = 1e-3  # share of the best cost by which a success must be lower
FIRST_LENGTH, FIRST_NOISE = 0.5, 0.005  # where the ascent of the likelihood begins
LENGTHS, NOISES = (0.005, 2.0), (5e-4, 0.2)  # bounds of the likelihood's ascent, in the unit box: released code
REFIT = 5  # flights between fits of the kernel
CANDIDATES = (100, 5000)  # number for each axis, and largest number; rounded down to a power of two
MOVED = 20  # mean number of axes along which a candidate differs from the centre
LEAST_INITIAL = 10
MEMORY = 300  # points that the process is fitted to
WORST = 1e12  # limit of a cost, of either sign


@dataclass(frozen=True)
class TrustRegionSettings:
    """Settings of the search.

    Attributes:
        initial: space-filling points for each axis, in all at least `LEAST_INITIAL`, before the process is used. The released code
            recommends 2; with 35 axes that would be a third of 200 flights, hence 1.
        batch: largest number of flights that are drawn at once.
        log: whether the unit box is one of logarithms; else of the parameters' own units.
        tied: one set of parameters for all segments.
        dense: use the dense cost, else the metric.
    """

    initial: float = 1.0
    batch: int = 1
    log: bool = True
    tied: bool = False
    dense: bool = False


PRESETS: Mapping[str, TrustRegionSettings] = {
    "default": TrustRegionSettings(),
    "raw": TrustRegionSettings(log=False),
    "dense": TrustRegionSettings(dense=True),
    "tied": TrustRegionSettings(tied=True),
}


class TrustRegion:
    """One trust region after the other. An ask gives the points to be flown, the same until their scores are reported."""

    def __init__(self, name: str, settings: TrustRegionSettings) -> None:
        self.name, self.settings = name, settings

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Begin with the first guess and space-filling points."""
        self._rng, self._box = rng, UnitBox(space, first_guess.shape, self.settings.log, self.settings.tied)
        self._first, self._flown = space.clip(first_guess), 0
        guess = self._box.encode(self._first)
        self._size = len(guess)
        self._begin(guess[None])

    def ask(self, n: int) -> Parameters:
        """At most n points that are to be flown, shape (1 to n, S, K); the first one is the first guess."""
        if not len(self._waiting):
            self._waiting = self._draw(min(n, self.settings.batch))
        parameters = self._box.decode(self._waiting[:n])
        if self._flown == 0:
            parameters[0] = self._first  # without the rounding of the unit box
        return parameters

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:
        """Store points and costs, and adjust the box; True where a flight has the lowest cost of this box so far."""
        costs = np.nan_to_num(np.clip(scores.dense if self.settings.dense else scores.cost, -WORST, WORST), nan=WORST)
        count, before = len(parameters), self._costs
        reported, self._waiting = self._waiting[:count], self._waiting[count:]
        self._points, self._costs = np.vstack([self._points, reported]), np.append(before, costs)
        self._flown += count
        if len(self._costs) > self._initial:
            self._adjust(float(before.min()), costs)
        known = np.minimum.accumulate(np.append(before.min(initial=np.inf), costs))
        return np.asarray((costs <= known[:-1]) & (costs < WORST), dtype=np.bool_)

    def state(self) -> dict[str, Any]:
        """Flights of this box, points to be flown, size and counts of the box, and the random generator."""
        kernel = self._kernel
        return {
            "points": self._points.tolist(),
            "costs": self._costs.tolist(),
            "waiting": self._waiting.tolist(),
            "side": self._side,
            "counts": [self._flown, self._initial, self._successes, self._failures, self._fitted],
            "kernel": None if kernel is None else [np.asarray(kernel.lengths).tolist(), kernel.noise],
            "rng": self._rng.bit_generator.state,
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from a `state()`."""
        self._points, self._waiting = (np.array(state[name], dtype=np.float64).reshape(-1, self._size) for name in ("points", "waiting"))
        self._costs, self._side = np.array(state["costs"], dtype=np.float64), state["side"]
        self._flown, self._initial, self._successes, self._failures, self._fitted = state["counts"]
        self._kernel = None if state["kernel"] is None else Kernel(np.array(state["kernel"][0]), state["kernel"][1])
        self._rng.bit_generator.state = state["rng"]

    def _begin(self, points: Floats) -> None:
        """A new box without flights; given points and space-filling ones are to be flown."""
        filling = latin_hypercube(max(LEAST_INITIAL, round(self.settings.initial * self._size)), self._size, self._rng)
        self._waiting: Floats = np.vstack([points, filling])
        self._initial = len(self._waiting)
        self._points, self._costs = np.empty((0, self._size)), np.empty(0)
        self._side, self._successes, self._failures = FIRST_SIDE, 0, 0
        self._kernel: Kernel | None = None
        self._fitted = 0

    def _adjust(self, best: float, costs: Floats) -> None:
        """Count successes (batches that lower the best cost) and failures (flights of other batches): tau_fail = max(4, d) / q batches."""
        if costs.min() < best - GAIN * abs(best):
            self._successes, self._failures = self._successes + 1, 0
        else:
            self._successes, self._failures = 0, self._failures + len(costs)
        if self._successes == SUCCESSES:
            self._side, self._successes = min(2 * self._side, LARGEST_SIDE), 0
        elif self._failures >= max(LEAST_FAILURES, self._size):
            self._side, self._failures = self._side / 2, 0
        if self._side < LEAST_SIDE:
            self._begin(np.empty((0, self._size)))

    def _draw(self, count: int) -> Floats:
        """For each of `count` functions drawn from the posterior the candidate where it is lowest, none twice, shape (count, d)."""
        points, costs = self._remembered()
        if self._kernel is None or len(self._costs) - self._fitted >= REFIT:
            start = self._kernel or Kernel(FIRST_LENGTH, FIRST_NOISE)
            self._kernel, self._fitted = climb(points, costs, start, LENGTHS, NOISES), len(self._costs)
        posterior = self._kernel.condition(points, costs)
        centre = points[int(np.argmin(posterior.predict(points)[0]))]
        candidates = self._candidates(centre, np.asarray(self._kernel.lengths))
        values = draw_paths(posterior, self._kernel.noise, count, self._rng).at(candidates)
        chosen = []
        for drawn in values.T:
            chosen.append(int(np.argmin(drawn)))
            values[chosen[-1]] = np.inf
        return candidates[chosen]

    def _candidates(self, centre: Floats, lengths: Floats) -> Floats:
        """Space-filling points of the box; with more than `MOVED` axes each equals the centre along some of them. Shape (count, d)."""
        sides = self._side * lengths / np.exp(np.log(lengths).mean())  # L_i = lambda_i L / (prod lambda_j)^(1/d), Sec. 2
        low, high = np.clip(centre - sides / 2, 0, 1), np.clip(centre + sides / 2, 0, 1)
        per_axis, most = CANDIDATES
        points = low + (high - low) * shifted_sobol(min(per_axis * self._size, most), self._size, self._rng)
        moved = self._rng.random(points.shape) < MOVED / self._size
        moved[np.arange(len(points)), self._rng.integers(self._size, size=len(points))] |= ~moved.any(axis=1)
        return np.where(moved, points, centre)

    def _remembered(self) -> tuple[Floats, Floats]:
        """At most `MEMORY` points and costs to fit, half the best, half the latest; costs at `WORST` are lowered to above the others."""
        latest = np.arange(max(0, len(self._costs) - MEMORY // 2), len(self._costs))
        chosen = np.union1d(np.argsort(self._costs, kind="stable")[: MEMORY // 2], latest)
        costs = self._costs[chosen]
        proper = costs[costs < WORST]
        worst = float(proper.max() + (proper.std() or 1.0)) if len(proper) else WORST
        return self._points[chosen], np.minimum(costs, worst)


def shifted_sobol(count: int, size: int, rng: np.random.Generator) -> Floats:
    """Sobol points in the unit box, shifted at random modulo 1 (Cranley, Patterson, 1976), `count` rounded down to a power of two."""
    from scipy.stats.qmc import Sobol  # noqa: PLC0415  it loads scipy.stats

    points = Sobol(size, scramble=False).random_base2(int(np.log2(count)))
    return np.asarray((points + rng.random(size)) % 1.0, dtype=np.float64)
