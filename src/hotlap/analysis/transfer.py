"""Transfer: the same parameters flown with the same noise in several worlds; each flight is kept as soon as it has ended."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.analysis.resumable import Progress, digest_code, no_progress
from hotlap.analysis.time_left import TimeLeft
from hotlap.core.counts import count
from hotlap.core.errors import InputError
from hotlap.core.parameters import Parameters
from hotlap.core.records import Cause, End, Flights, Scores
from hotlap.core.shown import Shown, in_full
from hotlap.core.success_rate import Validation
from hotlap.race.endings import in_words
from hotlap.reference.scenario import Scenario
from hotlap.system.engine import Engine
from hotlap.system.journal import Journal
from hotlap.tuning.objective import Objective
from hotlap.worlds.on_workers import OnWorkers, simulators_here
from hotlap.worlds.world import World

Floats = NDArray[np.float64]

TUNED, DEFAULT = "tuned", "default"
DIGITS = 4  # of metres, in what is kept
FINE = 0.095  # m, below which three digits are shown
STARTING = 1.0  # s within which an error is still that of the start, which the noise draws
Trip = tuple[str, str, int]
"""World, set of parameters and seed of a flight."""
ATTEMPTS = 3  # at a flight that is lost


@dataclass(frozen=True, repr=False)
class TransferFlight(Shown):
    """A flight in one of several worlds.

    Attributes:
        world: its name.
        label: of the parameters.
        seed: of the noise.
        completion: gates passed / gates, 0 to 1.
        lap_time: [s]; NaN where the last gate was not reached.
        mean_error: [m] distance from the clocked reference until the end; NaN where there is none.
        max_error: [m] likewise.
        ending: how it ended, in words.
        end_time: [s] of the last passed gate, the miss or the crash.
        times: shape (steps,) [s] of the control steps until its end.
        errors: shape (steps,) [m] distance from the clocked reference at these times.
    """

    world: str
    label: str
    seed: int
    completion: float
    lap_time: float
    mean_error: float
    max_error: float
    ending: str
    end_time: float
    times: Floats
    errors: Floats

    @property
    def complete(self) -> bool:
        """Whether every gate was passed."""
        return self.completion >= 1.0

    @property
    def later_error(self) -> float:
        """[m] largest error after the start; of the whole flight where it ended before; NaN where there is none."""
        later = self.errors[self.times >= STARTING]
        return float((later if len(later) else self.errors).max()) if len(self.errors) else math.nan

    def summary(self) -> dict[str, Any]:
        """All but the series, as plain values."""
        return {item.name: getattr(self, item.name) for item in fields(self) if item.name not in {"times", "errors"}}

    def dump(self) -> dict[str, Any]:
        """As plain JSON; None for what does not exist."""
        finite = {key: None if isinstance(value, float) and math.isnan(value) else value for key, value in self.summary().items()}
        return {**finite, "times": self.times.round(6).tolist(), "errors": self.errors.round(DIGITS).tolist()}

    @classmethod
    def load(cls, plain: Mapping[str, Any]) -> TransferFlight:
        """The inverse of `dump`."""
        values = {key: math.nan if value is None else value for key, value in plain.items()}
        return cls(**{**values, "times": np.array(plain["times"], dtype=float), "errors": np.array(plain["errors"], dtype=float)})


@dataclass(frozen=True, repr=False)
class TransferRow(Shown):
    """Flights with the same parameters in one world.

    Attributes:
        world: its name.
        label: of the parameters.
        flights: one at least.
    """

    world: str
    label: str
    flights: tuple[TransferFlight, ...]

    @property
    def complete(self) -> Validation:
        """How many flights passed every gate."""
        return Validation(len(self.flights), sum(flight.complete for flight in self.flights))

    @property
    def mean_error(self) -> float:
        """[m] mean over all flights."""
        return float(np.mean([flight.mean_error for flight in self.flights]))

    @property
    def max_error(self) -> float:
        """[m] largest error of a flight, mean over all flights."""
        return float(np.mean([flight.max_error for flight in self.flights]))

    @property
    def later_error(self) -> float:
        """[m] largest error of a flight after its start, mean over all flights."""
        return float(np.mean([flight.later_error for flight in self.flights]))

    @property
    def errors(self) -> Floats:
        """[m] of all control steps of all flights."""
        return np.concatenate([flight.errors for flight in self.flights])

    @property
    def lap_time(self) -> float:
        """[s] mean of complete flights; NaN where there are none."""
        laps = [flight.lap_time for flight in self.flights if flight.complete]
        return float(np.mean(laps)) if laps else math.nan

    def dump(self) -> dict[str, Any]:
        """As plain values, without the series."""
        errors = self.errors
        return {
            "world": self.world,
            "parameters": self.label,
            "flights": len(self.flights),
            "successes": self.complete.successes,
            "mean_errors": [flight.mean_error for flight in self.flights],
            "max_errors": [flight.max_error for flight in self.flights],
            "median_error": float(np.median(errors)) if len(errors) else math.nan,
            "lap_time": self.lap_time,
        }


def rows_of(flights: Iterable[TransferFlight]) -> list[TransferRow]:
    """Flights by world and parameters, in the order in which these appear."""
    groups: dict[tuple[str, str], list[TransferFlight]] = {}
    for flight in flights:
        groups.setdefault((flight.world, flight.label), []).append(flight)
    return [TransferRow(world, label, tuple(group)) for (world, label), group in groups.items()]


@dataclass(frozen=True)
class Journey:
    """What is flown in several worlds; flights go on after a missed gate, so that errors are of whole flights.

    Attributes:
        scenario: race, reference, segments.
        sets: parameters, shape (S, K), by what they are called.
        worlds: in which all of them are flown.
        seeds: shape (F,), the noise of the flights of each set in each world.
    """

    scenario: Scenario
    sets: Mapping[str, Parameters]
    worlds: Sequence[World]
    seeds: NDArray[np.int64]

    @cached_property
    def flown(self) -> Scenario:
        """The scenario, whose flights go on after a missed gate."""
        race = self.scenario.race
        judge = race.judge.model_copy(update={"fly_on": True})
        return replace(self.scenario, race=race.model_copy(update={"judge": judge}))

    def open(self, folder: Path) -> list[World]:
        """Open the worlds in which flights are missing, so that one that is not there is told before anything is flown.

        Args:
            folder: where flights are kept.

        Returns:
            These worlds.

        Raises:
            InputError: one cannot be opened.
            StudyError: what is kept cannot be read.
        """
        waiting = {name for name, _, _ in self._missing(Journal(folder, digest_code(__name__)))}
        wanted = [world for world in self.worlds if world.name in waiting]
        for world in wanted:
            opening = getattr(world, "open", None)
            if opening is not None:
                opening(self.flown)
        return wanted

    def fly(self, folder: Path, progress: Progress = no_progress, note: Callable[[str], None] = lambda _: None) -> list[TransferFlight]:
        """Fly what is missing in a folder, in all worlds in turn; they are opened first, and closed at the end.

        Args:
            folder: where flights are kept, made if there is none.
            progress: shows how far it is.
            note: called with a line that a person should know of.

        Returns:
            All flights: world by world, set by set.

        Raises:
            InputError: a world cannot be opened, or is lost time and again.
            StudyError: the folder cannot be used.
        """
        keys, opened = self._keys(), self.open(folder)
        try:
            with Journal.opened(folder, digest_code(__name__)) as kept:
                self._fly_missing(kept, progress, note)
                return [TransferFlight.load(kept.done[key]) for key in keys.values()]
        finally:
            for world in opened:
                closing = getattr(world, "close", None)
                if closing is not None:
                    closing()

    def _fly_missing(self, kept: Journal, progress: Progress, note: Callable[[str], None]) -> None:
        """Fly what is not kept, and keep it."""
        keys, worlds, missing = self._keys(), {world.name: world for world in self.worlds}, self._missing(kept)
        if any(key in kept.stale for key in keys.values()):
            note(f"{kept.path}: flights by other source code than this are not used; they are flown again")
        left = TimeLeft(name for name, _, _ in missing)
        with progress("flights", len(keys), len(keys) - len(missing)) as say:
            for trip, flight in self._fly_trips(missing, worlds):
                kept.add(keys[trip], flight.dump())
                say(_describe(flight, left.after(trip[0])))

    def _fly_trips(self, trips: Sequence[Trip], worlds: Mapping[str, World]) -> Iterator[tuple[Trip, TransferFlight]]:
        """Fly here, one after the other, what is not flown on workers, and then what is."""
        abroad: dict[int, tuple[Engine, list[tuple[Journey, Trip]]]] = {}
        for trip in trips:
            name, label, seed = trip
            world = worlds[name]
            if isinstance(world, OnWorkers):
                alone = replace(self, sets={label: self.sets[label]}, worlds=(), seeds=np.array([seed], dtype=np.int64))
                abroad.setdefault(id(world.engine), (world.engine, []))[1].append((alone, trip))
            else:
                yield trip, self.fly_one(world, label, seed)
        for engine, pieces in abroad.values():
            for (_, trip), flight in engine.spread(fly_trip, pieces):
                yield trip, flight

    def _missing(self, kept: Journal) -> list[Trip]:
        """World, set and seed of the flights that are not kept: the first of each world and set before the second of any.

        So the time that is left is known early.
        """
        keys = self._keys()
        in_turn = [(world.name, label, seed) for seed in self.seeds.tolist() for world in self.worlds for label in self.sets]
        return [trip for trip in in_turn if keys[trip] not in kept.done]

    def _keys(self) -> dict[Trip, str]:
        """Names by which flights are kept, by world, set and seed; they change with everything that decides about a flight."""
        reference, segments = self.scenario.reference, self.scenario.segments
        arrays = [values.tobytes() for values in (reference.table, reference.gate_times, segments.starts)]
        fixed = self.flown.race.model_dump_json(), arrays, segments.owners
        digests = {label: _digest(fixed, values.tobytes()) for label, values in self.sets.items()}
        return {
            (world.name, label, seed): f"{world.name}, {label}, seed {seed} #{digests[label]}"
            for world in self.worlds
            for label in self.sets
            for seed in self.seeds.tolist()
        }

    def fly_one(self, world: World, label: str, seed: int) -> TransferFlight:
        """One flight; one that was lost, whose end nobody knows, is flown again.

        Raises:
            InputError: the world is lost time and again.
        """
        objective, seeds = Objective(self.flown, world), np.array([seed], dtype=np.int64)
        for _ in range(ATTEMPTS):
            flights, scores = objective.fly_recorded(self.sets[label][None], seeds, log=(0,))
            if flights.cause[0] != Cause.LOST:
                return self._record(world, label, flights, scores)
        raise InputError("", "on", f"{world.name} was lost in {count(ATTEMPTS, 'flight')} in a row")

    def _record(self, world: World, label: str, flights: Flights, scores: Scores) -> TransferFlight:
        """What is kept of a batch of one flight."""
        end, log = End(int(flights.end[0])), flights.logs[0]
        known = np.isfinite(log.states[:, :3]).all(axis=1)
        times, places = log.times[known], log.states[known, :3]
        cause = Cause(int(flights.cause[0])), int(flights.cause_index[0])
        return TransferFlight(
            world=world.name,
            label=label,
            seed=int(flights.seeds[0]),
            completion=float(scores.completion[0]),
            lap_time=float(scores.lap_time[0]),
            mean_error=float(flights.mean_error[0]),
            max_error=float(flights.max_error[0]),
            ending=in_words(self.scenario.race, end, int(flights.gates_passed[0]), *cause),
            end_time=float(flights.end_time[0]),
            times=times,
            errors=np.linalg.norm(places - self.scenario.reference.position_at(times), axis=1),
        )


def fly_trip(piece: tuple[Journey, Trip]) -> Iterator[TransferFlight]:
    """One flight, on a worker."""
    journey, (name, label, seed) = piece
    yield journey.fly_one(simulators_here(name), label, seed)


def metres(error: float) -> str:
    """An error for people: 0.69, 0.025; "-" where there is none."""
    return "-" if math.isnan(error) else f"{error:.2f}" if error >= FINE else f"{error:.3f}"


def _describe(flight: TransferFlight, left: str) -> str:
    """A flight in few words, and the time that all others will take."""
    told = f"{flight.world}: {flight.label}, {flight.ending}, {metres(flight.mean_error)} m"
    return f"{told}; {left}" if left else told


def _digest(*values: Any) -> str:
    """Sixteen hexadecimal digits that change with anything in the values."""
    return hashlib.sha256(in_full(values).encode()).hexdigest()[:16]
