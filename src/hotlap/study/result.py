"""Result: the best parameters of a tuning, with the flights that it took."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from hotlap.core.shown import Shown
from hotlap.core.success_rate import Validation
from hotlap.tuning.candidate import Candidate


@dataclass(frozen=True, repr=False)
class Result(Shown):
    """The result of a run, final or so far.

    Attributes:
        race: its name.
        tuner: name with preset.
        goal: as it was asked for.
        seed: of the run.
        flights: re-flights included, selection and validation not.
        search_flights: without re-flights, up to the confirmed candidate.
        best: the parameters found, with the means over the flights that found and confirmed them.
        validation: of these parameters; None if none was asked for.
        validation_flights: of all validations, also of candidates before it whose validation failed.
        remark: of the tuner on its run, for example the number of flights below a safety limit; "" for most.
        selection_flights: by which the parameters were chosen, where the search confirmed none.
        wall_time: [s] spent on its flights, over all processes that worked on it; planning and compiling are not among them.
    """

    race: str
    tuner: str
    goal: str
    seed: int
    flights: int
    search_flights: int
    best: Candidate
    validation: Validation | None
    validation_flights: int
    wall_time: float
    remark: str = ""
    selection_flights: int = 0

    def dump(self) -> dict[str, Any]:
        """As plain JSON, in the keys of `hotlap tune --json`."""
        return {
            "race": self.race,
            "tuner": self.tuner,
            "goal": self.goal,
            "seed": self.seed,
            "flights": self.flights,
            "search_flights": self.search_flights,
            "completion": self.best.completion,
            "confirmed": self.best.confirmed,
            "validation": None if self.validation is None else _dump_validation(self.validation),
            "validation_flights": self.validation_flights,
            "selection_flights": self.selection_flights,
            "lap_time": _finite(self.best.lap_time),
            "cost": _finite(self.best.cost),
            "wall_time": self.wall_time,
            "remark": self.remark,
        }


def _dump_validation(validation: Validation) -> dict[str, Any]:
    low, high = validation.interval
    return {"flights": validation.flights, "successes": validation.successes, "rate": validation.rate, "low": low, "high": high}


def _finite(value: float) -> float | None:
    """JSON has no NaN and no infinity."""
    return value if math.isfinite(value) else None
