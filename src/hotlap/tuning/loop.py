"""Tuning: ask, fly, confirm, validate, tell, until a candidate is reliable or the budget is spent; knows no file.

The paper confirms a candidate by four re-flights (Sec. IV-A). Among many candidates, one that completes two flights of three soon
passes them by chance. So a confirmed candidate is validated by 200 flights more, and the search goes on if too few of them succeed. Where
the budget is spent without such a candidate, what is handed over is chosen by flights of its own (`selection`).
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.ledger import Ledger, enter
from hotlap.core.parameters import Parameters
from hotlap.core.plain import typed, value_of
from hotlap.core.records import Scores
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.core.shown import Shown
from hotlap.core.success_rate import Validation
from hotlap.reference.scenario import Scenario
from hotlap.tuners.checked import checked
from hotlap.tuners.tuner import Tuner, asked_together
from hotlap.tuning.candidate import Candidate, reported_scores, summarise
from hotlap.tuning.choice import Choice
from hotlap.tuning.goal import Quantity
from hotlap.tuning.objective import Flies
from hotlap.tuning.selection import Finalist
from hotlap.tuning.settings import TuningSettings

FOREVER = 1e9  # minutes after which a search has ended that was told to end
FEW = 4  # candidates of a population that are confirmed
SCREENED = 48  # flights after which a validation of one may be given up


@dataclass(frozen=True, repr=False)
class Request(Shown):
    """Flights that a run wants flown.

    Attributes:
        parameters: shape (B, S, K).
        seeds: shape (B,).
    """

    parameters: Parameters
    seeds: NDArray[np.int64]


@dataclass(frozen=True, repr=False)
class Batch(Shown):
    """One pass of the loop: some candidates flown, confirmed, validated and reported to the tuner.

    Attributes:
        ledger: the flights of this pass.
        best: the best candidate of the run so far.
        validation: of the best candidate; None before it was flown.
        failed_validations: of candidates that passed their re-flights in this pass and succeeded in too few validation flights.
        flights: of the run so far, re-flights included.
        search_flights: of the run so far without re-flights, up to the confirmed candidate: the paper's count.
        done: whether the run has ended.
        state: everything that the run's future depends on, as plain JSON.
    """

    ledger: Ledger
    best: Candidate
    validation: Validation | None
    failed_validations: tuple[Validation, ...]
    flights: int
    search_flights: int
    done: bool
    state: dict[str, Any]


def scenario_for(scenario: Scenario, tuner: Tuner) -> Scenario:
    """The scenario on which a tuner flies: one that uses dense costs has its flights go on after a missed gate.

    Completion, cost and how a flight ended are the same; it takes longer to fly.
    """
    if not getattr(tuner.settings, "dense", False) or scenario.race.judge.fly_on:
        return scenario
    judge = scenario.race.judge.model_copy(update={"fly_on": True})
    return replace(scenario, race=scenario.race.model_copy(update={"judge": judge}))


class Tuning:
    """One run of a tuner on a scenario: fixed settings, and a state that each `batch` advances.

    Args:
        tuner: not yet started.
        scenario: what is flown.
        settings: what the run is asked to do.
        first_guess: shape (S, K); None: the default of the controller for every segment.
        state: of an earlier `Batch`, from which the run continues bit for bit.

    Attributes:
        best: the best candidate so far, None before the first flight.
        validation: of the best candidate, None before it was flown.
        flights: flown so far, re-flights included, selection and validations not.
        search_flights: without re-flights, up to the confirmed candidate.
        together: flights that take no longer than one; re-flights of a candidate end with the first of so many that fail. 0: any number.
    """

    together: int = 0

    def __init__(
        self,
        tuner: Tuner,
        scenario: Scenario,
        settings: TuningSettings,
        first_guess: Parameters | None = None,
        state: dict[str, Any] | None = None,
    ) -> None:
        guess = scenario.space.first_guess(len(scenario.segments)) if first_guess is None else first_guess
        self.tuner, self.settings = checked(tuner), settings
        self.best: Candidate | None = None
        self.validation: Validation | None = None
        self.search_flights = 0
        self._flown = {Stream.SEARCH: 0, Stream.CONFIRMATION: 0, Stream.VALIDATION: 0, Stream.SELECTION: 0}
        self._choice, self._ended = Choice(self.tuner, settings), 0.0
        self.tuner.start(guess, scenario.space, np.random.default_rng(settings.seed))
        if state is not None:
            self._restore(state)

    @property
    def flights(self) -> int:
        """Flown so far, re-flights included, selection and validations not."""
        return self._flown[Stream.SEARCH] + self._flown[Stream.CONFIRMATION]

    @property
    def validation_flights(self) -> int:
        """Flown so far to validate the result, and candidates before it whose validation failed."""
        return self._flown[Stream.VALIDATION]

    @property
    def selection_flights(self) -> int:
        """Flown so far to choose the result where no candidate was confirmed."""
        return self._flown[Stream.SELECTION]

    @property
    def done(self) -> bool:
        """Whether the search is over and its result chosen and validated."""
        return self.searched and self._selected and (self.validation is not None or not self.settings.validation)

    def end_search(self, selection: int | None = None) -> None:
        """Let the search end, whatever is left of its budget: the time is over. The result is still chosen and validated.

        Args:
            selection: flights by which it is chosen; None: as the settings say.
        """
        self._ended = self.settings.minutes or FOREVER
        self._choice.flights = self.settings.selection if selection is None else selection

    def limit_selection(self, flights: int) -> None:
        """Choose the result by at most so many flights."""
        self._choice.flights = min(self._choice.flights, flights)

    @property
    def searched(self) -> bool:
        """Whether a candidate is confirmed, the budget spent or the time over."""
        left = self.settings.budget - self.flights
        return self.best is not None and (self.best.confirmed or self._ended > 0 or left < self.settings.flights_each)

    @property
    def _selected(self) -> bool:
        """Whether the result has been chosen, or there is nothing to choose."""
        return bool(self.best and self.best.confirmed) or not self._choice.flights or self._choice.made_at(self.flights)

    def batch(self) -> Generator[Request, Scores, Batch]:
        """One pass of the loop: yields the flights that it wants, is sent their scores, returns the batch.

        Candidates that meet the goal are confirmed in the order asked for, until one passes. The score reported to the tuner has the
        mean costs and gate misses over all flights of a candidate; everything else is that of the flight that failed. When the budget is
        spent, the last pass validates the best candidate.
        """
        if self.searched and self.best is not None:
            ledger = yield from (self._finish(self.best) if self._selected else self._select(self.best))
            return self._report(ledger, ())
        self._choice.begin_anew()
        each = self.settings.flights_each
        ask = partial(asked_together, self.tuner) if self.settings.minutes else self.tuner.ask
        parameters = ask(max(1, min(self.settings.batch, (self.settings.budget - self.flights) // each)))
        ledger, scores = yield from self._fly(Stream.SEARCH, np.repeat(parameters, each, axis=0))
        ledgers, flown = [ledger], [scores.rows(slice(i, i + each)) for i in range(0, len(scores), each)]
        before, confirmed, validation, failed = self.search_flights, None, None, {}
        self.search_flights += len(scores)
        for i in self._promising(flown):
            flown[i], again = yield from self._confirm(parameters[i], flown[i])
            ledgers += again
            if not self._is_confirmed(flown[i]):
                continue
            if self.settings.validation:
                validation, ledger, repeats = yield from (self._screen if self.settings.minutes else self._validate)(parameters[i])
                ledgers.append(ledger)
                if validation.rate < self.settings.wanted:
                    flown[i] = Scores.join([flown[i], repeats])
                    failed[i] = validation
                    self._choice.remember(Finalist(parameters[i]).flown(repeats, self.settings.goal))
                    continue
            confirmed, validation = i, None if self.settings.minutes else validation  # of many, the luckiest: it is validated again
            self.search_flights = before + (len(scores) if self.settings.minutes else (i + 1) * each)
            break
        reported = Scores.join([reported_scores(scores, self.settings.goal, self.settings.caution) for scores in flown])
        ledgers[0] = ledgers[0].accept(np.repeat(self.tuner.tell(parameters, reported), each))
        rates = {i: validation.rate for i, validation in failed.items()}
        candidates = [summarise(parameters[i], scores, confirmed == i, rates.get(i, 0.0)) for i, scores in enumerate(flown)]
        self._keep_best(candidates, validation)
        self._choice.consider(parameters, flown, rates)
        return self._report(Ledger.join(ledgers), tuple(failed.values()))

    def _promising(self, flown: Sequence[Scores]) -> list[int]:
        """Candidates that met the goal in all their flights, in the order to be confirmed; of a population, the best few."""
        met = [i for i, scores in enumerate(flown) if self.settings.goal.met(scores).all()]
        return sorted(met, key=lambda i: float(flown[i].dense.mean()))[:FEW] if self.settings.minutes else met

    def _finish(self, best: Candidate) -> Generator[Request, Scores, Ledger]:
        """Validate the result; one that was chosen by flights of its own is confirmed by as many successes as any other."""
        self.validation, ledger, _ = yield from self._validate(best.parameters)
        chosen = self._choice.made_at(self.flights)
        if (chosen or self.settings.minutes) and self.settings.reliability and self.settings.goal.quantity is not Quantity.NONE:
            self.best = replace(best, confirmed=self.validation.rate >= self.settings.reliability)
        return ledger

    def _select(self, best: Candidate) -> Generator[Request, Scores, Ledger]:
        """One round of a selection; after the last one the result is chosen."""
        parameters, each = self._choice.next_round((self.flights, self.selection_flights), best.parameters)
        ledger, scores = yield from self._fly(Stream.SELECTION, np.repeat(parameters, each, axis=0))
        chosen = self._choice.after_round(scores, (self.flights, self.selection_flights))
        if chosen is not None:
            self.best, self.validation = chosen, None
        return ledger

    def _keep_best(self, candidates: Sequence[Candidate], validation: Validation | None) -> None:
        """Keep the best candidate, with its validation if it has been confirmed."""
        known = [] if self.best is None else [self.best]
        best = max(known + list(candidates), key=lambda candidate: candidate.rank)
        if best is not self.best:
            self.best, self.validation = best, validation if best.confirmed else None

    def _report(self, ledger: Ledger, failed_validations: tuple[Validation, ...]) -> Batch:
        """The batch of a pass that has flown."""
        assert self.best is not None, "a pass has flown"  # noqa: S101  our own mistake
        counts = self.flights, self.search_flights
        return Batch(ledger, self.best, self.validation, failed_validations, *counts, self.done, self._state())

    def _fly(self, stream: Stream, parameters: Parameters) -> Generator[Request, Scores, tuple[Ledger, Scores]]:
        """Fly with the next seeds of a stream."""
        seeds = self._next_seeds(stream, len(parameters))
        scores = yield Request(parameters, seeds)
        return self._enter(stream, parameters, seeds, scores), scores

    def _next_seeds(self, stream: Stream, count: int) -> NDArray[np.int64]:
        """Seeds of the next flights of a stream, shape (count,)."""
        return flight_seeds(self.settings.seed, stream, self._flown[stream], count)

    def _enter(self, stream: Stream, parameters: Parameters, seeds: NDArray[np.int64], scores: Scores) -> Ledger:
        """Count flights; their rows of the ledger."""
        number = self._flown[stream] if stream in {Stream.VALIDATION, Stream.SELECTION} else self.flights
        self._flown[stream] += len(seeds)
        return enter(number, stream, parameters, seeds, scores)

    def _confirm(self, parameters: Parameters, flown: Scores) -> Generator[Request, Scores, tuple[Scores, list[Ledger]]]:
        """Fly a candidate, shape (S, K), again, as often as its confirmation and the budget ask for; returns all its flights.

        The re-flights are flown together, as many as fill the lanes, and count as if flown one by one until the first that fails: those
        after it are discarded, and their seeds are used again.
        """
        count = min(self.settings.confirm, self.settings.budget - self.flights)
        if count <= 0:
            return flown, []
        repeated, seeds = np.repeat(parameters[None], count, axis=0), self._next_seeds(Stream.CONFIRMATION, count)
        at_once, parts = self.together or count, list[Scores]()
        for start in range(0, count, at_once):
            parts.append((yield Request(repeated[start : start + at_once], seeds[start : start + at_once])))
            if not self.settings.goal.met(parts[-1]).all():
                break
        scores = Scores.join(parts)
        failures = np.flatnonzero(~self.settings.goal.met(scores))
        counted = slice(int(failures[0]) + 1 if len(failures) else count)
        ledger = self._enter(Stream.CONFIRMATION, repeated[counted], seeds[counted], scores.rows(counted))
        return Scores.join([flown, scores.rows(counted)]), [ledger]

    def _validate(self, parameters: Parameters) -> Generator[Request, Scores, tuple[Validation, Ledger, Scores]]:
        """Fly a candidate, shape (S, K), with noise that the search never met."""
        repeated = np.repeat(parameters[None], self.settings.validation, axis=0)
        ledger, scores = yield from self._fly(Stream.VALIDATION, repeated)
        return Validation(len(scores), int(self.settings.goal.succeeded(scores).sum())), ledger, scores

    def _screen(self, parameters: Parameters) -> Generator[Request, Scores, tuple[Validation, Ledger, Scores]]:
        """The same, given up as soon as too many have failed."""
        allowed, ledgers, flown = (1 - self.settings.wanted) * self.settings.validation, [], []
        failures, left = 0, self.settings.validation
        while left and failures <= allowed:
            ledger, scores = yield from self._fly(Stream.VALIDATION, np.repeat(parameters[None], min(left, SCREENED), axis=0))
            ledgers, flown, left = [*ledgers, ledger], [*flown, scores], left - len(scores)
            failures += int((~self.settings.goal.succeeded(scores)).sum())
        validation = Validation(self.settings.validation - left, self.settings.validation - left - failures)
        return validation, Ledger.join(ledgers), Scores.join(flown)

    def _is_confirmed(self, flown: Scores) -> bool:
        """Whether a candidate's flight and all its re-flights met the goal."""
        return len(flown) == self.settings.flights_each + self.settings.confirm and bool(self.settings.goal.met(flown).all())

    def _state(self) -> dict[str, Any]:
        """Counts, the best candidate and the tuner, as plain JSON."""
        best = None if self.best is None else self.best.dump()
        flown = {stream.name: count for stream, count in self._flown.items()}
        validation = None if self.validation is None else asdict(self.validation)
        counts = {"flown": flown, "search_flights": self.search_flights}
        counts = {**counts, "best": best, "validation": validation, "ended": self._ended}
        return {**counts, **self._choice.dump(), "tuner": self.tuner.state()}

    def _restore(self, state: dict[str, Any]) -> None:
        """The inverse of `_state`."""
        self._flown |= {Stream[name]: value_of("int", name, count) for name, count in state["flown"].items()}
        self.search_flights = value_of("int", "search_flights", state["search_flights"])
        self.best = None if state["best"] is None else Candidate.load(state["best"])
        self.validation = None if state["validation"] is None else Validation(**typed(Validation, state["validation"]))
        self._choice.restore(state, made_at=self.flights if self.validation is not None else -1)
        ended = value_of("float", "ended", state.get("ended", 0.0))
        selection = value_of("int", "selection_flights", state.get("selection_flights", 0))
        if ended and (not self.settings.minutes or ended >= self.settings.minutes):  # else it has been given more
            self._ended, self._choice.flights = ended, selection
        self.tuner.restore(state["tuner"])


