"""Scene: plan, gates and recorded flights of a scenario as plain arrays, for pictures, page and film."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.core.records import Cause, End, Flights
from hotlap.race.endings import in_words
from hotlap.race.race import GateRule, JudgeSettings, Race
from hotlap.reference.reference import Reference
from hotlap.reference.scenario import Scenario
from hotlap.reference.segmentation import Segments
from hotlap.report.structures import Structures, structures_of
from hotlap.tuning.scoring import score

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Trace:
    """One flight with its time series up to its end.

    Attributes:
        label: of its parameters ("best").
        seed: of its noise.
        times: shape (n,) [s].
        position: shape (n, 3) [m] (world).
        attitude: shape (n, 4) (w, x, y, z), body to world.
        speed: shape (n,) [m/s].
        error: shape (n,) [m] distance from the clocked reference.
        rates: shape (n, 3) [rad/s] (body).
        rotor_thrusts: shape (n, rotors) [N].
        commands: shape (n, 4): thrust per mass [m/s^2] and rates [rad/s].
        estimates: shape (n, 4): thrust effectiveness [-] and disturbance [m/s^2] (world); None where none are estimated.
        end: how the flight ended.
        ending: the same in words.
        end_time: [s] of the last passed gate, the miss or the crash.
        end_position: shape (3,) [m] (world) at that time.
        gates_passed: number of gates passed in a row from the first.
        lap_time: [s] at the last gate; NaN where it was not reached.
        seen_times: shape (M,) [s] when each gate's distance was measured; NaN where the flight did not get there.
        gate_distance: shape (M,) [m] as the judge measures it, under the rule "opening" scaled so that a gate counts within the judge's
            distance as under the others; NaN likewise.
    """

    label: str
    seed: int
    times: Floats
    position: Floats
    attitude: Floats
    speed: Floats
    error: Floats
    rates: Floats
    rotor_thrusts: Floats
    commands: Floats
    estimates: Floats | None
    end: End
    ending: str
    end_time: float
    end_position: Floats
    gates_passed: int
    lap_time: float
    seen_times: Floats
    gate_distance: Floats

    @property
    def failed(self) -> bool:
        """Whether a gate was not passed."""
        return self.gates_passed < len(self.gate_distance)


@dataclass(frozen=True)
class Repeats:
    """How several flights with the same parameters and different noise ended.

    Attributes:
        label: of the parameters ("best").
        flights: how many.
        complete: how many passed all gates.
        failures: shape (F, 3) [m] (world) where the others ended; those without a known end are left out.
        failed_gates: shape (F,) index of the gate that each of them did not pass.
        ends: F of them, how each of them ended, in words.
        mean_error: [m] mean tracking error of those that passed all gates; NaN where none did.
    """

    label: str
    flights: int
    complete: int
    failures: Floats
    failed_gates: NDArray[np.int64]
    ends: tuple[str, ...]
    mean_error: float = math.nan


@dataclass(frozen=True)
class Scene:
    """A scenario, and flights of it.

    Attributes:
        race: its name.
        reference: that was to be followed.
        segments: of the reference.
        gates: shape (M, 3) [m] (world).
        distance: [m] from its centre within which a gate without size is passed.
        structures: gates as they are drawn, obstacles, box.
        rule: when a gate counts as passed.
        traces: flights recorded in full, the most important first.
        repeats: all flights with the same parameters as the traces.
    """

    race: str
    reference: Reference
    segments: Segments
    gates: Floats
    distance: float
    structures: Structures
    rule: GateRule
    traces: tuple[Trace, ...] = ()
    repeats: tuple[Repeats, ...] = ()

    @property
    def path(self) -> Floats:
        """Positions of the plan, shape (rows, 3) [m] (world)."""
        return self.reference.position[: self.reference.planned_rows]

    @property
    def coloured_path(self) -> tuple[Floats, Floats]:
        """Position, shape (n, 3) [m] (world), and speed, shape (n,) [m/s], of the first flight, or of the plan where nothing was flown."""
        return (self.traces[0].position, self.traces[0].speed) if self.traces else (self.path, self.reference.speeds)

    @property
    def failures(self) -> tuple[Floats, ...]:
        """Where failed flights ended, for each set of parameters, shape (F, 3) [m] (world); of the traces where nothing else was flown."""
        if self.repeats:
            return tuple(repeats.failures for repeats in self.repeats)
        ends = [(flight, flight.end_position[None]) for flight in self.traces]
        return tuple(end if flight.failed and np.isfinite(end).all() else end[:0] for flight, end in ends)


def stage(scenario: Scenario, traces: tuple[Trace, ...] = (), repeats: tuple[Repeats, ...] = ()) -> Scene:
    """The scene of a scenario, with flights where there are any."""
    race, distance = scenario.race, scenario.race.judge.distance
    gates, structures = race.track.gate_positions, structures_of(race.track, distance)
    return Scene(race.name, scenario.reference, scenario.segments, gates, distance, structures, race.judge.rule, traces, repeats)


def trace(scenario: Scenario, flights: Flights, index: int, label: str) -> Trace:
    """The time series of one flight of a batch.

    Args:
        scenario: that was flown.
        flights: the batch, with a log of this flight.
        index: of the flight in the batch.
        label: of its parameters.
    """
    log, end, end_time = flights.logs[index], End(int(flights.end[index])), float(flights.end_time[index])
    last = scenario.reference.duration if end is End.FINISHED else end_time
    rows = (log.times <= last + 1e-9) & np.isfinite(log.states[:, :10]).all(axis=1)
    times, states = log.times[rows], log.states[rows]
    clocked = flights.clock_distance[index] if scenario.race.judge.rule is GateRule.CLOCK else None
    return Trace(
        label=label,
        seed=int(flights.seeds[index]),
        times=times,
        position=states[:, :3],
        attitude=states[:, 3:7],
        speed=np.linalg.norm(states[:, 7:10], axis=1),
        error=np.linalg.norm(states[:, :3] - scenario.reference.position_at(times), axis=1),
        rates=states[:, 10:13],
        rotor_thrusts=log.rotor_thrusts[rows],
        commands=log.commands[rows],
        estimates=log.estimates[rows] if scenario.offset_free and log.estimates is not None else None,
        end=end,
        ending=_ending(scenario.race, flights, index),
        end_time=end_time,
        end_position=flights.end_position[index],
        gates_passed=int(flights.gates_passed[index]),
        lap_time=float(flights.lap_time[index]),
        seen_times=flights.closest_time[index] if clocked is None else np.where(np.isnan(clocked), np.nan, flights.gate_times),
        gate_distance=_comparable(flights, scenario.race.judge)[index],
    )


def _comparable(flights: Flights, judge: JudgeSettings) -> Floats:
    """Distances from all gates, shape (B, M) [m]: below the judge's distance where a gate was passed."""
    distance = score(flights, judge).gate_distance
    return distance if judge.rule is not GateRule.OPENING else distance * (judge.distance / flights.rooms)


def _ending(race: Race, flights: Flights, index: int) -> str:
    """How one flight ended, in words."""
    cause, touched = Cause(int(flights.cause[index])), int(flights.cause_index[index])
    return in_words(race, End(int(flights.end[index])), int(flights.gates_passed[index]), cause, touched)


def repeat(race: Race, flights: Flights, rows: slice, label: str) -> Repeats:
    """How the flights in some rows of a batch, all with the same parameters, ended."""
    passed, places = flights.gates_passed[rows], flights.end_position[rows]
    failed = passed < len(flights.gate_positions)
    known = failed & np.isfinite(places).all(axis=1)
    words = tuple(_ending(race, flights, index) for index in np.arange(len(flights))[rows][known].tolist())
    error = float(flights.mean_error[rows][~failed].mean()) if not failed.all() else math.nan
    return Repeats(label, len(failed), int((~failed).sum()), places[known], passed[known], words, error)
