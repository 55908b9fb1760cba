"""Tuning: ask, fly, confirm, tell, until the goal is confirmed or the budget spent; knows no file."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.course import Course
from hotlap.errors import InputError
from hotlap.goal import Goal
from hotlap.ledger import Ledger, enter
from hotlap.objective import Objective
from hotlap.parameters import Parameters
from hotlap.records import Scores
from hotlap.seeds import FLIGHTS_A_STREAM, LARGEST_RUN_SEED, Stream, flight_seeds
from hotlap.tuners.tuner import Tuner

CONFIRMATIONS = 4  # "flown four times more", Sec. IV-A


@dataclass(frozen=True)
class TuningSettings:
    """What a run is asked to do.

    Attributes:
        goal: when to stop.
        budget: flights, re-flights included.
        seed: of the tuner's chance and of the flights' noise.
        confirmations: fresh re-flights that a candidate must pass.
        batch: most flights that a tuner is asked for at once.
    """

    goal: Goal = field(default_factory=Goal)
    budget: int = 200
    seed: int = 0
    confirmations: int = CONFIRMATIONS
    batch: int = 8

    def __post_init__(self) -> None:
        for name, least, largest in (
            ("budget", 1, FLIGHTS_A_STREAM),
            ("seed", 0, LARGEST_RUN_SEED),
            ("confirmations", 0, 1000),
            ("batch", 1, 10_000),
        ):
            value = getattr(self, name)
            if not least <= value <= largest:
                raise InputError(f"--{name}", "", f"must be from {least} to {largest}, not {value}")


@dataclass(frozen=True)
class Request:
    """Flights that a run wants flown.

    Attributes:
        parameters: shape (B, S, K).
        seeds: shape (B,).
    """

    parameters: Parameters
    seeds: NDArray[np.int64]


@dataclass(frozen=True)
class Candidate:
    """Parameters and what their flights so far were worth.

    Attributes:
        parameters: shape (S, K).
        cost: mean over its flights; infinite where one of them has none.
        completion: mean over its flights.
        lap_time: [s] mean over its complete flights; NaN without any.
        flights: how many, re-flights included.
        confirmed: whether it met the goal in all re-flights.
    """

    parameters: Parameters
    cost: float
    completion: float
    lap_time: float
    flights: int
    confirmed: bool

    @property
    def rank(self) -> tuple[bool, float, float]:
        """Larger is better: confirmed, then completion, then cost."""
        return self.confirmed, self.completion, -self.cost


@dataclass(frozen=True)
class Batch:
    """One turn of the loop.

    Attributes:
        ledger: what was flown in it.
        best: the best candidate of the run so far.
        flights: of the run so far, re-flights included.
        search_flights: of the run so far without re-flights, up to the confirmed candidate: the paper's count.
        done: whether the run has ended.
        state: everything that the run's future depends on, as plain JSON.
    """

    ledger: Ledger
    best: Candidate
    flights: int
    search_flights: int
    done: bool
    state: dict[str, Any]


class Tuning:
    """One run of a tuner on a course: settings that stay, and a state that `batch` moves on.

    Args:
        tuner: not yet started.
        course: what is flown.
        settings: what the run is asked to do.
        first_guess: shape (S, K); None: the default of the controller for every segment.
        state: of an earlier `Batch`, to go on from there bit for bit.

    Attributes:
        best: the best candidate so far, None before the first flight.
        flights: flown so far, re-flights included.
        search_flights: without re-flights, up to the confirmed candidate.
    """

    def __init__(
        self,
        tuner: Tuner,
        course: Course,
        settings: TuningSettings,
        first_guess: Parameters | None = None,
        state: dict[str, Any] | None = None,
    ) -> None:
        guess = course.space.first_guess(len(course.segments)) if first_guess is None else first_guess
        self.tuner, self.settings = tuner, settings
        self.best: Candidate | None = None
        self.search_flights = 0
        self._flown = {Stream.SEARCH: 0, Stream.CONFIRMATION: 0}
        tuner.start(guess, course.space, np.random.default_rng(settings.seed))
        if state is not None:
            self._restore(state)

    @property
    def flights(self) -> int:
        """Flown so far, re-flights included."""
        return sum(self._flown.values())

    @property
    def done(self) -> bool:
        """Whether a candidate is confirmed or the budget spent."""
        return self.flights >= self.settings.budget or (self.best is not None and self.best.confirmed)

    def batch(self) -> Generator[Request, Scores, Batch]:
        """One turn: yields what it wants flown, is sent the scores, returns what came of it.

        Flights that meet the goal are flown again one by one, in order, until one fails; the tuner is told the mean cost over all
        flights of a candidate, and otherwise the flight that failed.
        """
        parameters = self.tuner.ask(min(self.settings.batch, self.settings.budget - self.flights))
        ledger, scores = yield from self._fly(Stream.SEARCH, parameters)
        ledgers, flown = [ledger], [scores.rows(slice(i, i + 1)) for i in range(len(scores))]
        before, confirmed = self.search_flights, None
        self.search_flights += len(scores)
        for i in np.flatnonzero(self.settings.goal.met(scores)).tolist():
            flown[i], again = yield from self._confirm(parameters[i], flown[i])
            ledgers += again
            if self._confirmed(flown[i]):
                confirmed, self.search_flights = i, before + i + 1
                break
        ledgers[0] = ledger.accept(self.tuner.tell(parameters, Scores.join([_told(scores) for scores in flown])))
        candidates = [_candidate(parameters[i], scores, confirmed == i) for i, scores in enumerate(flown)]
        self.best = max([*([] if self.best is None else [self.best]), *candidates], key=lambda candidate: candidate.rank)
        return Batch(Ledger.join(ledgers), self.best, self.flights, self.search_flights, self.done, self._state())

    def _fly(self, stream: Stream, parameters: Parameters) -> Generator[Request, Scores, tuple[Ledger, Scores]]:
        """Fly with the next seeds of a stream."""
        number, count = self.flights, len(parameters)
        seeds = flight_seeds(self.settings.seed, stream, self._flown[stream], count)
        scores = yield Request(parameters, seeds)
        self._flown[stream] += count
        return enter(number, stream, parameters, seeds, scores), scores

    def _confirm(self, parameters: Parameters, flown: Scores) -> Generator[Request, Scores, tuple[Scores, list[Ledger]]]:
        """Fly a candidate, shape (S, K), again until it fails, is confirmed or the budget ends; returns all its flights."""
        ledgers = []
        while not self._confirmed(flown) and self.settings.goal.met(flown).all() and self.flights < self.settings.budget:
            ledger, scores = yield from self._fly(Stream.CONFIRMATION, parameters[None])
            ledgers.append(ledger)
            flown = Scores.join([flown, scores])
        return flown, ledgers

    def _confirmed(self, flown: Scores) -> bool:
        """Whether a candidate's flight and all its re-flights met the goal."""
        return len(flown) == 1 + self.settings.confirmations and bool(self.settings.goal.met(flown).all())

    def _state(self) -> dict[str, Any]:
        """Counts, the best candidate and the tuner, as plain JSON."""
        best = None if self.best is None else _write_candidate(self.best)
        flown = {stream.name: count for stream, count in self._flown.items()}
        return {"flown": flown, "search_flights": self.search_flights, "best": best, "tuner": self.tuner.state()}

    def _restore(self, state: dict[str, Any]) -> None:
        """The inverse of `_state`."""
        self._flown = {Stream[name]: count for name, count in state["flown"].items()}
        self.search_flights = state["search_flights"]
        self.best = None if state["best"] is None else _read_candidate(state["best"])
        self.tuner.restore(state["tuner"])


