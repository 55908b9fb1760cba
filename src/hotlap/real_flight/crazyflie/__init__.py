"""Crazyflie: told full states, or an uploaded trajectory, by the package cflib, extra `crazyflie`.

cflib is under the GPL, version 3. It is no part of hotlap: `bridge` runs it as a process of its own, and lines of text go to and fro.
"""

from __future__ import annotations

from hotlap.real_flight.crazyflie.address import address_of
from hotlap.real_flight.link import Link


def open_link(argument: str, period: float, *, mute: bool = False) -> Link:
    """A link to the Crazyflie at an address.

    Args:
        argument: the address; see `address`.
        period: [s] of the control loop.
        mute: whether it only listens.

    Raises:
        InputError: it is none, or cflib is missing.
    """
    address = address_of(argument)
    from hotlap.real_flight.crazyflie.vehicle import CrazyflieVehicle  # noqa: PLC0415  help needs none of it

    return CrazyflieVehicle(address, period, mute=mute)
