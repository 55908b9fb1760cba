"""Package: pymavlink, loaded so that it speaks MAVLink 2, and connections of it."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType
from typing import Any, NoReturn

from hotlap.core.errors import InputError
from hotlap.real_flight.link import LinkError
from hotlap.real_flight.mavlink.address import Address
from hotlap.system.environment import variables

DIALECT = "common"
VERSION_2 = {"MAVLINK20": "1", "MAVLINK_DIALECT": DIALECT}  # pymavlink reads them when it is loaded
CONNECTING, WRITING = 5.0, 0.02  # s until TCP has to be there; for which a serial line may hold up what is sent


def mavutil() -> ModuleType:
    """The module of connections.

    Raises:
        InputError: the package is not there.
    """
    try:
        with variables(VERSION_2):
            from pymavlink import mavutil as loaded  # noqa: PLC0415  only for vehicles
    except ImportError:
        raise InputError("", "on", "mavlink needs the package pymavlink: pip install 'hotlap[mavlink]'") from None
    return loaded


def connect(address: Address, system: int, component: int) -> tuple[Any, ModuleType]:
    """A connection, and the messages of the dialect.

    Args:
        address: where.
        system: ours.
        component: ours.

    Raises:
        LinkError: it cannot be opened.
        InputError: the package is not there.
    """
    module = mavutil()
    try:
        with variables(VERSION_2):
            module.set_dialect(DIALECT)
            made = _serial(module, address, system, component) if address.baud else _network(module, address, system, component)
    except ModuleNotFoundError as error:
        raise InputError("", "on", f"mavlink:{address.text} needs the package py{error.name}: pip install 'hotlap[mavlink]'") from None
    except Exception as error:  # noqa: BLE001  of sockets, of serial lines, of the package itself
        reason = getattr(error, "strerror", None) or " ".join(str(error).split()) or type(error).__name__
        raise LinkError(f"mavlink:{address.text} cannot be opened: {reason}") from None
    return made, module.mavlink


def _serial(module: ModuleType, address: Address, system: int, component: int) -> Any:
    """A serial line, whatever its name; one that takes nothing does not hold up a flight."""
    made = module.mavserial(address.device, baud=address.baud, source_system=system, source_component=component)
    made.port.write_timeout = WRITING
    made.portdead = True  # else the package prints that it is
    return made


def _network(module: ModuleType, address: Address, system: int, component: int) -> Any:
    """UDP or TCP; names are looked up once, and a port that listens is nobody else's."""
    kind, host, port = address.device.split(":")
    place = socket.getaddrinfo(host, int(port), socket.AF_INET)[0][4]
    if kind == "udpin":
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind(place)
    with _in_time():
        made = module.mavlink_connection(f"{kind}:{place[0]}:{place[1]}", source_system=system, source_component=component, retries=0)
    if kind == "udpin":
        made.port.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 0)  # with it another program could take what comes
    if kind == "tcp":
        made.handle_eof = made.handle_disconnect = _gone
    return made


@contextmanager
def _in_time() -> Iterator[None]:
    """Sockets that are made within do not wait for ever."""
    before = socket.getdefaulttimeout()
    socket.setdefaulttimeout(CONNECTING)
    try:
        yield
    finally:
        socket.setdefaulttimeout(before)


def _gone() -> NoReturn:
    """In place of what the package prints, again and again."""
    raise ConnectionResetError
