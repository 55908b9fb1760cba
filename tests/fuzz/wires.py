"""Wires: what simulators answer: msgpack of AirSim, the states in it, the packets of Betaflight."""

from __future__ import annotations

import socket
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Any

import msgpack
import numpy as np

from fuzz.mutation import damage, disturb
from hotlap.core.errors import HotlapError
from hotlap.files.content import Content
from hotlap.worlds.airsim.client import Client
from hotlap.worlds.airsim.frames import attitude_of, kinematics_of, pose_of, rotation_of, state_of, vector_of
from hotlap.worlds.betaflight.link import READY, REPLY, Link

Read = Callable[[], Any]
STATE = np.array([1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0, 4.0, 5.0, 6.0, 0.1, 0.2, 0.3])


@dataclass(frozen=True)
class Wire:
    """What comes over a wire.

    Attributes:
        name: of it.
        give: draws damaged messages, and gives what reads them.
    """

    name: str
    give: Callable[[Random, Path], Read]


def airsim_bytes(random: Random, _: Path) -> Read:
    """Replies to two calls, damaged."""
    told = {"timestamp": 3, "kinematics_estimated": kinematics_of(STATE), "collision": {"object_name": "", "has_collided": False}}
    data = damage(msgpack.packb([1, 1, None, told]) + msgpack.packb([1, 2, None, True]), random)
    return lambda: _over_client(data)


def _over_client(data: bytes) -> None:
    ours, theirs = socket.socketpair()
    client = object.__new__(Client)
    with ours, theirs:
        _begin(client, ours)
        first, second = client.send("getMultirotorState", ""), client.send("isApiControlEnabled", "")
        theirs.sendall(data)
        theirs.shutdown(socket.SHUT_WR)
        told = Content("AirSim", client.reply(first), "getMultirotorState")
        state_of(told["kinematics_estimated"])
        client.reply(second)


def _begin(client: Client, ours: socket.socket) -> None:
    """As its constructor, over a socket of ours."""
    connect, socket.create_connection = socket.create_connection, lambda *_: _Quiet(ours)
    try:
        client.__init__("127.0.0.1", 1)
    finally:
        socket.create_connection = connect


class _Quiet:
    """A socket without the options of TCP."""

    def __init__(self, ours: socket.socket) -> None:
        self._ours = ours

    def setsockopt(self, *_: int) -> None:
        """Nothing to be set."""

    def __getattr__(self, name: str) -> Any:
        return getattr(self._ours, name)


def airsim_states(random: Random, _: Path) -> Read:
    """Tables of a state or a pose with odd values."""
    told = disturb({"kinematics_estimated": kinematics_of(STATE), "pose": pose_of(STATE)}, random)

    def read() -> None:
        content, refused = Content("AirSim", told, "state"), []
        for use in (
            lambda: state_of(content["kinematics_estimated"]),
            lambda: vector_of(content["pose"]["position"]),
            lambda: attitude_of(content["pose"]["orientation"]),
            lambda: rotation_of(content["pose"]["orientation"]),
        ):
            try:
                assert np.isfinite(use()).all()
            except HotlapError as error:
                refused.append(error)
        if refused:
            raise refused[0]

    return read


def betaflight_packets(random: Random, _: Path) -> Read:
    """An answer of the firmware, damaged or with odd numbers."""
    numbers = [random.choice((0.0, 0.5, 1.0, float("nan"), float("inf"), -1e30)) for _ in range(4)]
    sound = REPLY.pack(READY, 1000, 2**31 - 2, 3, *numbers)
    data = damage(sound, random) if random.random() < 0.8 else sound

    def read() -> None:
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with ours, theirs:
            theirs.send(data[:60_000] or b"")
            theirs.shutdown(socket.SHUT_WR)
            link = object.__new__(Link)
            link._socket, link._child, link._patience, link._handle = ours, None, 1.0, None
            assert np.abs(link._receive().motors).max() <= 2

    return read


WIRES: dict[str, Wire] = {
    wire.name: wire
    for wire in (Wire("AirSim, bytes", airsim_bytes), Wire("AirSim, states", airsim_states), Wire("Betaflight", betaflight_packets))
}
