"""Tuner: the protocol that every tuning algorithm answers to: ask for parameters, tell what they were worth."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters, ParameterSpace
from hotlap.core.records import Scores


class Tuner(Protocol):
    """One run of an algorithm: `start`, then `ask` and `tell` in turn.

    The first parameters that a tuner asks for are the first guess itself. All that it asks for lies within the bounds.
    A cost that is not finite is the worst there is.

    Attributes:
        name: algorithm and preset, as `tuners.build` takes it.
        settings: frozen dataclass of plain values.

    A tuner may say `learns_from_any = True`: `tell` takes any parameters in any number, also such as it did not ask for.
    """

    name: str
    settings: Any

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Begin a run.

        Args:
            first_guess: shape (S, K).
            space: what can be tuned.
            rng: the only source of chance; the tuner's own from now on.
        """
        ...

    def ask(self, n: int) -> Parameters:
        """Parameters to fly next, shape (B, S, K), with 1 <= B <= n: as many as the algorithm can use at once."""
        ...

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:
        """What the parameters of the last `ask` were worth, in its order.

        Returns:
            Shape (B,), which of them the tuner goes on from.
        """
        ...

    def state(self) -> dict[str, Any]:
        """Everything that the run's future depends on, the random generator included, as plain JSON."""
        ...

    def restore(self, state: dict[str, Any]) -> None:
        """Go on where `state()` was taken, bit for bit; the tuner has been started with the same first guess and space."""
        ...


def remark_of(tuner: Tuner) -> str:
    """What a tuner has to say of its run: of its method `report`, if it has one."""
    report = getattr(tuner, "report", None)
    return "" if report is None else str(report())
