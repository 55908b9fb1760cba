"""Tuning: ask, fly, confirm, validate, tell, until a result holds or the budget is spent; knows no file.

The paper confirms a candidate by four more flights (Sec. IV-A). Four of four is a lottery: with many candidates, one that completes
two flights of three wins it soon. So a confirmed candidate is flown 200 times more, and the search goes on if it does not hold.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import InputError
from hotlap.core.ledger import Ledger, enter
from hotlap.core.parameters import Parameters
from hotlap.core.records import Scores
from hotlap.core.seeds import FLIGHTS_A_STREAM, LARGEST_RUN_SEED, Stream, flight_seeds
from hotlap.core.success_rate import FLIGHTS, RELIABILITY, Validation
from hotlap.reference.scenario import Scenario
from hotlap.tuners.tuner import Tuner
from hotlap.tuning.goal import Goal
from hotlap.tuning.objective import Objective

CONFIRMATIONS = 4  # "flown four times more", Sec. IV-A
SAMPLES = 4  # flights of a candidate, where vehicles differ


@dataclass(frozen=True)
class TuningSettings:
    """What a run is asked to do.

    Attributes:
        goal: when to stop.
        budget: flights, re-flights included.
        seed: of the tuner's chance and of the flights' noise.
        confirm: fresh re-flights that a candidate must pass.
        validation: flights with fresh noise of a confirmed candidate, not counted in the budget; 0 for none.
        reliability: least share of them that must meet the goal, or the search goes on; 0 takes any candidate that is confirmed.
        batch: most candidates that a tuner is asked for at once.
        samples: flights of each candidate in the search, all of which must meet the goal; 0: one, or `SAMPLES` where vehicles differ.
        randomise: how far the vehicle may differ from flight to flight, as a share; see `vehicle_parameters.draw_vehicle_parameters`.
    """

    goal: Goal = field(default_factory=Goal)
    budget: int = 200
    seed: int = 0
    confirm: int = CONFIRMATIONS
    validation: int = FLIGHTS
    reliability: float = RELIABILITY
    batch: int = 8
    samples: int = 0
    randomise: float = 0.0

    @property
    def flights_each(self) -> int:
        """Flights of a candidate in the search, before its re-flights."""
        return self.samples or (SAMPLES if self.randomise else 1)

    def __post_init__(self) -> None:
        for name, least, largest in (
            ("budget", 1, FLIGHTS_A_STREAM),
            ("seed", 0, LARGEST_RUN_SEED),
            ("confirm", 0, 1000),
            ("validation", 0, FLIGHTS_A_STREAM // 100),
            ("reliability", 0, 1),
            ("batch", 1, 10_000),
            ("samples", 0, 1000),
            ("randomise", 0, 0.9),
        ):
            value = getattr(self, name)
            if not least <= value <= largest:
                raise InputError("", name, f"must be from {least} to {largest}, not {value}")


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
        confirmed: whether it met the goal in all re-flights, and held where that was asked for.
        held: share of its validation that succeeded, if it was confirmed and did not hold; else 0.
    """

    parameters: Parameters
    cost: float
    completion: float
    lap_time: float
    flights: int
    confirmed: bool
    held: float = 0.0

    @property
    def rank(self) -> tuple[bool, float, float, float]:
        """Larger is better: confirmed, then what held most often, then completion, then cost."""
        return self.confirmed, self.held, self.completion, -self.cost


