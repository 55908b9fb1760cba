"""Safe Bayesian optimisation, for tuning on hardware: only parameters whose lower confidence bound is above a safety limit are flown.

SafeOpt: Sui, Gotovos, Burdick, Krause, ICML 2015; without a Lipschitz constant and for quadrotors: Berkenkamp, Schoellig, Krause,
ICRA 2016. Search along one line after another in many dimensions: LineBO, Kirschner and others, ICML 2019.

The performance is J = -log(1 + dense cost); the safety limit J_min, called the floor, is the mean performance of the first guess minus a
tolerance. The performance without noise stays above it with confidence beta if the prior is right; the noisy performance of a single
flight can fall below it, also with the first guess.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters, ParameterSpace
from hotlap.core.records import Scores
from hotlap.tuners.subspace import SPACING, Direction, Lattice, axes_of, draw_direction
from hotlap.tuners.surrogates.gaussian_process import Posterior, Prior

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

DEPTH = 2.0  # in standard deviations of the signal: performances further below the floor are raised to this depth
PRIOR = Prior(length=2.0, signal=2.0, noise=0.7)  # the likeliest for flights on ten random tracks, along lines through the default
WORST = -800.0  # performance of a flight without a finite cost; that of the largest float is -710


@dataclass(frozen=True)
class SafeBayesianSettings:
    """Settings of the search; lengths are in units of `log_step`, performances in natural logarithms.

    Attributes:
        subspace: directions that are searched together, if the controller has such parameters; without any, random lines in all axes.
        line: number of flights on a line.
        tolerance: ratio of 1 + dense cost at the floor to that of the first guess.
        baseline: least number of flights of the first guess, from which floor and noise are estimated.
        beta: standard deviations from the mean to the confidence bounds, beta^(1/2) in the papers.
        prior: Gaussian process of the performance before flights; its noise is a lower limit of the one estimated from the baseline.
        optimistic: fly the point of highest upper bound in the safe set; else the most uncertain of its maximisers and expanders.
        dense: use the dense cost, else the metric.
    """

    subspace: tuple[Direction, ...] = (Direction.GAIN, Direction.HORIZON)
    line: int = 8
    tolerance: float = 3.0
    baseline: int = 5
    beta: float = 2.0  # Berkenkamp and others, 2016
    prior: Prior = PRIOR
    optimistic: bool = False
    dense: bool = True


PRESETS: Mapping[str, SafeBayesianSettings] = {
    "plane": SafeBayesianSettings(optimistic=True),
    "safeopt": SafeBayesianSettings(),
    "damping": SafeBayesianSettings(subspace=(Direction.GAIN, Direction.DAMPING), optimistic=True),
    "lines": SafeBayesianSettings(subspace=(), optimistic=True),
    "lines_safeopt": SafeBayesianSettings(subspace=()),
}


class SafeBayesian:
    """Flies the first guess, then safe parameters only. Each `ask` gives one proposal, the same one until its score is reported.

    If the first guess crashes (no finite cost, or no gate passed), no safe set is known. Then the search takes the smallest steps from
    the best flight so far, without safety, until a flight passes a gate: its parameters replace the first guess.
    """

    def __init__(self, name: str, settings: SafeBayesianSettings) -> None:
        self.name, self.settings = name, settings

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Begin at the first guess; a point, shape (K,), is the offset from it, the same in all segments."""
        self._space, self._rng = space, rng
        self._first = space.clip(first_guess)
        self._low = ((np.log(space.low) - np.log(self._first)) / space.log_step).min(axis=0)
        self._high = ((np.log(space.high) - np.log(self._first)) / space.log_step).max(axis=0)
        turned = axes_of(self.settings.subspace, space.names)
        self._lines = len(turned) == 0
        self._axes = np.eye(space.size) if self._lines else turned
        self._points: list[list[float]] = []
        self._performances: list[float] = []
        self._crashed: list[bool] = []
        self._proposal: Floats | None = np.zeros(space.size)
        self._lattice = self._lay(self._proposal)
        self._left = 0  # flights left on the line

    def ask(self, n: int) -> Parameters:  # noqa: ARG002  one at a time: every flight changes the safe set
        """The proposal, shape (1, S, K), whatever n; the first one is the first guess."""
        if self._proposal is None:
            self._proposal = self._propose()
        return self._decode(self._proposal)[None]

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:  # noqa: ARG002  they are the proposal's
        """Store point and performance; True where the flight has the highest performance so far."""
        [cost], [completion] = (scores.dense if self.settings.dense else scores.cost).tolist(), scores.completion.tolist()
        performance = -math.log1p(max(cost, 0.0)) if math.isfinite(cost) else WORST
        better = performance >= max(self._performances, default=WORST)
        assert self._proposal is not None, "nothing was asked for"  # noqa: S101  our own mistake
        self._points.append(self._proposal.tolist())
        self._performances.append(performance)
        self._crashed.append(performance == WORST or completion <= 0.0)
        self._proposal = None
        return np.array([better])

    def state(self) -> dict[str, Any]:
        """All flights, the lattice, the current proposal and the random generator; also the number of violations, for the reader."""
        return {
            "points": [list(point) for point in self._points],
            "performances": list(self._performances),
            "crashed": list(self._crashed),
            "proposal": None if self._proposal is None else self._proposal.tolist(),
            "lattice": {name: value.tolist() for name, value in asdict(self._lattice).items()},
            "left": self._left,
            "violations": self.violations,
            "rng": self._rng.bit_generator.state,
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from a `state()`."""
        self._points = [list(point) for point in state["points"]]
        self._performances, self._crashed = list(state["performances"]), list(state["crashed"])
        self._proposal = None if state["proposal"] is None else np.array(state["proposal"])
        self._lattice = Lattice(**{name: np.array(value) for name, value in state["lattice"].items()})
        self._left = state["left"]
        self._rng.bit_generator.state = state["rng"]

    @property
    def floor(self) -> float:
        """J_min: mean performance of the first guess minus log(tolerance); minus infinity as long as all flights have crashed."""
        return -math.inf if all(self._crashed) else float(self._baseline().mean()) - math.log(self.settings.tolerance)

    @property
    def violations(self) -> int:
        """Number of flights below the floor, including those of the first guess."""
        return int((np.array(self._performances) < self.floor).sum())

    def report(self) -> str:
        """The number of violations, as a sentence."""
        flights = len(self._performances)
        if all(self._crashed):
            return f"no safe parameters are known: all of {flights} flights crashed"
        level, own = math.expm1(min(-self.floor, 700.0)), self._baseline()
        known = f"{int((own < self.floor).sum())} of {len(own)} with the first guess itself"
        return f"{self.violations} of {flights} flights below the floor, which is a cost of {level:.3g}; {known}"

    def _anchor(self) -> list[float]:
        """The initial safe set S_0: the point of the first flight without a crash."""
        return self._points[self._crashed.index(False)]

    def _baseline(self) -> Floats:
        """Performances of the flights at S_0 that did not crash, shape (n,)."""
        anchor, flights = self._anchor(), zip(self._points, self._performances, self._crashed, strict=True)
        return np.array([performance for point, performance, crashed in flights if point == anchor and not crashed])

    def _propose(self) -> Floats:
        """The next point, shape (K,)."""
        if all(self._crashed):
            return self._smallest_step()
        if self._points.count(self._anchor()) < self.settings.baseline:
            return np.array(self._anchor())
        posterior = self._posterior()
        if self._lines:
            self._follow_line(posterior)
        points = np.vstack([self._anchor(), self._lattice.points(self._low, self._high)])
        return points[choose(posterior, points, self.floor, self.settings)]

    def _smallest_step(self) -> Floats:
        """A step of one spacing, in a random direction, from the best flight; of equally good ones the latest."""
        best = max(range(len(self._points)), key=lambda i: (self._performances[i], i))
        return np.clip(self._points[best] + SPACING * draw_direction(self._axes, self._rng)[0], self._low, self._high)

    def _posterior(self) -> Posterior:
        """The process of the performance given all flights; its prior mean is the floor."""
        prior, noise = self.settings.prior, float(self._baseline().std())
        values = np.maximum(self._performances, self.floor - DEPTH * prior.signal)
        return replace(prior, noise=max(prior.noise, noise)).condition(np.array(self._points), values, self.floor)

    def _follow_line(self, posterior: Posterior) -> None:
        """Count the flights on a line; after the last one, choose the next line through the flight of highest lower bound."""
        if self._left == 0:
            flown = np.array(self._points)
            mean, deviation = posterior.predict(flown)
            self._lattice = self._lay(flown[int(np.argmax(mean - self.settings.beta * deviation))])
            self._left = self.settings.line
        self._left -= 1

    def _lay(self, origin: Floats) -> Lattice:
        """A lattice through a point: along the subspace, or along a random line."""
        axes = draw_direction(self._axes, self._rng) if self._lines else self._axes
        return Lattice(origin, axes, SPACING * self._rng.random(len(axes)))

    def _decode(self, point: Floats) -> Parameters:
        """Parameters at a point, shape (S, K); exactly the first guess where the offset is 0."""
        moved = self._space.clip(np.exp(np.log(self._first) + point * self._space.log_step))
        return np.where(point == 0.0, self._first, moved)


def choose(posterior: Posterior, points: Floats, floor: float, settings: SafeBayesianSettings) -> int:
    """Index of the next point, which lies in the safe set S_n = {l_n >= J_min}; the first point always counts as safe.

    SafeOpt takes the widest bounds of the maximisers M_n = {u_n >= max l_n} and the expanders G_n (Berkenkamp and others, Sec. IV).
    """
    mean, deviation = posterior.predict(points)
    lower, upper = mean - settings.beta * deviation, mean + settings.beta * deviation  # Q_n = [l_n, u_n]
    safe = lower >= floor
    safe[0] = True
    if settings.optimistic:
        return int(np.argmax(np.where(safe, upper, -np.inf)))
    useful = safe & (upper >= lower[safe].max())
    rivals = np.flatnonzero(safe & ~useful & (deviation > deviation[useful].max()))
    useful[rivals] = expanders(posterior, points[rivals], points[~safe], floor, settings.beta)
    return int(np.argmax(np.where(useful, deviation, -np.inf)))


def expanders(posterior: Posterior, points: Floats, unsafe: Floats, floor: float, beta: float) -> Flags:
    """Whether a performance at a point equal to its upper bound would make an unsafe point safe: g_n > 0, shape (m,).

    Differs from the authors' code: the assumed performance u_n has no noise, since u_n is a bound of the performance without noise.

    Args:
        posterior: process of the performance.
        points: shape (m, K).
        unsafe: shape (n, K).
        floor: J_min.
        beta: number of standard deviations between mean and bound.
    """
    deviation = posterior.predict(points)[1]
    mean, old = posterior.predict(unsafe)
    gain = posterior.covariance(unsafe, points) / deviation  # standard deviations of f at `unsafe` that one at `points` explains
    spread = np.sqrt(np.maximum(old[:, None] ** 2 - gain**2, 0.0))
    return np.asarray((mean[:, None] + beta * gain - beta * spread >= floor).any(axis=0), dtype=np.bool_)
