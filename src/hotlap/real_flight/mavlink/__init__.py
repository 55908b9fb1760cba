"""MAVLink: PX4 and ArduPilot, told thrust and body rates (SET_ATTITUDE_TARGET); needs the package pymavlink, extra `mavlink`."""

from __future__ import annotations

from hotlap.real_flight.link import Link
from hotlap.real_flight.mavlink.address import address_of


def open_link(argument: str, period: float, *, mute: bool = False) -> Link:
    """A link to what listens, or talks, at an address.

    Args:
        argument: the address; see `address`.
        period: [s] of the control loop.
        mute: whether it only listens.

    Raises:
        InputError: it is none, or pymavlink is missing.
    """
    address = address_of(argument)
    from hotlap.real_flight.mavlink.vehicle import MavlinkVehicle  # noqa: PLC0415  it needs the package

    return MavlinkVehicle(address, period, mute=mute)
