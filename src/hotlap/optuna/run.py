"""TunerRun: one tuner and the trials of a study that it asked for; any process can rebuild it, since the trials hold all its scores."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from optuna.trial import FrozenTrial, TrialState

from hotlap import tuners
from hotlap.core.records import Scores
from hotlap.optuna.box import Box

Floats = NDArray[np.float64]

KEY = "hotlap:run"  # attribute of a trial that holds its note
FARTHEST = 1e9  # limit of a cost's distance from the best one, in spreads
SAME = 1e-9  # relative difference up to which values count as equal


@dataclass(frozen=True)
class Origin:
    """Initial conditions of a run: with them and the trials the run can be repeated exactly.

    Attributes:
        run: its number within the study.
        tuner: name with preset.
        space: fingerprint of the search space.
        seed: seed of its random generator, together with `run`.
        batch: largest number of points that it asks for at once.
        trial: number of the trial at which it begins, the best one at that time.
        best: cost of that trial, lower is better.
        spread: median distance of the costs at that time from the best one.
    """

    run: int
    tuner: str
    space: str
    seed: int
    batch: int
    trial: int
    best: float
    spread: float

    def scaled(self, cost: float) -> float:
        """The cost that is reported to the tuner: positive, increasing, 1 at the best, about 2.4 one spread above; infinite for a failure.

        Tuners expect costs of the size of lap times: they take logarithms, and some accept a cost higher by 1 with probability 1/e.
        """
        if cost == math.inf:
            return math.inf
        z = min(max((cost - self.best) / self.spread, -FARTHEST), FARTHEST)
        return z + math.hypot(1.0, z) if z > 0 else 1.0 / (math.hypot(1.0, z) - z)


@dataclass(frozen=True)
class Note:
    """The run that a trial belongs to, and its place in it; kept in the study's storage.

    Attributes:
        origin: initial conditions of the run.
        ask: index of the ask, from 0.
        place: index of the point in that ask.
    """

    origin: Origin
    ask: int
    place: int

    @property
    def point(self) -> tuple[int, int, int]:
        """What no two trials share: run, ask and place."""
        return self.origin.run, self.ask, self.place

    def dump(self) -> dict[str, Any]:
        """As plain JSON."""
        return {"origin": vars(self.origin), "ask": self.ask, "place": self.place}

    @classmethod
    def of(cls, trial: FrozenTrial) -> Note | None:
        """The note of a trial; None where it has none."""
        plain = trial.system_attrs.get(KEY)
        return None if plain is None else cls(Origin(**plain["origin"]), plain["ask"], plain["place"])


class TunerRun:
    """A tuner, rebuilt from the trials that it asked for.

    Args:
        origin: initial conditions.
        box: search space.
        first: parameters of the trial at which it begins.

    When all points of an ask have been tried, their scores are reported in the order of the ask, and the tuner is asked again.
    """

    def __init__(self, origin: Origin, box: Box, first: Mapping[str, Any]) -> None:
        self.origin, self._box = origin, box
        self._tuner = tuners.build(origin.tuner)
        self._tuner.start(box.encode(first), box.space, np.random.default_rng([origin.seed, origin.run]))
        self._tuner.tell(self._tuner.ask(1), Scores.of_costs(np.array([origin.scaled(origin.best)])))
        self._ask()
        self._asks = 1

    def _ask(self) -> None:
        self._points = self._tuner.ask(self.origin.batch)

    def next(self, tried: Mapping[tuple[int, int], tuple[FrozenTrial, float]]) -> tuple[Note, Floats] | None:
        """The next point that is not tried yet; None while all points of the last ask are being tried, or if the recorded run differs.

        Args:
            tried: trials of this run with their costs, by ask and place; the cost is NaN as long as it is not known.

        Returns:
            The note for its trial, and parameters, shape (1, K).
        """
        while True:
            ask = self._asks - 1
            here = [tried.get((ask, place)) for place in range(len(self._points))]
            for place, entry in enumerate(here):
                if entry is None:
                    return Note(self.origin, ask, place), self._points[place]
                if not self._is_same(entry[0], self._points[place]):
                    return None
            costs = [entry[1] for entry in here if entry is not None]
            if any(math.isnan(cost) for cost in costs):
                return None
            self._tuner.tell(self._points, Scores.of_costs(np.array([self.origin.scaled(cost) for cost in costs])))
            self._ask()
            self._asks += 1

    def _is_same(self, trial: FrozenTrial, point: Floats) -> bool:
        """Whether a trial has the parameters that this tuner asks for; not where another version of hotlap asked for them."""
        wanted = self._box.decode(point)
        known = {name: value for name, value in trial.params.items() if name in wanted}
        return all(math.isclose(value, wanted[name], rel_tol=SAME, abs_tol=SAME) for name, value in known.items())


def cost_of(trial: FrozenTrial, sign: float) -> float:
    """Cost of a trial, lower is better; infinite for one that failed or was pruned, NaN for one that has not ended.

    Args:
        trial: trial of a study with one objective.
        sign: -1 where the objective is maximised.
    """
    if trial.state is TrialState.COMPLETE and trial.value is not None:
        return sign * trial.value
    return math.inf if trial.state.is_finished() else math.nan
