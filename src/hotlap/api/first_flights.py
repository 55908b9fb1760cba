"""First flights: what flights with weights that nobody has tuned say about a race, and what would make them hold."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hotlap.api.flown import FlightsResult
from hotlap.api.progress import Quiet
from hotlap.api.scenarios import read_guess
from hotlap.api.wording import percent
from hotlap.core.counts import count
from hotlap.core.errors import PlanningError
from hotlap.core.parameters import Parameters
from hotlap.core.records import End
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.feasibility.finding import Finding, Level, note_if
from hotlap.feasibility.flown import rooms
from hotlap.feasibility.race import SAME_MASS, missing_mass, unknown_latency
from hotlap.first_guess.names import DEFAULT, LEARNED
from hotlap.race.race import NoiseSettings, Race
from hotlap.reference.scenario import Scenario
from hotlap.tuning.objective import Objective
from hotlap.worlds.world import World

EASY, SOME = 0.9, 0.1  # shares of complete flights
HALF = 0.5  # of the gates
DEAD = 0.1  # s within which no controller has done anything yet
MATTERS = 0.2  # difference of two shares of 50 flights that is no chance
WEIGHTS = 64  # drawn at random where nothing passes the first gate
FEW = 10  # flights before a tuning
SLOWER = 0.6  # of the thrust that a plan may use
BARELY = 1.15  # thrust-to-weight below which a plan makes no sense
SEED = 0  # the flights of `hotlap fly` by default


@dataclass(frozen=True)
class Tried:
    """Flights with weights that nobody has tuned.

    Attributes:
        name: of the weights.
        weights: shape (S, K).
        flown: how the flights ended.
    """

    name: str
    weights: Parameters
    flown: FlightsResult

    @property
    def flights(self) -> int:
        """How many."""
        return len(self.flown.scores)

    @property
    def dead(self) -> int:
        """How many crashed before any controller has done anything."""
        flights = self.flown.flights
        return int(((flights.end == End.CRASHED) & (flights.end_time <= DEAD)).sum())

    @property
    def share(self) -> float:
        """Of complete flights [-]."""
        return self.flown.complete.rate

    @property
    def passed(self) -> float:
        """Mean share of the gates that were passed [-]."""
        return float(self.flown.scores.completion.mean())

    @property
    def finding(self) -> Finding:
        """How many were complete, and how the others ended."""
        complete = self.flown.complete
        value = f"{complete.successes} of {count(complete.flights, 'flight')} complete"
        figures = {"complete": complete.successes, "flights": complete.flights, "passed_gates": self.passed}
        return Finding(self.name, value, ", ".join(self.flown.ends()), note_if(self.share < EASY), figures)


def describe_flights(scenario: Scenario, world: World, flights: int, slower: Callable[[Race], Scenario] | None = None) -> Iterator[Finding]:
    """What untuned weights do in a race, how hard it is by that, and what would help.

    Args:
        scenario: what is flown.
        world: where; it is ready to fly.
        flights: of each weights.
        slower: plans a race anew; None: what is flown cannot be planned.
    """
    tried = fly_untuned(scenario, world, flights)
    yield from (one.finding for one in tried)
    if tried[0].dead:
        remark = f"over within {DEAD:g} s, whatever the weights: look at the start and its noise"
        figures = {"dead": tried[0].dead, "flights": flights}
        yield Finding("dead at once", f"{tried[0].dead} of {count(flights, 'flight')}", remark, Level.WARNING, figures)
    best = max(tried, key=lambda one: (one.share, one.passed))
    doom = find_doom(scenario, world, tried)
    if doom is not None:
        figures = {"passing": 0, "weights": WEIGHTS}
        yield Finding("random weights", f"0 of {WEIGHTS}", f"pass gate 1: {doom.words}", Level.WARNING, figures)
    room = float(rooms(scenario.race, scenario.reference).min())
    yield _error(best, room)
    yield _difficulty(tried, best, hopeless=doom is not None and doom.crashed)
    if room > 0 and not (doom and doom.at_once):
        cured = yield from _advise(scenario, world, tried[0], best)
        if not cured and slower is not None and best.share < EASY:
            yield from _slow_down(scenario.race, world, best, slower)


def fly_untuned(scenario: Scenario, world: World, flights: int) -> tuple[Tried, ...]:
    """The default weights, and those that a tuning begins with where they are others."""
    weights = {"default weights": read_guess(DEFAULT, scenario, Quiet()), "first guess": read_guess(LEARNED, scenario, Quiet())}
    names = [name for name in weights if name == "default weights" or not np.array_equal(weights[name], weights["default weights"])]
    return tuple(Tried(name, weights[name], _fly(scenario, world, weights[name], flights)) for name in names)


@dataclass(frozen=True)
class Doom:
    """A race of which no weights that were tried pass the first gate.

    Attributes:
        at_once: whether all flights are over before a controller has done anything.
        crashed: whether all of them crash: weights are not what they lack.
        words: how they ended.
    """

    at_once: bool
    crashed: bool
    words: str


def find_doom(scenario: Scenario, world: World, tried: Sequence[Tried]) -> Doom | None:
    """How flights with weights drawn at random from all that there are end before the first gate; None where one passes it.

    They are flown only where what was tried never passed it.
    """
    if any(one.flown.flights.gates_passed.any() for one in tried):
        return None
    space, segments = scenario.space, len(scenario.segments)
    draws = np.random.default_rng(SEED).uniform(np.log(space.low), np.log(space.high), (WEIGHTS, space.size))
    flown = _fly_each(scenario, world, np.repeat(np.exp(draws)[:, None], segments, axis=1))
    if flown.flights.gates_passed.any():
        return None
    at_once = bool((flown.flights.end_time <= DEAD).all())
    words = ", ".join((*flown.ends(), *([f"all within {DEAD:g} s"] if at_once else [])))
    return Doom(at_once, bool((flown.flights.end == End.CRASHED).all()), words)


def say_doom(scenario: Scenario, world: World, *guesses: Parameters) -> str:
    """One line for who is about to tune a race that no weights can save; "" where some do.

    Args:
        scenario: what is flown.
        world: where; it is ready to fly.
        guesses: each of shape (S, K), that the search may begin with.
    """
    tried = [Tried("first guess", weights, _fly(scenario, world, weights, FEW)) for weights in guesses]
    doom = find_doom(scenario, world, tried)
    if doom is None:
        dead = min(one.dead for one in tried)
        return f"{dead} of {FEW} flights are over within {DEAD:g} s, whatever the weights" if dead else ""
    hopeless = "no weights help as it stands: " if doom.crashed else ""
    return f"{hopeless}of {WEIGHTS} weights drawn at random none passes gate 1 ({doom.words})"


def _fly(scenario: Scenario, world: World, weights: Parameters, flights: int) -> FlightsResult:
    """Weights of shape (S, K), flown so many times."""
    return _fly_each(scenario, world, np.repeat(weights[None], flights, axis=0))


def _fly_each(scenario: Scenario, world: World, weights: Parameters) -> FlightsResult:
    """Weights of shape (B, S, K), each flown once."""
    flights, scores = Objective(scenario, world).fly_recorded(weights, flight_seeds(SEED, Stream.DEMONSTRATION, 0, len(weights)))
    return FlightsResult(scenario, world.name, weights[0], flights, scores)


def _error(best: Tried, room: float) -> Finding:
    """The controller's mean error beside what the plan leaves for it at the gates, [m]."""
    error = float(best.flown.scores.mean_error.mean())
    remark = f"from the reference, by the {best.name}; it leaves {max(room, 0.0):.2f} m at the gates"
    return Finding("mean error", f"{error:.2f} m", remark, note_if(error > room), {"mean_error_m": error, "room_m": room})


