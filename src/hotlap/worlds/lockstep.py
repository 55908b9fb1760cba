"""Lockstep: flights of a batch in the lanes of one simulator; a lane begins the next flight when its own has ended."""

from __future__ import annotations

import threading
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from hotlap.flight.one_flight import FlightBatch, OneFlight
from hotlap.worlds.clock import Clock, carry
from hotlap.worlds.instance import LOSSES, Instance
from hotlap.worlds.simulator import Simulator, SimulatorError, Start

Floats = NDArray[np.float64]

CROOKED = 0.01  # by which the length of a quaternion may differ from 1


class FlightQueue:
    """Flights of a batch that wait for a lane; several threads take from it.

    Args:
        flights: how many there are.
        watch: called after each flight with how many have ended.
    """

    def __init__(self, flights: int, watch: Callable[[int], None]) -> None:
        self._waiting, self._ended, self._watch = list(range(flights))[::-1], 0, watch
        self._lock, self._stop = threading.Lock(), threading.Event()

    def take(self) -> int | None:
        """The next flight; None where there is none."""
        with self._lock:
            return self._waiting.pop() if self._waiting and not self.stopped else None

    def give_back(self, flight: int) -> None:
        """A flight that is still to be flown."""
        with self._lock:
            self._waiting.append(flight)

    def end(self) -> None:
        """Count a flight that has ended."""
        with self._lock:
            self._ended += 1
            self._watch(self._ended)

    def stop(self) -> None:
        """Let nobody fly on."""
        self._stop.set()

    @property
    def stopped(self) -> bool:
        """Whether nobody is to fly on."""
        return self._stop.is_set()


def fly_queue(batch: FlightBatch, instance: Instance, queue: FlightQueue, note: Callable[[str], None]) -> None:
    """Fly flights of a queue in one simulator, until there are none.

    Args:
        batch: whose flights.
        instance: the simulator.
        queue: others may take from it meanwhile.
        note: called with a line when the simulator was lost.

    Raises:
        InputError: the simulator cannot be opened, or was lost time and again.
    """
    while (flight := queue.take()) is not None:
        simulator, clock = instance.simulator(batch.scenario)
        lanes = Lockstep(batch, simulator, clock, queue, instance.has_flown)
        try:
            lanes.fly(flight)
        except LOSSES as error:
            lost = lanes.abandon()
            instance.lose(error)
            note(f"{error}; {'no flight' if not lost else '1 flight' if lost == 1 else f'{lost} flights'} lost, the next one opens it anew")


class Lockstep:
    """The lanes of one simulator.

    Args:
        batch: whose flights.
        simulator: ready to be reset.
        clock: of its steps.
        queue: of the flights.
        has_flown: called after each flight.
    """

    def __init__(
        self, batch: FlightBatch, simulator: Simulator, clock: Clock, queue: FlightQueue, has_flown: Callable[[], None] = lambda: None
    ) -> None:
        self._simulator, self._clock, self._queue, self._has_flown = simulator, clock, queue, has_flown
        self._drones = [OneFlight(batch.with_dead_time(clock.delay_periods)) for _ in range(simulator.lanes)]
        self._flights: list[int | None] = [None] * simulator.lanes
        self._rotors = batch.settings.rotors
        self._factors = np.ones(simulator.lanes)
        self._hover = np.tile([batch.settings.gravity, 0.0, 0.0, 0.0], (simulator.lanes, 1))

    @property
    def _busy(self) -> list[int]:
        """Lanes that fly."""
        return [lane for lane, flight in enumerate(self._flights) if flight is not None]

    def fly(self, flight: int) -> None:
        """Fly a flight, and those that wait, until there are none."""
        self._begin(0, flight)
        for lane in range(1, len(self._flights)):
            self._begin(lane, self._queue.take())
        self._look(self._busy)
        while self._busy and not self._queue.stopped:
            self._fly_period()

    def abandon(self) -> int:
        """End the flights that were under way as lost, and give back those that had not begun; how many are lost."""
        lost = 0
        for lane in self._busy:
            drone, flight, self._flights[lane] = self._drones[lane], self._flights[lane], None
            assert flight is not None, "the lane is busy"  # noqa: S101  our own mistake
            if drone.tick:
                drone.lose()
                self._queue.end()
                lost += 1
            else:
                self._queue.give_back(flight)
        return lost

    def _begin(self, lane: int, flight: int | None) -> None:
        """Begin a flight in a lane, or leave it idle."""
        self._flights[lane] = flight
        if flight is None:
            return
        drone = self._drones[lane]
        state = drone.begin(flight)
        self._factors[lane] = drone.thrust_factor if self._simulator.scales_thrust else 1.0
        self._simulator.reset(lane, Start(state, float(self._factors[lane])))

    def _fly_period(self) -> None:
        """One control period in all lanes."""
        older, acting = self._hover.copy(), self._hover.copy()
        for lane in self._busy:
            drone = self._drones[lane]
            older[lane], acting[lane] = drone.command()
            for command in (older, acting):
                command[lane, 0] *= drone.thrust_factor / self._factors[lane]
        tick = self._drones[self._busy[0]].tick  # only where there is one lane do periods differ
        steps, step = self._clock.steps_in(tick), self._clock.step
        late = min(self._clock.older_steps, steps)
        for command, part in ((older, late), (acting, steps - late)):
            if part:
                self._simulator.advance(command, part * step)
        states, thrusts = self._read()
        fresh = []
        for lane in self._busy:
            if self._drones[lane].judge(carry(states[lane], self._clock.rest_after(tick)), thrusts[lane]):
                self._flights[lane] = None
                self._has_flown()
                self._queue.end()
                fresh.append(lane)
        for lane in fresh:
            self._begin(lane, self._queue.take())
        self._look([lane for lane in fresh if self._flights[lane] is not None])

    def _look(self, lanes: list[int]) -> None:
        """See where drones are that have just been placed."""
        if lanes:
            states, thrusts = self._read()
            for lane in lanes:
                self._drones[lane].see(states[lane], thrusts[lane])

    def _read(self) -> tuple[Floats, Floats]:
        """States and rotor thrusts of all lanes; a state that is not finite has no place.

        Raises:
            SimulatorError: they are none.
        """
        count = len(self._flights)
        states = np.array(self._simulator.states(), dtype=np.float64)
        thrusts = np.array(self._simulator.rotor_thrusts(), dtype=np.float64)
        if states.shape != (count, 13) or thrusts.shape != (count, self._rotors):
            raise SimulatorError(f"states of shape {states.shape} and rotor thrusts of shape {thrusts.shape} are none of {count} drones")
        whole = np.array([bool(np.isfinite(state).all()) for state in states])
        states[~whole, :3] = np.nan
        lengths = [float(np.linalg.norm(state[3:7])) for state in states]
        for lane in self._busy:
            if whole[lane] and abs(lengths[lane] - 1) > CROOKED:
                raise SimulatorError(f"an attitude with a quaternion of length {lengths[lane]:.3g} is none")
        return states, thrusts