def tune(objective: Flies, tuning: Tuning) -> Iterator[Batch]:
    """Run a tuning to its end, batch by batch.

    Args:
        objective: what flies.
        tuning: the run; it may have been restored.
    """
    for _, batch in tune_together(objective, [tuning]):
        yield batch


def tune_together(objective: Flies, tunings: Sequence[Tuning]) -> Iterator[tuple[int, Batch]]:
    """Run independent tunings of one scenario in lockstep, so that their flights fill the lanes; results are as of each alone.

    Args:
        objective: what flies.
        tunings: the runs.

    Yields:
        The index of a run, and a batch of it.
    """
    waiting = {i: _begin(tuning) for i, tuning in enumerate(tunings) if not tuning.done}
    while waiting:
        batches = list(waiting.items())
        parameters = np.concatenate([request.parameters for _, (_, request) in batches])
        scores = objective.fly(parameters, np.concatenate([request.seeds for _, (_, request) in batches]))
        start = 0
        for i, (batch, request) in batches:
            end = start + len(request.seeds)
            try:
                waiting[i] = batch, batch.send(scores.rows(slice(start, end)))
            except StopIteration as finished:
                del waiting[i]
                yield i, finished.value
                if not tunings[i].done:
                    waiting[i] = _begin(tunings[i])
            start = end


def _begin(tuning: Tuning) -> tuple[Generator[Request, Scores, Batch], Request]:
    """A pass of a run, and the first flights that it wants."""
    batch = tuning.batch()
    return batch, next(batch)
