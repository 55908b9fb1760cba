"""Settings of a real flight, and what it was."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from hotlap.real_flight.geofence import MARGIN, Geofence
from hotlap.real_flight.guard import STRAY, Halt
from hotlap.real_flight.link import Request
from hotlap.real_flight.record import FlightRecord


class Phase(StrEnum):
    """What is being done."""

    MEET = "meet"
    ENGAGE = "engage"
    TAKE_OFF = "take off"
    APPROACH = "approach"
    RACE = "race"
    STAND = "stand"
    LAND = "land"


@dataclass(frozen=True)
class FlightSettings:
    """How a real flight is to go.

    Attributes:
        arm: whether hotlap may arm the vehicle.
        on_stop: what it is asked for when something stops the flight.
        geofence: see `geofence`; "": around the path.
        margin: [m] around the path.
        stray: [m] from the reference at most; where the race gives a flight up earlier, that holds.
        origin: see `place`.
        speed: [m/s] to the start, at most.
        acceleration: [m/s^2] likewise.
        curve: of the throttle; see `thrust_map`.
        with_battery: whether thrust goes with the battery's voltage.
        wait: [s] of wall time for the vehicle.
    """

    arm: bool = False
    on_stop: Request = Request.LAND
    geofence: str = ""
    margin: float = MARGIN
    stray: float = STRAY
    origin: str = "0, 0, 0, 0"
    speed: float = 1.0
    acceleration: float = 1.0
    curve: float = 0.0
    with_battery: bool = True
    wait: float = 10.0


@dataclass(frozen=True)
class Flown:
    """A real flight.

    Attributes:
        record: of all steps.
        phase: the last.
        halt: what has stopped it; None: it went to its end.
        gain: thrust as hovering showed it, over that of the file [-]; 1 where it never hovered, NaN where its own controller flew it.
        geofence: that held.
        vehicle: what it is, in words.
    """

    record: FlightRecord
    phase: Phase
    halt: Halt | None
    gain: float
    geofence: Geofence
    vehicle: str
