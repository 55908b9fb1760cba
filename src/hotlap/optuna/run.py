"""TunerRun: one tuner at work on a study; all that it was told is in the trials, so that any process can bring it up to date."""

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

KEY = "hotlap:run"  # of the note that each trial of a run bears
FARTHEST = 1e9  # spreads from the origin that a cost may lie
SAME = 1e-9  # relative difference of values that are called the same


@dataclass(frozen=True)
class Origin:
    """What a run began from: with it and the trials, everything that a run does can be repeated.

    Attributes:
        run: its number within the study.
        tuner: name with preset.
        space: fingerprint of the box.
        seed: of its chance, together with `run`.
        batch: most points that it asks for at once.
        trial: number of the trial that it begins at, the best of its time.
        best: its cost, less is better.
        spread: of the costs known at the time.
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
        """A cost as tuners are told it: positive, growing, 1 at the best and about 2.4 a spread above it; infinite for a failure.

        Tuners take costs for times: they take logarithms, and some accept what is worse by 1 with a probability of 1/e.
        """
        if cost == math.inf:
            return math.inf
        z = min(max((cost - self.best) / self.spread, -FARTHEST), FARTHEST)
        return z + math.hypot(1.0, z) if z > 0 else 1.0 / (math.hypot(1.0, z) - z)


@dataclass(frozen=True)
class Note:
    """What a trial says about the run that it belongs to; kept in the study's storage.

    Attributes:
        origin: of the run.
        ask: which of its asks, from 0.
        place: among the points of that ask.
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
        """The note of a trial, if it bears one."""
        plain = trial.system_attrs.get(KEY)
        return None if plain is None else cls(Origin(**plain["origin"]), plain["ask"], plain["place"])


class TunerRun:
    """A tuner, brought up to date from trials.

    Args:
        origin: what it began from.
        box: its search space.
        first: the parameters of the trial that it begins at.

    A run asks anew when every point of its last ask has been tried, and is told how those went in the order asked.
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
        """The point that nobody tries yet; None while the last ask is under way, or if this is not the run that was recorded.

        Args:
            tried: trials of this run, with their costs, by ask and place; a cost of NaN: not known yet.

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
        """Whether a trial tried what this tuner asks for; not so where another version of it was at work."""
        wanted = self._box.decode(point)
        known = {name: value for name, value in trial.params.items() if name in wanted}
        return all(math.isclose(value, wanted[name], rel_tol=SAME, abs_tol=SAME) for name, value in known.items())


def cost_of(trial: FrozenTrial, sign: float) -> float:
    """Less is better; infinite for a trial that failed or was pruned; NaN for one that has not ended.

    Args:
        trial: of a study with one objective.
        sign: -1 where it is maximised.
    """
    if trial.state is TrialState.COMPLETE and trial.value is not None:
        return sign * trial.value
    return math.inf if trial.state.is_finished() else math.nan
