"""Package: pymavlink, loaded so that it speaks MAVLink 2, and connections of it."""

from __future__ import annotations

from types import ModuleType
from typing import Any

from hotlap.core.errors import InputError
from hotlap.real_flight.link import LinkError
from hotlap.real_flight.mavlink.address import Address
from hotlap.system.environment import variables

DIALECT = "common"
VERSION_2 = {"MAVLINK20": "1", "MAVLINK_DIALECT": DIALECT}  # pymavlink reads them when it is loaded


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
            options = {"baud": address.baud} if address.baud else {}
            connection = module.mavlink_connection(
                address.device, source_system=system, source_component=component, dialect=DIALECT, retries=0, **options
            )
    except ModuleNotFoundError as error:
        raise InputError("", "on", f"mavlink:{address.text} needs the package py{error.name}: pip install 'hotlap[mavlink]'") from None
    except Exception as error:  # noqa: BLE001  of sockets, of serial lines, of the package itself
        reason = getattr(error, "strerror", None) or " ".join(str(error).split()) or type(error).__name__
        raise LinkError(f"mavlink:{address.text} cannot be opened: {reason}") from None
    return connection, module.mavlink
