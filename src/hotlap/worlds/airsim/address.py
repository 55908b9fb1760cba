"""Address: where AirSim's API is served, and the vehicle that is flown there."""

from __future__ import annotations

from dataclasses import dataclass

HOST, PORT, MOST_PORT = "127.0.0.1", 41451, 65535


@dataclass(frozen=True)
class Address:
    """One vehicle of one simulator.

    Attributes:
        host: name or address of the machine.
        port: of TCP; `ApiServerPort` in settings.json.
        vehicle: its name in settings.json; "": the only one.
    """

    host: str = HOST
    port: int = PORT
    vehicle: str = ""


def address_of(text: str, further: int = 0) -> Address:
    """An address written as `host:port:vehicle`, of which anything may be missing.

    Args:
        text: what was written.
        further: by which the port is raised.

    Raises:
        ValueError: the port is none.
    """
    host, _, rest = text.partition(":")
    port, _, vehicle = rest.partition(":")
    number = (int(port) if port.isascii() and port.isdigit() else 0) if port else PORT
    if not 0 < number <= MOST_PORT - further:
        raise ValueError(f"the port must be a number from 1 to {MOST_PORT - further}, not '{port}' (airsim:host:port:vehicle)")
    return Address(host or HOST, number + further, vehicle)
