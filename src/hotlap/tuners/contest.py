"""Contest: a search that begins at the better of two guesses, which it flies in turn before anything else.

Its flights are flights of the search like all others: they count, and a guess that meets the goal in one of them is confirmed at once.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters, ParameterSpace
from hotlap.core.records import Scores
from hotlap.tuners.tuner import Tuner, asked_together, recommended_by

FLIGHTS = 3  # of each guess
WORST = 1e12  # a cost that is not finite counts as this


def beginning_at_better(tuner: Tuner, rival: Parameters | None) -> Tuner:
    """A tuner that begins at the better of its first guess and a rival, shape (S, K); the tuner itself where there is no rival."""
    return tuner if rival is None else Contest(tuner, rival)


class Contest:
    """A tuner that starts another one at its own first guess or at a rival, whichever has passed more gates in the mean, then by cost.

    Args:
        tuner: not yet started.
        rival: shape (S, K).
    """

    def __init__(self, tuner: Tuner, rival: Parameters) -> None:
        self.name, self.settings = tuner.name, tuner.settings
        self._tuner, self._rival = tuner, rival
        self._flown: list[tuple[float, float]] = []  # completion and cost, of the first guess and of the rival in turn
        self._decided = False

    @property
    def learns_from_any(self) -> bool:
        """Whether it accepts scores of parameters that it did not ask for."""
        return self._decided and bool(getattr(self._tuner, "learns_from_any", False))

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Begin with both guesses."""
        self._guesses, self._space, self._rng = (first_guess, self._rival), space, rng

    def ask(self, n: int) -> Parameters:
        """Both guesses in turn, or what the tuner asks for once they are flown."""
        if self._decided:
            return self._tuner.ask(n)
        first = len(self._flown)
        return np.array([self._guesses[k % 2] for k in range(first, min(first + n, 2 * FLIGHTS))])

    def ask_together(self, n: int) -> Parameters:
        """The same of a tuner that makes many proposals at once."""
        return asked_together(self._tuner, n) if self._decided else self.ask(n)

    def recommend(self, count: int, rng: np.random.Generator) -> Parameters:
        """What the tuner recommends, once it has begun."""
        return recommended_by(self._tuner, count, rng) if self._decided else np.empty((0, *self._rival.shape))

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:
        """Store how the guesses flew; after the last flight the tuner starts at the better one."""
        if self._decided:
            return self._tuner.tell(parameters, scores)
        costs = np.nan_to_num(scores.cost, nan=WORST, posinf=WORST)
        self._flown += zip(scores.completion.tolist(), costs.tolist(), strict=True)
        if len(self._flown) == 2 * FLIGHTS:
            self._begin()
        return np.zeros(len(parameters), dtype=np.bool_)

    def state(self) -> dict[str, Any]:
        """How the guesses flew, and the state of the tuner."""
        return {"flown": [list(one) for one in self._flown], "tuner": self._tuner.state() if self._decided else None}

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from a `state()`."""
        self._flown = [(completion, cost) for completion, cost in state["flown"]]
        if state["tuner"] is not None:
            self._begin()
            self._tuner.restore(state["tuner"])

    def report(self) -> str:
        """The tuner's own remark."""
        report = getattr(self._tuner, "report", None)
        return "" if report is None or not self._decided else str(report())

    def _begin(self) -> None:
        """Start the tuner at the guess that has flown better; the first where they are equal."""
        means = [np.mean(self._flown[k::2], axis=0) for k in range(2)]
        better = max(range(2), key=lambda k: (means[k][0], -means[k][1]))
        self._tuner.start(self._guesses[better], self._space, self._rng)
        self._decided = True
