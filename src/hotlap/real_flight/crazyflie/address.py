"""Address: where a Crazyflie is found, what it is told, and whose clock counts."""

from __future__ import annotations

import re
from dataclasses import dataclass

from hotlap.core.errors import InputError
from hotlap.core.vehicle_names import LANGUAGES

FORMS = LANGUAGES["crazyflie"]
_RADIO = re.compile(r"radio://[A-Za-z0-9]+(/\d{1,3}(/(250K|1M|2M)(/[0-9A-Fa-f]{1,10})?)?)?")
_NETWORK = re.compile(r"(?:udp|tcp)://[A-Za-z0-9._-]+:(\d{1,5})")
_USB = re.compile(r"usb://\d+")
_RATE_LIMIT = re.compile(r"rate_limit=\d+")
TRAJECTORY, CLOCK = "trajectory", "clock=vehicle"
MOST_PORT, CHANNELS = 65535, 125


@dataclass(frozen=True)
class Address:
    """A connection.

    Attributes:
        text: as it was written.
        uri: as cflib writes it.
        trajectory: whether the race is uploaded and flown by the high-level commander; False: full states are streamed.
        follows_clock: whether time is what the vehicle's messages say, as for a simulation that is not in real time.
    """

    text: str
    uri: str
    trajectory: bool = False
    follows_clock: bool = False


def address_of(text: str) -> Address:
    """An address as it is written: one of `FORMS`, and behind a ? options with & between.

    Raises:
        InputError: it is none.
    """
    place, mark, rest = text.partition("?")
    options = rest.split("&") if mark else []
    radio, network = _RADIO.fullmatch(place), _NETWORK.fullmatch(place)
    kept = [option for option in options if radio is not None and _RATE_LIMIT.fullmatch(option)]
    unknown = [option for option in options if option not in {TRAJECTORY, CLOCK, *kept}]
    if unknown:
        known = f"there are ?{TRAJECTORY}, ?{CLOCK} and, for radio, ?rate_limit=PACKETS"
        raise InputError("", "on", f"crazyflie:{text} has an option that is not known, '{unknown[0]}': {known}")
    if radio is None and network is None and _USB.fullmatch(place) is None:
        raise InputError("", "on", f"crazyflie:{text} is no address: {FORMS}")
    if network is not None and not 0 < int(network[1]) <= MOST_PORT:
        raise InputError("", "on", f"crazyflie:{text} has no port from 1 to {MOST_PORT}")
    if radio is not None and radio[1] and int(radio[1].split("/")[1]) > CHANNELS:
        raise InputError("", "on", f"crazyflie:{text} has no channel from 0 to {CHANNELS}")
    uri = f"{place}?{'&'.join(kept)}" if kept else place
    return Address(text, uri, TRAJECTORY in options, CLOCK in options)
