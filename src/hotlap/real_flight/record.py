"""Record: what was seen and commanded in a real flight, step by step."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from hotlap.core.records import Log
from hotlap.real_flight.link import Seen
from hotlap.real_flight.order import Order


@dataclass
class FlightRecord:
    """Steps of a flight, on the vehicle's clock; states in the world of the race.

    Attributes:
        seen: the states.
        orders: the command that was computed from each.
        throttles: what was sent for its thrust [-].
        race_begun: [s] at which the race began; None: it did not.
    """

    seen: list[Seen] = field(default_factory=list)
    orders: list[Order] = field(default_factory=list)
    throttles: list[float] = field(default_factory=list)
    race_begun: float | None = None

    def add(self, seen: Seen, order: Order, throttle: float) -> None:
        """One more step; a state that is no newer than the last one is left out."""
        if self.seen and seen.time <= self.seen[-1].time:
            return
        self.seen.append(seen)
        self.orders.append(order)
        self.throttles.append(throttle)

    def log(self, rotors: int) -> Log:
        """hotlap's own flight log; time 0 is the start of the race, or the first step where there was none.

        A command stands beside the state that it was computed from, at the time at which that was measured.

        Args:
            rotors: of the vehicle; what they give nobody knows.
        """
        begun = self.race_begun if self.race_begun is not None else self.seen[0].time if self.seen else 0.0
        steps = len(self.seen)
        return Log(
            np.array([one.time - begun for one in self.seen]),
            np.array([one.state for one in self.seen]).reshape(steps, 13),
            np.full((steps, rotors), np.nan),
            np.array([[one.thrust, *one.rates] for one in self.orders]).reshape(steps, 4),
            np.array([one.estimates for one in self.orders]).reshape(steps, 4),
        )
