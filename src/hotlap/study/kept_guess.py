"""Kept guess: what a search ends with that held already when it began, so that nothing was changed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hotlap.core.finite import finite
from hotlap.core.shown import Shown
from hotlap.study.configuration import Configuration
from hotlap.study.result import Result

FIRST, DEFAULT = "first guess", "default weights"
HELD: Mapping[str, str] = {FIRST: "holds already: kept as it is", DEFAULT: "hold already: kept as they are"}


@dataclass(frozen=True, repr=False)
class KeptGuess(Shown):
    """The parameters that a search began with, where they are its result.

    Attributes:
        guess: what they are: `FIRST` or `DEFAULT`.
        mean_error: [m] of their flights that pass every gate, from the reference; NaN where it is not known.
        default_mean_error: [m] the same of the default weights, with the same noise; NaN likewise.
    """

    guess: str
    mean_error: float = math.nan
    default_mean_error: float = math.nan

    @property
    def words(self) -> str:
        """In a line."""
        return f"{self.held}; mean error {self.errors}" if self.errors else self.held

    @property
    def held(self) -> str:
        """What was kept."""
        return f"the {self.guess} {HELD[self.guess]}"

    @property
    def errors(self) -> str:
        """Both mean errors; "" where one is not known."""
        if math.isnan(self.mean_error) or math.isnan(self.default_mean_error):
            return ""
        return f"{self.mean_error:.2g} m, that of the default weights {self.default_mean_error:.2g} m"

    def dump(self) -> dict[str, Any]:
        """As plain JSON, which has no NaN."""
        return finite({"guess": self.guess, "mean_error": self.mean_error, "default_mean_error": self.default_mean_error})


def find_kept_guess(configuration: Configuration, result: Result | None, errors: Mapping[str, float] | None = None) -> KeptGuess | None:
    """The guess that a search kept; None where it has changed something, or its result does not hold.

    Args:
        configuration: of the study.
        result: of its search.
        errors: [m] mean errors of flights that pass every gate, by what was flown: "tuned" and "default"; None: nothing is known.
    """
    if result is None or not result.best.confirmed:
        return None
    best, first = result.best.parameters, configuration.first_guess
    default, errors = configuration.scenario.space.first_guess(len(first)), errors or {}
    if np.array_equal(best, default):
        return KeptGuess(DEFAULT)
    if not np.array_equal(best, first):
        return None
    return KeptGuess(FIRST, errors.get("tuned", math.nan), errors.get("default", math.nan))