def _difficulty(tried: Sequence[Tried], best: Tried, *, hopeless: bool) -> Finding:
    """A word for what was flown."""
    if hopeless:
        return Finding("difficulty", "beyond all weights", "that were flown", Level.WARNING)
    if tried[0].share >= EASY:
        return Finding("difficulty", "easy", "as flown: the default weights do")
    if best.share >= SOME or best.passed >= HALF:
        remark = "the first guess of a tuning does" if best.share >= EASY else "untuned weights pass some gates, or complete some flights"
        return Finding("difficulty", "moderate", f"as flown: {remark}")
    return Finding("difficulty", "hard", "as flown: untuned weights pass few gates")


def _advise(scenario: Scenario, world: World, default: Tried, best: Tried) -> Generator[Finding, None, bool]:
    """What would help, as flown: one change at a time, the weights the same; whether a setting alone does.

    Settings that are wrong are put right with the default weights, anything else is tried with the best.
    """
    cured = False
    for change in _changes(scenario.race):
        before = default if change.cures else best
        if before.share >= EASY:
            continue
        flown = _fly(replace(scenario, race=change.race), world, before.weights, before.flights)
        tried = Tried(change.name, before.weights, flown)
        if tried.share >= before.share + MATTERS:
            cured = cured or change.cures
            whose = f"{before.name}; " if change.cures and best is not default else ""
            yield replace(tried.finding, remark=whose + change.advice, level=Level.NOTE)
    return cured


