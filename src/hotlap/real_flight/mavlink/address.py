"""Address: where a MAVLink vehicle is found, and whose clock counts."""

from __future__ import annotations

import re
from dataclasses import dataclass

from hotlap.core.errors import InputError
from hotlap.core.vehicle_names import LANGUAGES

FORMS = LANGUAGES["mavlink"]
_NETWORK = re.compile(r"(udpin|udpout|tcp):([A-Za-z0-9._-]+):(\d{1,5})")
_SERIAL = re.compile(r"serial:([^:?]+):(\d+)")
CLOCK = "clock=vehicle"
MOST_PORT = 65535


@dataclass(frozen=True)
class Address:
    """A connection.

    Attributes:
        text: as it was written.
        device: as pymavlink writes it.
        baud: [1/s] of a serial line.
        follows_clock: whether time is what the vehicle's messages say, as for a simulation that is not in real time.
    """

    text: str
    device: str
    baud: int = 0
    follows_clock: bool = False


def address_of(text: str) -> Address:
    """An address as it is written: one of `FORMS`, and `?clock=vehicle` behind it for a simulation that is not in real time.

    Raises:
        InputError: it is none.
    """
    place, _, option = text.partition("?")
    if option not in {"", CLOCK}:
        raise InputError("", "on", f"mavlink:{text} has an option that is not known: there is ?{CLOCK}")
    serial, network = _SERIAL.fullmatch(place), _NETWORK.fullmatch(place)
    if serial is not None:
        if not int(serial[2]):
            raise InputError("", "on", f"mavlink:{text} has no baud rate above 0")
        return Address(text, serial[1], int(serial[2]), bool(option))
    if network is None:
        raise InputError("", "on", f"mavlink:{text} is no address: {FORMS}")
    if not 0 < int(network[3]) <= MOST_PORT:
        raise InputError("", "on", f"mavlink:{text} has no port from 1 to {MOST_PORT}")
    return Address(text, place, 0, bool(option))
