"""Stream: states in, setpoints out: moved between the vehicle's world and the race's, guarded, timed and recorded."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator

import numpy as np

from hotlap.real_flight.geofence import Geofence
from hotlap.real_flight.guard import STALE, Guard, Halt, Reason
from hotlap.real_flight.legs import Leg
from hotlap.real_flight.link import Link, Request, Seen, Setpoint
from hotlap.real_flight.order import Order
from hotlap.real_flight.place import Place
from hotlap.real_flight.record import FlightRecord
from hotlap.real_flight.thrust_map import ThrustMap

RECEIVE = 0.02  # s of wall time between looks at what else may have happened
EARLY = 0.25  # of a period, by which a command may come early
STOPPING, ASKING = 1.0, 0.1  # s of wall time over which a stop is asked for, and between times


class Stream:
    """The commands of a flight, and what they are computed from.

    Args:
        link: to the vehicle, open.
        period: [s] of the control loop.
        thrust_map: for vehicles that take throttle.
        place: of the race in the vehicle's world.

    Attributes:
        guard: looks at every state.
        record: of all steps.
    """

    def __init__(self, link: Link, period: float, thrust_map: ThrustMap, place: Place) -> None:
        self._link, self._period, self._map, self.place = link, period, thrust_map, place
        self.record, self.guard = FlightRecord(), Guard(Geofence(np.full(3, -math.inf), np.full(3, math.inf)), math.inf)
        self._due = -math.inf

    def states(self) -> Iterator[Seen]:
        """States (race) for which a command is due; each has passed the guard, and all between them, too.

        Raises:
            Halt: see `Guard`; or nothing is heard.
        """
        for received in self.received():
            seen = self.place.seen(received)
            self._map.hear(seen.now, seen.voltage)
            self.guard.check(seen)
            if seen.now < self._due - EARLY * self._period:
                continue
            self._due = max(self._due, seen.now - self._period / 2) + self._period
            yield seen

    def received(self, most: float = math.inf, stale: float = STALE) -> Iterator[Seen]:
        """States as they come, in the vehicle's world.

        Args:
            most: [s] of wall time that may pass in all.
            stale: [s] of the vehicle's clock without one.

        Raises:
            Halt: nothing is heard, or no state comes.
        """
        begun, last = time.monotonic(), self._link.now
        while time.monotonic() - begun < most:
            seen = self._link.receive(RECEIVE)
            if self._link.silent_for > self._link.patience:
                raise Halt(Reason.LINK, f"nothing was heard for {self._link.silent_for:.2f} s")
            if seen is not None:
                last = seen.time
                yield seen
            elif self._link.now - last > stale:
                raise Halt(Reason.STALE, f"{self._link.now - last:.2f} s")
        raise Halt(Reason.STALE, f"too few came within {most:.0f} s")

    def follow(self, seen: Seen, leg: Leg) -> Order:
        """Compute a command, record it, and send it.

        Raises:
            Halt: it is no number, or the vehicle is too far from the reference; then it is not sent.
        """
        order = leg.order(seen)
        throttle = self._checked(order)
        self.record.add(seen, order, throttle)
        self.guard.check_distance(seen, order.reference)
        self._send(seen, order, throttle)
        return order

    def send(self, seen: Seen, order: Order) -> float:
        """Send a command that follows no reference; gives its throttle.

        Raises:
            Halt: it is no number; then it is not sent.
        """
        throttle = self._checked(order)
        self._send(seen, order, throttle)
        return throttle

    def _checked(self, order: Order) -> float:
        """The throttle of a command all of whose parts that the vehicle is told are numbers."""
        throttle = self.throttle(order)
        steered = [order.thrust, throttle, *order.rates] if self._link.takes_throttle else []
        if not np.isfinite([*steered, *order.reference, *order.acceleration]).all():
            raise Halt(Reason.COMMAND)
        return throttle

    def _send(self, seen: Seen, order: Order, throttle: float) -> None:
        told, acceleration = self.place.told(order.reference), self.place.turned(order.acceleration)
        self._link.send(Setpoint(seen.now, order.thrust, throttle, order.rates, told, acceleration, order.race_time))

    def throttle(self, order: Order) -> float:
        """What is told for the thrust of a command [-]; NaN where the vehicle is told a full state."""
        return self._map.throttle(order.thrust) if self._link.takes_throttle else math.nan

    def stop(self, request: Request) -> None:
        """Ask the vehicle to stop until it no longer follows setpoints, for a second at most; none is sent any more."""
        begun = asked = time.monotonic()
        self._link.request(request)
        while time.monotonic() - begun < STOPPING:
            seen = self._link.receive(RECEIVE)
            if seen is not None and not seen.engaged:
                return
            if time.monotonic() - asked >= ASKING:
                self._link.request(request)
                asked = time.monotonic()
