"""One flight at a time, control step by control step: what a world needs whose drone is moved by another program.

Start, noise, controller, battery, judge and log are the functions of the kernel (`kernel`), in float64; only the plant is left out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters
from hotlap.core.records import Cause, Flights
from hotlap.flight.control_loop import ControlLoop, allocate_control_loop
from hotlap.flight.fly import prepare, record, settings_of
from hotlap.flight.job import Job, Settings
from hotlap.flight.judge import Gates, Verdicts, lose, new_verdicts
from hotlap.flight.kernel import Lane, actuate, add_measurement_noise, allocate_lanes, judge_period, start_flight
from hotlap.flight.kernel_cache import is_filled, keep
from hotlap.flight.lanes import as_numbers, borrow
from hotlap.flight.lending import lend, lend_parts
from hotlap.flight.numbers import COMPILE, Numbers, aligned_zeros
from hotlap.flight.plant import MASS, THRUST_FACTOR, VehicleState, allocate_vehicle_state
from hotlap.flight.registry import CONTROLLERS
from hotlap.reference.scenario import Scenario

Floats = NDArray[np.float64]

LOST = int(Cause.LOST)
PLAIN_ROTORS = 4  # that memory of a plain plant has room for


@dataclass(frozen=True)
class FlightBatch:
    """A batch of flights that are flown one by one; several threads may fly flights of it.

    Attributes:
        scenario: what is flown.
        job, settings, gates, verdicts: the batch, as compiled code takes it.
        log: indices of the flights that are recorded in full.
    """

    scenario: Scenario
    job: Job
    settings: Settings
    gates: Gates
    verdicts: Verdicts
    log: Sequence[int]

    @property
    def law(self) -> str:
        """The control law."""
        return self.scenario.race.controller.law

    def record(self) -> Flights:
        """What happened."""
        return record(self.scenario, self.job, self.gates, self.verdicts, self.log)

    def with_dead_time(self, periods: int) -> FlightBatch:
        """The same flights, whose commands act so many whole control periods later."""
        whole = np.full_like(self.job.delay_periods, periods)
        return FlightBatch(self.scenario, self.job._replace(delay_periods=whole), self.settings, self.gates, self.verdicts, self.log)


def prepare_batch(scenario: Scenario, parameters: Parameters, seeds: NDArray[np.int64], log: Sequence[int] = ()) -> FlightBatch:
    """A batch that has not been flown; arguments as for `World.fly`.

    Raises:
        HotlapError: arrays that do not fit together, or parameters that are not positive.
    """
    job, gates = prepare(scenario, parameters, seeds, Numbers.FLOAT64, None, log)
    settings = settings_of(scenario)._replace(sagging=bool(job.sags.any()))
    return FlightBatch(scenario, job, settings, gates, new_verdicts(len(seeds), len(gates.times)), log)


def needs_compiling(law: str) -> bool:
    """Whether the functions of a control law must be compiled before the next flight."""
    return not all(map(is_filled, _functions(law)))


class OneFlight:
    """Flies flights of a batch, one after the other.

    Args:
        batch: whose flights.
    """

    def __init__(self, batch: FlightBatch) -> None:
        self._batch, self._functions = batch, _functions(batch.law)
        job, settings = batch.job, batch.settings
        commands = max(int(job.delay_periods.max(initial=0)), settings.predicted_periods, settings.acted_periods) + 2
        self._memory = CONTROLLERS[batch.law].allocate(settings, 1, np.float64)
        self._loop, self._vehicle = allocate_control_loop(commands, 1, np.float64), _allocate_vehicle(settings.rotors)
        self._lane = allocate_lanes(1)

    def begin(self, flight: int) -> Floats:
        """Begin a flight of the batch; the state that its drone is to be placed in, shape (13,)."""
        self._functions.begin(*self._told, self._batch.gates.floor, self._memory, self._loop, self._vehicle, self._lane, flight)
        return self._vehicle.state[:13, 0].copy()

    @property
    def tick(self) -> int:
        """Control periods since the flight began."""
        return int(self._lane.tick[0])

    @property
    def thrust_factor(self) -> float:
        """By which the thrust of the drone differs from its vehicle's now: its bias, and what a battery has lost [-]."""
        return float(self._vehicle.disturbance[THRUST_FACTOR, 0])

    def see(self, state: Floats, rotor_thrusts: Floats) -> None:
        """Take in where the drone is.

        Args:
            state: shape (13,).
            rotor_thrusts: shape (rotors,) [N]; NaN where nobody knows: a battery is then drawn by what is commanded.
        """
        vehicle, rotors = self._vehicle, self._batch.settings.rotors
        turned = state[3:7] @ vehicle.state[3:7, 0] < 0  # q and -q are one attitude; the controller wants the nearer one
        vehicle.state[:13, 0] = state
        if turned:
            vehicle.state[3:7, 0] *= -1
        if self._batch.settings.sagging and np.isnan(rotor_thrusts).any():
            rotor_thrusts = np.full(rotors, vehicle.vehicle[MASS, 0] * max(float(vehicle.acting[0, 0]), 0.0) / rotors)
        vehicle.state[13 : 13 + rotors, 0] = np.sqrt(np.maximum(rotor_thrusts, 0.0))

    def command(self) -> tuple[Floats, Floats]:
        """One control step, from the state seen.

        Returns:
            The command that has acted until now, and the one that acts as soon as the rest of the dead time beyond whole periods is
            over, each of shape (4,), actuation noise included.
        """
        self._functions.control(*self._told, self._memory, self._loop, self._vehicle, self._lane)
        return self._vehicle.older[:, 0].copy(), self._vehicle.acting[:, 0].copy()

    def judge(self, state: Floats, rotor_thrusts: Floats) -> bool:
        """Judge a control period by where the drone is at its end, arguments as of `see`; whether the flight is over."""
        self._vehicle.before[:, 0] = self._vehicle.state[:3, 0]
        self.see(state, rotor_thrusts)
        told = (*self._told, self._batch.gates, self._batch.verdicts)
        return self._functions.judge(*told, self._loop, self._vehicle, self._lane)

    def lose(self) -> None:
        """End the flight where the drone was last seen, because nobody knows what became of it."""
        place = self._vehicle.state[:3, 0].copy()
        self._functions.lose(self._batch.verdicts, self._batch.gates, int(self._lane.flight[0]), self.tick * self._told[1].period, place)

    @property
    def _told(self) -> tuple[Job, Settings]:
        return self._batch.job, self._batch.settings


