"""Legs: what gives the commands of a part of a real flight: the tuned controller on a reference, the reference alone, or a ramp."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from hotlap.core.parameters import Parameters
from hotlap.core.records import Floats
from hotlap.flight.observer import EFFECTIVENESS_LIMITS
from hotlap.real_flight.heeding import HeedingController
from hotlap.real_flight.link import Seen
from hotlap.real_flight.order import Order
from hotlap.reference.attitude import thrust_axis
from hotlap.reference.scenario import Scenario

FIRST, LAST, RAMP = 0.3, 1.8, 0.25  # g, g, g/s: the ramp of a take-off
LEVELLING, LARGEST_RATE = 3.0, 0.6  # 1/s, rad/s: on the ground, where a rate loop has nothing to turn
TIPPED = 0.35  # rad from how it stood, on the ground
RISEN, RISING = 0.05, 0.15  # m, m/s: a drone that has taken off


class Leg(Protocol):
    """A part of a flight."""

    def order(self, seen: Seen) -> Order:
        """The command for a state; called in order of time."""
        ...


class Along:
    """A reference, flown by the vehicle's own controller; its time begins with the first order.

    What such a vehicle is told is the reference; thrust and rates of an order are those of the reference, too.

    Args:
        scenario: the reference.
        races: whether it is the race itself.

    Attributes:
        begun: [s] of the vehicle's clock at which it began; NaN before.
        duration: [s] until the last row of the reference.
    """

    def __init__(self, scenario: Scenario, *, races: bool = False) -> None:
        self.scenario, self.begun, self._races = scenario, math.nan, races
        self.duration = (len(scenario.reference.position) - 1) * scenario.reference.period
        self._gravity = scenario.race.control_model.gravity

    def begin(self, now: float) -> None:
        """Begin at a time [s] of the vehicle's clock."""
        self.begun = now

    def time_of(self, seen: Seen) -> float:
        """[s] of the reference now."""
        return seen.now - self.begun

    def order(self, seen: Seen) -> Order:
        """One control step."""
        if math.isnan(self.begun):
            self.begin(seen.now)
        time = self.time_of(seen)
        command, estimates = self._command(time, seen)
        reference, acceleration = self.reference_at(time)
        return Order(float(command[0]), command[1:], reference, acceleration, estimates, time if self._races else None)

    def heed(self, seen: Seen, order: Order) -> None:
        """One control step whose command is not flown, but that of another leg: so it knows what acts when its own turn comes."""

    def reference_at(self, time: float) -> tuple[Floats, Floats]:
        """State, shape (13,), and acceleration, shape (3,) [m/s^2] (race), of the reference at a time [s]."""
        state, thrust = self._row(time)
        return state, thrust * thrust_axis(state[3:7]) - np.array([0.0, 0.0, self._gravity])

    def _command(self, time: float, seen: Seen) -> tuple[Floats, Floats]:
        """Thrust and rates, shape (4,), and estimates, shape (4,)."""
        del seen  # whose controller looks at it is not ours
        state, thrust = self._row(time)
        return np.array([thrust, *state[10:13]]), np.array([1.0, 0.0, 0.0, 0.0])

    def _row(self, time: float) -> tuple[Floats, float]:
        """State, shape (13,), and thrust [m/s^2] of the reference at a time [s]."""
        reference = self.scenario.reference
        place = min(max(time / reference.period, 0.0), len(reference.position) - 1)
        row = min(int(place), len(reference.position) - 2)
        share = place - row
        both = slice(row, row + 2)
        parts = (reference.position[both], reference.attitude[both], reference.velocity[both], reference.rates[both])
        state = np.concatenate([(1 - share) * part[0] + share * part[1] for part in parts])
        state[3:7] /= np.linalg.norm(state[3:7])
        return state, float((1 - share) * reference.thrust[row] + share * reference.thrust[row + 1])


class Guided(Along):
    """The controller on a reference.

    Args:
        scenario: the reference, and the controller that flies it.
        parameters: shape (S, K).
        races: whether it is the race itself.
    """

    def __init__(self, scenario: Scenario, parameters: Parameters, *, races: bool = False) -> None:
        super().__init__(scenario, races=races)
        self._controller = HeedingController(scenario, parameters)
        start = np.concatenate([scenario.reference.position[0], scenario.reference.attitude[0], scenario.reference.velocity[0]])
        self._controller.command(0.0, start, 0.01)  # so that nothing is compiled, or loaded, in flight
        self._controller.reset()

    def begin(self, now: float, effectiveness: float = 1.0) -> None:
        """Begin at a time [s] of the vehicle's clock, with a first estimate of the thrust that acts over that commanded [-]."""
        super().begin(now)
        if self._controller.is_offset_free:
            low, high = EFFECTIVENESS_LIMITS
            self._controller.reset(min(max(effectiveness, low), high))
        else:
            self._controller.reset()

    def heed(self, seen: Seen, order: Order) -> None:
        """See `Along`."""
        time = self.time_of(seen)
        self._controller.heed(time, seen.state, max(seen.age, 0.0), np.array([order.thrust, *order.rates]))

    def _command(self, time: float, seen: Seen) -> tuple[Floats, Floats]:
        command = self._controller.command(time, seen.state, max(seen.age, 0.0))
        return command, np.append(self._controller.thrust_effectiveness, self._controller.disturbance)


class TakeOff:
    """A ramp of thrust until the drone has left the ground; the thrust that has lifted it says what its thrust is worth.

    Args:
        ground: shape (13,) state on the ground (race).
        gravity: [m/s^2].
        lag: [s] from a command to its thrust.
    """

    def __init__(self, ground: Floats, gravity: float, lag: float) -> None:
        self._ground, self._gravity, self._lag, self._begun, self._age = ground, gravity, lag, math.nan, 0.0

    def order(self, seen: Seen) -> Order:
        """More thrust than before, and as level as it stands."""
        if math.isnan(self._begun):
            self._begun = seen.now
        self._age = seen.age
        _, x, y, _ = seen.state[3:7].tolist()
        rates = np.clip([-2 * LEVELLING * x, -2 * LEVELLING * y, 0.0], -LARGEST_RATE, LARGEST_RATE)
        return Order(self._thrust(seen.now), rates, self._ground, np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))

    def has_lifted(self, seen: Seen) -> bool:
        """Whether it has left the ground."""
        return bool(seen.state[2] - self._ground[2] > RISEN and seen.state[9] > RISING)

    def has_tipped(self, seen: Seen) -> bool:
        """Whether something holds it on one side, so that it falls over."""
        return float(thrust_axis(seen.state[3:7]) @ thrust_axis(self._ground[3:7])) < math.cos(TIPPED)

    def has_failed(self, seen: Seen) -> bool:
        """Whether the ramp has ended, and it still stands."""
        return self._thrust(seen.now) >= LAST * self._gravity

    def effectiveness(self, seen: Seen) -> float:
        """Thrust that acts over thrust that was asked for [-], as it lifts: v = r t^2 / 2 under a ramp r since it was the weight."""
        ramp = RAMP * self._gravity
        since = math.sqrt(2 * max(float(seen.state[9]), 0.0) / ramp)
        lifting = self._thrust(seen.now) - ramp * (since + self._lag + self._age)
        return self._gravity / max(lifting, 0.1 * self._gravity)

    def _thrust(self, now: float) -> float:
        return self._gravity * min(FIRST + RAMP * (now - self._begun), LAST)