def tune(objective: Objective, tuning: Tuning) -> Iterator[Batch]:
    """Run a tuning to its end, batch by batch.

    Args:
        objective: what flies.
        tuning: the run; it may have been restored.
    """
    for _, batch in tune_together(objective, [tuning]):
        yield batch


def tune_together(objective: Objective, tunings: Sequence[Tuning]) -> Iterator[tuple[int, Batch]]:
    """Run independent tunings of one course in lockstep, so that their flights fill the lanes; each goes as it would alone.

    Args:
        objective: what flies.
        tunings: the runs.

    Yields:
        The index of a run, and a batch of it.
    """
    waiting = {i: _begin(tuning) for i, tuning in enumerate(tunings) if not tuning.done}
    while waiting:
        turns = list(waiting.items())
        parameters = np.concatenate([request.parameters for _, (_, request) in turns])
        scores = objective.fly(parameters, np.concatenate([request.seeds for _, (_, request) in turns]))
        start = 0
        for i, (turn, request) in turns:
            end = start + len(request.seeds)
            try:
                waiting[i] = turn, turn.send(scores.rows(slice(start, end)))
            except StopIteration as finished:
                del waiting[i]
                yield i, finished.value
                if not tunings[i].done:
                    waiting[i] = _begin(tunings[i])
            start = end


def _begin(tuning: Tuning) -> tuple[Generator[Request, Scores, Batch], Request]:
    """A turn, and the first that it wants flown."""
    turn = tuning.batch()
    return turn, next(turn)


def _told(flown: Scores) -> Scores:
    """What the tuner hears of a candidate: its last flight, which is the one that failed, with the mean cost of all of them."""
    return replace(flown.rows(slice(-1, None)), cost=np.mean(flown.cost, keepdims=True))


def _candidate(parameters: Parameters, flown: Scores, confirmed: bool) -> Candidate:
    """Means over the flights of some parameters, shape (S, K)."""
    laps, cost = flown.lap_time[np.isfinite(flown.lap_time)], float(flown.cost.mean())
    return Candidate(
        parameters=parameters,
        cost=cost if np.isfinite(cost) else float("inf"),
        completion=float(flown.completion.mean()),
        lap_time=float(laps.mean()) if len(laps) else float("nan"),
        flights=len(flown),
        confirmed=confirmed,
    )


def _write_candidate(candidate: Candidate) -> dict[str, Any]:
    """As plain JSON, which has no NaN and no infinity."""
    plain = {name: value if np.isfinite(value) else None for name, value in vars(candidate).items() if name != "parameters"}
    return {"parameters": candidate.parameters.tolist(), **plain}


def _read_candidate(plain: dict[str, Any]) -> Candidate:
    """The inverse; what was not finite has become the worst."""
    worst = {"cost": float("inf"), "lap_time": float("nan")}
    known = {name: worst.get(name) if value is None else value for name, value in plain.items()}
    return Candidate(**{**known, "parameters": np.array(plain["parameters"])})
