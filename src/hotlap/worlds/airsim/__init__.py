"""AirSim: its quadrotor flown over the wire; for AirSim, Cosys-AirSim and AirSim Drone Racing Lab."""

from __future__ import annotations

from hotlap.core.errors import InputError
from hotlap.reference.scenario import Scenario
from hotlap.worlds.airsim.address import address_of
from hotlap.worlds.airsim.client import TIMEOUT, Client
from hotlap.worlds.airsim.simulator import AirSim


def open_simulator(scenario: Scenario, instance: int, argument: str = "", timeout: float = TIMEOUT) -> AirSim:  # noqa: ARG001  any race
    """Connect to a simulator that runs.

    Args:
        scenario: what is flown.
        instance: number of the simulator, from 0, each at a port of its own: the port that was given, the next, and so on.
        argument: `host:port:vehicle`, of which anything may be missing.
        timeout: [s] of the connection and of every reply.

    Raises:
        InputError: the argument is no address.
        SimulatorError: nobody answers there, or it has no such vehicle.
    """
    try:
        address = address_of(argument, instance)
    except ValueError as error:
        raise InputError("", "on", str(error)) from None
    client = Client(address.host, address.port, timeout)
    try:
        return AirSim(client, address.vehicle, timeout)
    except BaseException:
        client.close()
        raise
