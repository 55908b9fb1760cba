"""Log judge: a flight that really happened, seen by the judge of a race as it sees simulated ones."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from hotlap.analysis.log_frame import LogFrame
from hotlap.core.errors import InputError
from hotlap.core.records import Cause, End, Flights, Floats, Log
from hotlap.logs.flight_log import FlightLog, Signal
from hotlap.logs.hotlap_csv import FULL_THRUST
from hotlap.race.endings import in_words
from hotlap.race.race import GateRule
from hotlap.reference.scenario import Scenario

EDGE = 0.1  # s that a log may begin too late: the drone is at rest then


def judge_log(log: FlightLog, scenario: Scenario, frame: LogFrame) -> Flights:
    """Judge a log.

    It is looked at once a control period, as simulated flights are, with straight lines in between. Nobody saw what was flown in a gap of
    the positions: where a gate or a crash lies within one by such a line, the flight is lost where the gap begins.

    Args:
        log: with positions.
        scenario: that was flown.
        frame: where the log lies in the race.

    Returns:
        One flight with its record; one whose log ends before the judge has decided is lost.

    Raises:
        InputError: it begins after the start of the race.
    """
    from hotlap.flight.one_flight import OneFlight, prepare_batch  # noqa: PLC0415  the flight core loads a compiler

    period, position = scenario.race.controller.period, log.signals["position"]
    latest = scenario.reference.gate_times[-1] + scenario.race.judge.window[1] + 1.0
    times = np.arange(int(latest / period) + 2, dtype=np.float64) * period
    states = sample(log, frame, times)
    if not np.isfinite(states[0, :3]).all():
        late = position.times[0] - frame.start
        raise InputError(log.name, "", f"begins {late:.2f} s after the start of the race: start=... says when that was")
    rotors = scenario.race.vehicle.rotor_count

    def judged(seen: Floats) -> tuple[Flights, int]:
        """The verdict over states, and the last of them that it needed."""
        batch = prepare_batch(scenario, scenario.space.first_guess(len(scenario.segments))[None], np.zeros(1, dtype=np.int64))
        flight, unknown, last = OneFlight(batch), np.zeros(rotors), 0
        flight.begin(0)
        flight.see(seen[0], unknown)
        for last in range(1, len(seen)):
            if not np.isfinite(seen[last, :3]).all():
                flight.lose()
                last -= 1  # noqa: PLW2901  the sample before was the last
                break
            if flight.judge(seen[last], unknown):
                break
        return batch.record(), last

    flights, last = judged(states)
    hidden = _hidden(scenario, flights, gaps(log, frame))
    if hidden is not None:
        flights, last = judged(np.where((times > hidden)[:, None], np.nan, states))
    rows = slice(0, last + 1)
    record = Log(times[rows], states[rows], np.full((last + 1, rotors), np.nan), commands(log, frame, times[rows]))
    return replace(flights, logs={0: record})


def gaps(log: FlightLog, frame: LogFrame) -> Floats:
    """Gaps of the positions, shape (G, 2) [s] since the start of the race."""
    found = log.signals["position"].gaps() - frame.start
    return found[found[:, 1] > 0]


def _hidden(scenario: Scenario, flights: Flights, blind: Floats) -> float | None:
    """Begin [s] of the first gap in which straight lines have a gate, or a crash; None where there is none."""
    by_clock = scenario.race.judge.rule is GateRule.CLOCK
    moments = (flights.gate_times if by_clock else flights.closest_time[0])[: int(flights.gates_passed[0]) + 1]
    ends = flights.end_time if flights.end[0] == End.CRASHED and flights.cause[0] != Cause.LOST else []
    decided = np.array([*moments, *ends])
    within = [begin for begin, end in blind.tolist() if ((decided > begin) & (decided < end)).any()]
    return min(within, default=None)


def sample(log: FlightLog, frame: LogFrame, times: Floats) -> Floats:
    """States of a log, shape (times, 13), in the frame of the race; NaN where the log has no position.

    Args:
        log: with positions; velocities are differences of them where there are none, attitudes level, and rates 0.
        frame: where it lies in the race.
        times: shape (times,) [s] since the start.
    """
    moments, position = frame.start + times, log.signals["position"]
    moments = np.where((moments < position.times[0]) & (moments > position.times[0] - EDGE), position.times[0], moments)
    places = frame.points(position.at(moments))
    if "velocity" in log.signals:
        velocities = _held(log.signals["velocity"], moments)
    else:
        slopes = np.gradient(position.values, position.times, axis=0)
        velocities = np.column_stack([np.interp(moments, position.times, column) for column in slopes.T])
    attitudes = np.tile([1.0, 0.0, 0.0, 0.0], (len(times), 1))
    if "attitude" in log.signals:
        known = _held(log.signals["attitude"], moments)
        attitudes = frame.attitudes(known / np.maximum(np.linalg.norm(known, axis=1, keepdims=True), 1e-9))
    rates = _held(log.signals["rates"], moments) if "rates" in log.signals else np.zeros((len(times), 3))
    return np.hstack([places, attitudes, frame.vectors(velocities), rates])


def _held(signal: Signal, times: Floats) -> Floats:
    """A signal at some times; before its first sample and behind its last those."""
    return signal.at(np.clip(times, signal.times[0], signal.times[-1]))


def commands(log: FlightLog, frame: LogFrame, times: Floats) -> Floats:
    """Commands of a log, shape (times, 4): thrust per mass [m/s^2] and rates [rad/s]; NaN where they were not logged.

    A thrust that was logged as a share is one per mass where the log says what all of it is, else what the accelerometer felt.
    """
    moments, thrust, rates = frame.start + times, np.full((len(times), 1), np.nan), np.full((len(times), 3), np.nan)
    if "thrust_command" in log.signals and FULL_THRUST in log.facts:
        thrust = log.signals["thrust_command"].at(moments) * float(log.facts[FULL_THRUST])
    elif "acceleration" in log.signals:
        thrust = log.signals["acceleration"].at(moments)[:, 2:]
    if "rate_command" in log.signals:
        rates = log.signals["rate_command"].at(moments)
    return np.hstack([thrust, rates])


def missing(log: FlightLog, frame: LogFrame) -> Iterator[str]:
    """What a log lacks that the judge or the charts would take, a line each."""
    for begin, end in gaps(log, frame):
        yield f"position: no sample from {begin:.2f} to {end:.2f} s after the start: drawn straight, and no gate in there was seen"
    if "velocity" not in log.signals:
        yield "velocity: differences of the positions"
    if "attitude" not in log.signals:
        yield "attitude: not logged, drawn as level"
    if "rates" not in log.signals:
        yield "rates: not logged, so the judge's limit of them was not looked at"
    if "rate_command" not in log.signals:
        yield "commands: rates were not logged, so there is no effort"
    elif FULL_THRUST not in log.facts and "acceleration" in log.signals:
        yield "commanded thrust: what the accelerometer felt along the body's z axis"


def ending(scenario: Scenario, flights: Flights, log: FlightLog, frame: LogFrame) -> str:
    """How a flight that was judged ended, in words."""
    if flights.cause[0] == Cause.LOST:
        ahead = in_words(scenario.race, End.MISSED, int(flights.gates_passed[0])).removeprefix("missed ")
        for begin, end in gaps(log, frame).tolist():
            if abs(flights.end_time[0] - begin) <= 2 * scenario.race.controller.period:
                return f"was not seen from {begin:.2f} to {end:.2f} s after the start, where {ahead} was: the log has no positions there"
        return f"the log ends {flights.end_time[0]:.2f} s after the start, before {ahead}"
    cause, index = Cause(int(flights.cause[0])), int(flights.cause_index[0])
    return in_words(scenario.race, End(int(flights.end[0])), int(flights.gates_passed[0]), cause, index)