def _slow_down(race: Race, world: World, best: Tried, slower: Callable[[Race], Scenario]) -> Iterator[Finding]:
    """Whether a plan that takes less of the thrust is followed."""
    share = round(SLOWER * race.planning_model.max_acceleration / race.control_model.max_acceleration, 2)
    calm = race.with_share(share)
    if race.planning.quadrotor is not None or calm.planning_model.thrust_to_weight < BARELY:
        return
    try:
        scenario = slower(calm)
    except PlanningError:
        return
    tried = max(fly_untuned(scenario, world, best.flights), key=lambda one: (one.share, one.passed))
    if (tried.share, tried.passed) > (best.share + MATTERS, 0) or tried.passed > best.passed + MATTERS:
        value = f"{tried.finding.value}, {percent(tried.passed)} of the gates" if tried.share < SOME else tried.finding.value
        remark = f"planning.thrust_share = {share:g}: {scenario.reference.lap_time:.2f} s"
        figures = {**tried.finding.figures, "thrust_share": share, "lap_time_s": scenario.reference.lap_time}
        yield Finding("with a slower plan", value, remark, Level.NOTE, figures)


@dataclass(frozen=True)
class Change:
    """Something that may be in the way, removed.

    Attributes:
        name: in words.
        race: without it.
        advice: what to do about it.
        cures: whether a setting alone removes it.
    """

    name: str
    race: Race
    advice: str
    cures: bool = False


def _changes(race: Race) -> Iterator[Change]:
    """What may be in the way, one after the other."""
    vehicle, model, known = race.vehicle, race.control_model, "with its dead time known"
    if abs(unknown_latency(race)) > 1e-9 and race.controller.predict:
        told = model.model_copy(update={"delay": vehicle.delay})
        yield Change(known, race.model_copy(update={"model": told}), f"set model.delay = {vehicle.delay:g}", cures=True)
    elif abs(unknown_latency(race)) > 1e-9:
        told = race.controller.model_copy(update={"predict": True})
        yield Change(known, race.model_copy(update={"model": vehicle, "controller": told}), "set controller.predict = true", cures=True)
    if abs(missing_mass(race)) >= SAME_MASS:
        told = model.model_copy(update={"mass": vehicle.mass})
        yield Change("with its weight known", race.model_copy(update={"model": told}), f"set model.mass = {vehicle.mass:g}", cures=True)
    gains, times = (tuple(float(2 * gain) for gain in vehicle.rate_gain), tuple(time / 2 for time in vehicle.motor_time))
    quick = vehicle.model_copy(update={"rate_gain": gains, "motor_time": times})
    yield Change("with half of its lag", race.model_copy(update={"vehicle": quick}), "quicker motors or a higher rate_gain would help")
    yield Change("without noise", race.model_copy(update={"noise": _no_noise()}), "the noise decides: is [noise] that of your drone?")


def _no_noise() -> NoiseSettings:
    """No noise at all."""
    times = {"time", "wind_time"}
    return NoiseSettings(**{name: 0.0 for name in NoiseSettings.model_fields if name not in times})
