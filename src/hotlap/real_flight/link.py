"""Link: the protocol of everything that carries commands to a real vehicle and states back; the flight loop knows no other.

Frames and units are those of `race.quadrotor`: worlds with z up, bodies with x forward and y left, SI. A link turns what its vehicle says
into these once, and what it is told back. The world of a link is the vehicle's own, wherever it has its origin; the flight loop moves
it into that of the race.

Time is the vehicle's: every state has the time on the vehicle's clock at which it was measured, and the flight steps by these times
alone. Wall time decides about one thing: how long nothing at all may be heard. So a stand-in that owns the clock can fly faster than real
time, and the same flight comes out whatever else the machine does.

A vehicle that takes thrust and rates is told `throttle` and `rates` of a setpoint; one that takes a full state is told its
`reference`. One that flies an uploaded trajectory is told it by `prepare`, begins it with the first setpoint whose `race_time` is not None,
and heeds of those that follow only that they come.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import InputError

Floats = NDArray[np.float64]


class LinkError(InputError):
    """A vehicle cannot be reached, or cannot be flown: one line for people.

    Args:
        reason: with the name of the vehicle.
    """

    def __init__(self, reason: str) -> None:
        super().__init__("", "on", reason)


class Request(StrEnum):
    """What a vehicle may be asked to do besides following setpoints.

    ENGAGE: follow our setpoints from now on. ARM: let the motors turn. LAND: land where it is, by itself. HOLD: stay where it is, by
    itself. DISARM: stop the motors at once, in flight too.
    """

    ENGAGE = "engage"
    ARM = "arm"
    LAND = "land"
    HOLD = "hold"
    DISARM = "disarm"


@dataclass(frozen=True)
class Seen:
    """A state of the vehicle, as it was told.

    Attributes:
        time: [s] of the vehicle's clock at which it was measured.
        age: [s] since then, as far as the link can tell.
        state: shape (13,): position [m], attitude (w, x, y, z), velocity [m/s] (world), body rates [rad/s] (body).
        armed: whether the motors may turn.
        engaged: whether it follows our setpoints.
        on_ground: whether it says that it stands; None: it does not say.
        voltage: [V] of the battery; NaN: it does not say.
        resets: how often its estimate has jumped, as it counts.
    """

    time: float
    age: float
    state: Floats
    armed: bool
    engaged: bool
    on_ground: bool | None = None
    voltage: float = math.nan
    resets: int = 0

    @property
    def now(self) -> float:
        """[s] of the vehicle's clock when it was received."""
        return self.time + self.age


@dataclass(frozen=True)
class Setpoint:
    """What the vehicle is to follow until the next one.

    Attributes:
        time: [s] of the vehicle's clock now.
        thrust: [m/s^2] collective thrust per mass.
        throttle: [-] 0 to 1, the same as the vehicle's normalised thrust.
        rates: shape (3,) [rad/s] (body).
        reference: shape (13,) state of the reference, in the vehicle's own world; what a vehicle that takes a full state is told.
        acceleration: shape (3,) [m/s^2] (world) of the reference, likewise.
        race_time: [s] since the start of the race; None before and after.
    """

    time: float
    thrust: float
    throttle: float
    rates: Floats
    reference: Floats
    acceleration: Floats
    race_time: float | None = None


class Link(Protocol):
    """A vehicle that can be commanded.

    Attributes:
        name: for people: "mavlink:udpin:127.0.0.1:14540".
        takes_throttle: whether it is told throttle and rates, so that a map from thrust to throttle is needed; False: a full state.
        patience: [s] of wall time after which a vehicle of which nothing is heard counts as lost.
    """

    name: str
    takes_throttle: bool
    patience: float

    def open(self, wait: float) -> str:
        """Find the vehicle, and let it send its state; says in words what it is.

        Args:
            wait: [s] of wall time at most.

        Raises:
            LinkError: there is none, or it sends no state.
        """
        ...

    def receive(self, wait: float) -> Seen | None:
        """The next state that is newer than the last one; None where there is none within so many seconds, of wall time or the vehicle's.

        Whatever else has come is heeded, heartbeats are sent, and questions are answered meanwhile.
        """
        ...

    @property
    def now(self) -> float:
        """[s] of the vehicle's clock, as far as it can be told."""
        ...

    @property
    def silent_for(self) -> float:
        """[s] of wall time since anything was heard of the vehicle."""
        ...

    @property
    def remark(self) -> str:
        """What is worth knowing about it once states have come, such as ages that cannot be told; "" where there is nothing."""
        ...

    @property
    def refusal(self) -> str:
        """Why the vehicle has refused the last request, in words; "" where it has not."""
        ...

    def prepare(self, times: Floats, states: Floats) -> str:
        """Take in what the race is going to be, before the vehicle is engaged; nothing to do for one that follows setpoints.

        Returns:
            What is worth knowing about it, in words; "" where there is nothing.

        Args:
            times: shape (rows,) [s] since the start of the race, braking included.
            states: shape (rows, 13) of the reference then, in the vehicle's own world.

        Raises:
            LinkError: the vehicle cannot take it.
        """
        ...

    def send(self, setpoint: Setpoint) -> None:
        """Tell it what to follow."""
        ...

    def request(self, request: Request) -> None:
        """Ask for something, without waiting for it; asked again until a state shows it, or `refusal` says why not."""
        ...

    def close(self) -> None:
        """Give back what is held; may be called twice. It commands nothing."""
        ...
