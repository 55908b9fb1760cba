"""Order: what a leg of a real flight commands, and what that follows."""

from __future__ import annotations

from dataclasses import dataclass

from hotlap.core.records import Floats


@dataclass(frozen=True)
class Order:
    """A command, and what it follows.

    Attributes:
        thrust: [m/s^2] per mass.
        rates: shape (3,) [rad/s] (body).
        reference: shape (13,) state of the reference now (race).
        acceleration: shape (3,) [m/s^2] (race) of the reference.
        estimates: shape (4,) thrust effectiveness and disturbance, as the controller has them.
        race_time: [s] since the start of the race; None elsewhere.
    """

    thrust: float
    rates: Floats
    reference: Floats
    acceleration: Floats
    estimates: Floats
    race_time: float | None = None