@dataclass(frozen=True)
class Batch:
    """One turn of the loop.

    Attributes:
        ledger: what was flown in it.
        best: the best candidate of the run so far.
        validation: of the best candidate; None before it was flown.
        fallen: validations of candidates that were confirmed in this turn and did not hold.
        flights: of the run so far, re-flights included.
        search_flights: of the run so far without re-flights, up to the confirmed candidate: the paper's count.
        done: whether the run has ended.
        state: everything that the run's future depends on, as plain JSON.
    """

    ledger: Ledger
    best: Candidate
    validation: Validation | None
    fallen: tuple[Validation, ...]
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
    """One run of a tuner on a scenario: settings that stay, and a state that `batch` moves on.

    Args:
        tuner: not yet started.
        scenario: what is flown.
        settings: what the run is asked to do.
        first_guess: shape (S, K); None: the default of the controller for every segment.
        state: of an earlier `Batch`, to go on from there bit for bit.

    Attributes:
        best: the best candidate so far, None before the first flight.
        validation: of the best candidate, None before it was flown.
        flights: flown so far, re-flights included, validations not.
        search_flights: without re-flights, up to the confirmed candidate.
    """

    def __init__(
        self,
        tuner: Tuner,
        scenario: Scenario,
        settings: TuningSettings,
        first_guess: Parameters | None = None,
        state: dict[str, Any] | None = None,
    ) -> None:
        guess = scenario.space.first_guess(len(scenario.segments)) if first_guess is None else first_guess
        self.tuner, self.settings = tuner, settings
        self.best: Candidate | None = None
        self.validation: Validation | None = None
        self.search_flights = 0
        self._flown = {Stream.SEARCH: 0, Stream.CONFIRMATION: 0, Stream.VALIDATION: 0}
        tuner.start(guess, scenario.space, np.random.default_rng(settings.seed))
        if state is not None:
            self._restore(state)

    @property
    def flights(self) -> int:
        """Flown so far, re-flights included, validations not."""
        return self._flown[Stream.SEARCH] + self._flown[Stream.CONFIRMATION]

    @property
    def validation_flights(self) -> int:
        """Flown so far to validate: the result, and candidates that did not hold."""
        return self._flown[Stream.VALIDATION]

    @property
    def done(self) -> bool:
        """Whether the search is over and its result validated."""
        return self._searched and (self.validation is not None or not self.settings.validation)

    @property
    def _searched(self) -> bool:
        """Whether a candidate is confirmed or the budget spent."""
        left = self.settings.budget - self.flights
        return self.best is not None and (self.best.confirmed or left < self.settings.flights_each)

    def batch(self) -> Generator[Request, Scores, Batch]:
        """One turn: yields what it wants flown, is sent the scores, returns what came of it.

        Flights that meet the goal are flown again one by one, in order, until one fails; the tuner is told the mean cost and misses over
        all flights of a candidate, and otherwise the flight that failed. When the budget is spent, the last turn validates the best.
        """
        if self._searched and self.best is not None:
            self.validation, ledger, _ = yield from self._validate(self.best.parameters)
            return self._report(ledger, ())
        each = self.settings.flights_each
        parameters = self.tuner.ask(max(1, min(self.settings.batch, (self.settings.budget - self.flights) // each)))
        ledger, scores = yield from self._fly(Stream.SEARCH, np.repeat(parameters, each, axis=0))
        ledgers, flown = [ledger], [scores.rows(slice(i, i + each)) for i in range(0, len(scores), each)]
        before, confirmed, validation, fallen = self.search_flights, None, None, {}
        self.search_flights += len(scores)
        for i in np.flatnonzero(self.settings.goal.met(scores).reshape(-1, each).all(axis=1)).tolist():
            flown[i], again = yield from self._confirm(parameters[i], flown[i])
            ledgers += again
            if not self._confirmed(flown[i]):
                continue
            if self.settings.validation:
                validation, ledger, repeats = yield from self._validate(parameters[i])
                ledgers.append(ledger)
                if validation.rate < self.settings.reliability:
                    flown[i] = Scores.join([flown[i], repeats])
                    fallen[i] = validation
                    continue
            confirmed, self.search_flights = i, before + (i + 1) * each
            break
        told = Scores.join([_told(scores, self.settings.goal) for scores in flown])
        ledgers[0] = ledgers[0].accept(np.repeat(self.tuner.tell(parameters, told), each))
        held = {i: validation.rate for i, validation in fallen.items()}
        candidates = [_candidate(parameters[i], scores, confirmed == i, held.get(i, 0.0)) for i, scores in enumerate(flown)]
        self._choose(candidates, validation)
        return self._report(Ledger.join(ledgers), tuple(fallen.values()))

    def _choose(self, candidates: Sequence[Candidate], validation: Validation | None) -> None:
        """Keep the best candidate, with its validation if it has been confirmed."""
        known = [] if self.best is None else [self.best]
        best = max(known + list(candidates), key=lambda candidate: candidate.rank)
        if best is not self.best:
            self.best, self.validation = best, validation if best.confirmed else None

    def _report(self, ledger: Ledger, fallen: tuple[Validation, ...]) -> Batch:
        """What came of a turn."""
        assert self.best is not None, "a turn has flown"  # noqa: S101  our own mistake
        counts = self.flights, self.search_flights
        return Batch(ledger, self.best, self.validation, fallen, *counts, self.done, self._state())

    def _fly(self, stream: Stream, parameters: Parameters) -> Generator[Request, Scores, tuple[Ledger, Scores]]:
        """Fly with the next seeds of a stream."""
        count = len(parameters)
        number = self.validation_flights if stream is Stream.VALIDATION else self.flights
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

    def _validate(self, parameters: Parameters) -> Generator[Request, Scores, tuple[Validation, Ledger, Scores]]:
        """Fly a candidate, shape (S, K), with noise that the search never met."""
        repeated = np.repeat(parameters[None], self.settings.validation, axis=0)
        ledger, scores = yield from self._fly(Stream.VALIDATION, repeated)
        return Validation(len(scores), int(self.settings.goal.succeeded(scores).sum())), ledger, scores

    def _confirmed(self, flown: Scores) -> bool:
        """Whether a candidate's flight and all its re-flights met the goal."""
        return len(flown) == self.settings.flights_each + self.settings.confirm and bool(self.settings.goal.met(flown).all())

    def _state(self) -> dict[str, Any]:
        """Counts, the best candidate and the tuner, as plain JSON."""
        best = None if self.best is None else _write_candidate(self.best)
        flown = {stream.name: count for stream, count in self._flown.items()}
        validation = None if self.validation is None else asdict(self.validation)
        counts = {"flown": flown, "search_flights": self.search_flights}
        return {**counts, "best": best, "validation": validation, "tuner": self.tuner.state()}

    def _restore(self, state: dict[str, Any]) -> None:
        """The inverse of `_state`."""
        self._flown = {Stream[name]: count for name, count in state["flown"].items()}
        self.search_flights = state["search_flights"]
        self.best = None if state["best"] is None else _read_candidate(state["best"])
        self.validation = None if state["validation"] is None else Validation(**state["validation"])
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
    """Run independent tunings of one scenario in lockstep, so that their flights fill the lanes; each goes as it would alone.

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


def _told(flown: Scores, goal: Goal) -> Scores:
    """What the tuner hears of a candidate: the last flight that failed, or else the last, with the mean costs and misses of all of them."""
    failed = np.flatnonzero(~goal.met(flown))
    heard = int(failed[-1]) if len(failed) else len(flown) - 1
    means = {name: np.mean(getattr(flown, name), axis=0, keepdims=True) for name in ("cost", "dense")}
    reached = np.isfinite(flown.gate_miss)
    total = np.where(reached, flown.gate_miss, 0.0).sum(axis=0, keepdims=True)
    with np.errstate(invalid="ignore"):
        misses = total / reached.sum(axis=0)  # NaN where no flight got to a gate
    return replace(flown.rows(slice(heard, heard + 1)), gate_miss=misses, **means)


def _candidate(parameters: Parameters, flown: Scores, confirmed: bool, held: float) -> Candidate:
    """Means over the flights of some parameters, shape (S, K)."""
    laps, cost = flown.lap_time[np.isfinite(flown.lap_time)], float(flown.cost.mean())
    return Candidate(
        parameters=parameters,
        cost=cost if np.isfinite(cost) else float("inf"),
        completion=float(flown.completion.mean()),
        lap_time=float(laps.mean()) if len(laps) else float("nan"),
        flights=len(flown),
        confirmed=confirmed,
        held=held,
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
