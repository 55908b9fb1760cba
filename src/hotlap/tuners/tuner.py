"""Tuner: the protocol of all tuning algorithms: `ask` gives the parameters to fly next, `tell` reports the scores of these flights."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters, ParameterSpace
from hotlap.core.records import Scores


class Tuner(Protocol):
    """One run of an algorithm: `start`, then `ask` and `tell` in turn.

    The first parameters that a tuner asks for are the first guess itself. All parameters that it asks for lie within the bounds.
    A cost that is not finite counts as worse than any finite cost.

    Attributes:
        name: algorithm and preset, as `tuners.build` takes it.
        settings: frozen dataclass of numbers, booleans, strings and tuples of these.

    A tuner with the attribute `learns_from_any = True` accepts scores of any parameters in `tell`, also of parameters that it did not ask
    for.
    """

    name: str
    settings: Any

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Begin a run.

        Args:
            first_guess: shape (S, K).
            space: what can be tuned.
            rng: the only random generator that the tuner uses; nobody else uses it from now on.
        """
        ...

    def ask(self, n: int) -> Parameters:
        """Parameters to fly next, shape (B, S, K), 1 <= B <= n: as many as the algorithm can evaluate at the same time."""
        ...

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:
        """Report the scores of the parameters of the last `ask`, in its order.

        Returns:
            Shape (B,), True where the tuner accepts the parameters as better, or as the next sample of a chain.
        """
        ...

    def state(self) -> dict[str, Any]:
        """Everything that later proposals depend on, the state of the random generator included, as plain JSON."""
        ...

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from a `state()`, bit for bit; the tuner has been started with the same first guess and space."""
        ...


def remark_of(tuner: Tuner) -> str:
    """A tuner's own remark about its run: the text of its method `report`, empty where it has none."""
    report = getattr(tuner, "report", None)
    return "" if report is None else str(report())


def asked_together(tuner: Tuner, count: int) -> Parameters:
    """Parameters to fly next from a tuner that makes many proposals of one model, shape (B, S, K), B at most `count`.

    They come from its method `ask_together(count)`, or from `ask` where it has none.
    """
    return getattr(tuner, "ask_together", tuner.ask)(count)


def recommended_by(tuner: Tuner, count: int, rng: np.random.Generator) -> Parameters:
    """Parameters that a tuner expects to succeed most often by all that it was told, the best first, shape (n, S, K), n at most `count`.

    They come from its method `recommend(count, rng)`, which changes nothing in the tuner; of a tuner without one there are none.

    Args:
        tuner: that has been told of flights.
        count: most of them.
        rng: for it alone.
    """
    recommend = getattr(tuner, "recommend", None)
    return np.empty((0, 0, 0)) if recommend is None else recommend(count, rng)
