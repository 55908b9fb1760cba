"""Autopilots: how PX4 and ArduPilot call the modes that are needed here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hotlap.real_flight.link import Request

PX4, ARDUPILOT = 12, 3  # MAV_AUTOPILOT
CUSTOM, ARMED = 1, 128  # MAV_MODE_FLAG
COPTERS = (2, 4, 13, 14, 15, 29, 35)  # MAV_TYPE: four rotors, helicopter frames of ArduPilot, six, eight, three, twelve, ten
GUIDED_OPTIONS, THRUST_AS_THRUST = "GUID_OPTIONS", 8  # of ArduPilot: without it thrust is taken for a climb rate


@dataclass(frozen=True)
class Autopilot:
    """Modes of an autopilot.

    Attributes:
        name: for people.
        modes: main and sub mode of each request that is one.
        shift: bits by which a custom mode of HEARTBEAT is shifted to be the main mode.
    """

    name: str
    modes: Mapping[Request, tuple[int, int]]
    shift: int

    def is_engaged(self, custom_mode: int) -> bool:
        """Whether it follows setpoints in a mode, as HEARTBEAT has it."""
        return (custom_mode >> self.shift) & 0xFF == self.modes[Request.ENGAGE][0]

    def custom_mode(self, request: Request) -> int:
        """A mode as HEARTBEAT has it."""
        main, sub = self.modes[request]
        return main << self.shift | (sub << 24 if self.shift else 0)


AUTOPILOTS: Mapping[int, Autopilot] = {
    PX4: Autopilot("PX4", {Request.ENGAGE: (6, 0), Request.LAND: (4, 6), Request.HOLD: (4, 3)}, 16),  # offboard; auto: land, loiter
    ARDUPILOT: Autopilot("ArduPilot", {Request.ENGAGE: (4, 0), Request.LAND: (9, 0), Request.HOLD: (17, 0)}, 0),  # guided, land, brake
}
RESULTS = ("accepted", "refused for now", "denied", "not supported", "failed", "in progress", "cancelled")  # MAV_RESULT