def _allocate_vehicle(rotors: int) -> VehicleState:
    """Memory of a vehicle, with room for all of its rotors."""
    memory = allocate_vehicle_state(1, np.float64)
    if rotors <= PLAIN_ROTORS:
        return memory
    state = aligned_zeros((13 + rotors, 1), np.float64)
    state[: len(memory.state)] = memory.state
    return memory._replace(state=state)


class _Functions(NamedTuple):
    """Compiled functions of one flight."""

    begin: Any
    control: Any
    judge: Any
    lose: Any


@cache
def _functions(law: str) -> _Functions:
    """The functions of a control law; those that do not depend on it are the same for all."""
    begin, aim, control = CONTROLLERS[law].begin, CONTROLLERS[law].aim, CONTROLLERS[law].control

    def begin_one(
        job: Job, s: Settings, floor: float, memory: Any, loop: ControlLoop, vehicle: VehicleState, lane: Lane, flight: int
    ) -> None:
        """Begin a flight."""
        start_flight(job, s, floor, loop, vehicle, lane, 0, flight)
        begin(job, s, memory, 0)

    def control_one(job: Job, s: Settings, memory: Any, loop: ControlLoop, vehicle: VehicleState, lane: Lane) -> None:
        """Measure, compute a command, and let it act."""
        job, memory, loop, vehicle, lane = borrow(job), borrow(memory), borrow(loop), borrow(vehicle), borrow(lane)
        for i in range(10):
            loop.seen[i, 0] = vehicle.state[i, 0]
        if s.measured_position + s.measured_velocity + s.measured_attitude > 0:
            add_measurement_noise(job, s, loop, lane, 0)
        lane.piece[0] = aim(job, s, memory, loop, 0, lane.flight[0], lane.piece[0], lane.tick[0] * s.period, s.period)
        control(s, as_numbers(memory, 0), as_numbers(loop, 0))
        actuate(job, s, loop, vehicle, lane, 0)

    compiled = keep(njit(**COMPILE)(begin_one), f"{law}-one-begin"), keep(njit(**COMPILE)(control_one), f"{law}-one-control")
    return _Functions(*compiled, _judge_one, _lose_one)


def _judged(job: Job, s: Settings, gates: Gates, verdicts: Verdicts, loop: ControlLoop, vehicle: VehicleState, lane: Lane) -> bool:
    """Judge a control period; whether the flight is over."""
    job, gates, verdicts = borrow(job), lend_parts(gates), lend(verdicts)
    return judge_period(job, s, gates, verdicts, borrow(loop), borrow(vehicle), borrow(lane), 0)


def _lost(verdicts: Verdicts, gates: Gates, flight: int, time: float, place: Floats) -> None:
    """End a flight whose drone nobody sees any more."""
    lose(lend(verdicts), flight, lend_parts(gates), LOST, time, (place[0], place[1], place[2]), math.nan)


_judge_one, _lose_one = keep(njit(**COMPILE)(_judged), "one-judge"), keep(njit(**COMPILE)(_lost), "one-lose")
