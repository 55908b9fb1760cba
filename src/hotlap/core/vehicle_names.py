"""Names of the languages that real vehicles are flown in; imports nothing, so that help costs nothing."""

from __future__ import annotations

from collections.abc import Mapping

LANGUAGES: Mapping[str, str] = {
    "mavlink": "udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT or serial:DEVICE:BAUD",
    "crazyflie": "radio://0/80/2M/E7E7E7E7E7, usb://0, tcp://HOST:PORT or udp://HOST:PORT",
}
"""Each is a module of `hotlap.real_flight` that opens a link, with the forms of its addresses."""
