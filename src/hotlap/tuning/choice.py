"""Choice: what a run hands over where no candidate was confirmed, by one selection, or by several where its tuner learns from them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hotlap.core.parameters import Parameters
from hotlap.core.plain import value_of
from hotlap.core.records import Scores
from hotlap.core.seeds import Stream
from hotlap.tuners.tuner import Tuner, recommended_by
from hotlap.tuning.candidate import Candidate, reported_scores
from hotlap.tuning.selection import FINALISTS, KNOWN, Contenders, Finalist, Selection, merit, mixed
from hotlap.tuning.settings import TuningSettings

CYCLES = 3  # selections, one after the other, where a tuner learns from them ...
FEWEST = CYCLES * FINALISTS  # ... and there are so many flights


class Choice:
    """The candidates from which a run chooses, and the selection that is under way.

    Args:
        tuner: of the run.
        settings: of the run.

    Attributes:
        flights: by which it is chosen; 0: not at all.
    """

    def __init__(self, tuner: Tuner, settings: TuningSettings) -> None:
        self.flights = settings.selection
        self._tuner, self._settings = tuner, settings
        self._contenders, self._known, self._selection = Contenders(), list[Finalist](), None
        self._cycle, self._made_at = 0, -1

    def made_at(self, flights: int) -> bool:
        """Whether it was made when the run had flown so many flights, and none since."""
        return self._made_at == flights

    def consider(self, parameters: Parameters, flown: Sequence[Scores], rates: Mapping[int, float]) -> None:
        """Remember candidates of the search, if they look better than those before.

        Args:
            parameters: shape (B, S, K).
            flown: the flights of each.
            rates: of the validations that some of them failed, by their index.
        """
        for i, scores in enumerate(flown):
            rate = 0.0 if self._settings.minutes else rates.get(i, 0.0)
            self._contenders.add(parameters[i], merit(scores, self._settings.goal, rate))

    def remember(self, flown: Finalist) -> None:
        """Keep a candidate that was flown often, if it is among the best of these."""
        others = [one for one in self._known if one.parameters.tobytes() != flown.parameters.tobytes()]
        self._known = sorted([*others, flown], key=lambda one: one.rank, reverse=True)[:KNOWN]

    def begin_anew(self) -> None:
        """Give up a selection that is under way, as the search goes on: it has been given more flights, or more time."""
        self._selection, self._cycle = None, 0

    def next_round(self, flown: tuple[int, int], best: Parameters) -> tuple[Parameters, int]:
        """The finalists of the next round, shape (F, S, K), and how often each is to be flown.

        Args:
            flown: flights of the search and of selections before.
            best: shape (S, K), of the search by its scores; the only finalist where no other is remembered.
        """
        if self._selection is None:
            self._selection = self._begin(self._recommended(flown), best)
        return np.array([one.parameters for one in self._selection.finalists]), self._selection.flights_each

    def _begin(self, theirs: list[Parameters], best: Parameters) -> Selection:
        """Among the candidates that look best and those that the tuner recommends; then among what it recommends by what it has learnt."""
        candidates = theirs if self._cycle else mixed(self._contenders.best(), theirs)
        return Selection.begin(candidates[:FINALISTS] or [best], self.flights // self._cycles(theirs), self._known)

    def after_round(self, scores: Scores, flown: tuple[int, int]) -> Candidate | None:
        """What is chosen, if this was the last round. A tuner that learns from any flights is told of these.

        Args:
            scores: of the round.
            flown: flights of the search and of selections, this round among them.
        """
        assert self._selection is not None, "a round has begun"  # noqa: S101  our own mistake
        if getattr(self._tuner, "learns_from_any", False):
            self._tell(self._selection, scores)
        self._selection = self._selection.after(scores, self._settings.goal)
        winner = self._selection.winner
        if winner is None:
            return None
        self._selection, self._cycle = None, self._cycle + 1
        self.remember(winner)
        if self._cycle < self._cycles(self._recommended(flown)):
            return None
        self._cycle, self._made_at = 0, flown[0]
        return self._known[0].candidate

    def _tell(self, selection: Selection, scores: Scores) -> None:
        """Report a round to the tuner."""
        each, settings = selection.flights_each, self._settings
        flown = [scores.rows(slice(i, i + each)) for i in range(0, len(scores), each)]
        parameters = np.array([one.parameters for one in selection.finalists])
        self._tuner.tell(parameters, Scores.join([reported_scores(one, settings.goal, settings.caution) for one in flown]))

    def _cycles(self, theirs: list[Parameters]) -> int:
        """Selections, one after the other: several where the tuner recommends anew from what it has learnt, and flights are enough."""
        return CYCLES if theirs and self.flights >= FEWEST else 1

    def _recommended(self, flown: tuple[int, int]) -> list[Parameters]:
        """What the tuner recommends after so many flights of the search and of selections, the best first."""
        rng = np.random.default_rng((self._settings.seed, *flown, int(Stream.SELECTION)))
        return list(recommended_by(self._tuner, FINALISTS // 2, rng))

    def dump(self) -> dict[str, Any]:
        """As plain JSON."""
        selection = None if self._selection is None else self._selection.dump()
        known = [one.dump() for one in self._known]
        state = {"contenders": self._contenders.dump(), "selection": selection, "known": known}
        return {**state, "cycle": self._cycle, "selected_at": self._made_at, "selection_flights": self.flights}

    def restore(self, state: Mapping[str, Any], made_at: int) -> None:
        """Continue from a `dump()`, but for `flights`.

        Args:
            state: also of a version that chose nothing.
            made_at: what counts as its `selected_at` then.
        """
        self._contenders = Contenders.load(state.get("contenders", ()))
        self._known = [Finalist.load(one) for one in state.get("known", ())]
        self._selection = None if state.get("selection") is None else Selection.load(state["selection"])
        self._cycle = value_of("int", "cycle", state.get("cycle", 0))
        self._made_at = value_of("int", "selected_at", state.get("selected_at", made_at))
