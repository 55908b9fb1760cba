"""A stand-in for a Crazyflie, over UDP: it answers the questions of a library that connects, logs its state and flies what it is told.

    python -m hotlap.real_flight.crazyflie.stand_in 19850 --race my-race.toml

A packet is a byte of header, port << 4 | channel, and up to 30 bytes, all little-endian. In real time it sleeps; in lockstep it waits,
after each state, until its time comes back as an echo, so that a link with `?clock=vehicle` flies as fast as both can compute.
"""

from __future__ import annotations

import argparse
import math
import select
import socket
import struct
import threading
import time
import zlib
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np

from hotlap.core.errors import HotlapError
from hotlap.real_flight.crazyflie.onboard import Aim, OnBoard
from hotlap.real_flight.crazyflie.packed import MILLI, pack_state, unpack_attitude
from hotlap.real_flight.stand_in import StandInDrone

PARAMETERS, RPYT, MEMORY, LOG, SETPOINT, COMMANDER, SUPERVISOR, PLATFORM, LINK = 2, 3, 4, 5, 7, 8, 9, 13, 15  # ports
STEP = 0.005  # s
ANSWER, ASK_AGAIN = 10.0, 0.2  # s of wall time for which lockstep waits, and after which it says it again
FULL_STATE = struct.Struct("<9hI3h")
INT16, UINT16, UINT32, FLOAT = 5, 2, 3, 7  # types of a log
SIZES = {INT16: "h", UINT16: "H", UINT32: "I", FLOAT: "f"}
STATE = ("x", "y", "z", "vx", "vy", "vz", "quat", "rateRoll", "ratePitch", "rateYaw")
NAMES = (
    *((f"stateEstimateZ.{name}", UINT32 if name == "quat" else INT16) for name in STATE),
    ("supervisor.info", UINT16),
    ("pm.vbat", FLOAT),
)
FLOAT_PARAMETER, BYTE_PARAMETER = 0x06, 0x08
VALUES = {"stabilizer.controller": (BYTE_PARAMETER, struct.pack("<B", 2)), "kalman.robustTdoa": (BYTE_PARAMETER, struct.pack("<B", 0))}
TRAJECTORIES = 0x12  # a type of memory
MAGIC = b"Bitcraze Crazyflie\0"


@dataclass
class StandIn:
    """A Crazyflie at the end of a UDP socket.

    Attributes:
        board: what flies.
        port: on which it listens; 0: any that is free.
        protocol: of CRTP, as it says.
        lacks: name of a variable that it does not log.
        lockstep: wait for the other end; False: real time.
        noise: [m] standard deviation of positions.
        seed: of that.
        each_step: called with itself before each step; it may change anything.
        silent: whether it sends nothing any more.
        deaf: whether it hears nothing any more, either.
        setpoints: (time [s], true state, full state that was told) of each.
        requests: (time [s], what) of all else that was asked for.
        path: times and true states.
    """

    board: OnBoard
    port: int = 0
    protocol: int = 12
    lacks: str = ""
    lockstep: bool = True
    noise: float = 0.001
    seed: int = 0
    each_step: Callable[[StandIn], None] = lambda _: None
    silent: bool = False
    deaf: bool = False
    setpoints: list[tuple[float, np.ndarray, Aim]] = field(default_factory=list)
    requests: list[tuple[float, str]] = field(default_factory=list)
    path: list[tuple[float, np.ndarray]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", self.port))
        self.port, self._peer = self._socket.getsockname()[1], None
        self._names = tuple(one for one in NAMES if one[0] != self.lacks)
        self._blocks: dict[int, list[int]] = {}
        self._running: dict[int, int] = {}
        self._stop, self._echoed, self._steps = threading.Event(), -1.0, 0
        self._random = np.random.default_rng(self.seed)
        self.ended = False

    @property
    def now(self) -> float:
        """[s] Simulated time."""
        return self.board.drone.time

    def stop(self) -> None:
        """Let `serve` end."""
        self._stop.set()

    def serve(self, longest: float = math.inf) -> None:
        """Fly until it is stopped, for so many seconds at most; in lockstep, until the other end answers no more."""
        begun = time.monotonic() - self.now
        try:
            while not self._stop.is_set() and self.now < longest and not self.ended:
                if self.lockstep and not self._running:
                    self._listen(0.05)
                    continue
                self.each_step(self)
                self.board.advance(STEP)
                self._steps += 1
                said = self._report()
                if not self.lockstep:
                    self._listen(max(begun + self.now - time.monotonic(), 0.0))
                elif said:
                    self._wait_for_echo()
        finally:
            self._socket.close()

    def _wait_for_echo(self) -> None:
        """What was sent before has been heeded when its time comes back."""
        begun = again = time.monotonic()
        while self._echoed < self._stamp and not self._stop.is_set():
            self._listen(0.02)
            if time.monotonic() - again > ASK_AGAIN:
                again = time.monotonic()
                self._report(again=True)
            if time.monotonic() - begun > ANSWER:
                self.ended = True
                return

    @property
    def _stamp(self) -> int:
        return round(1e3 * self.now)

    def _report(self, *, again: bool = False) -> bool:
        """Log what is due; whether anything was."""
        due = [block for block, period in self._running.items() if self._steps % round(period * 0.01 / STEP) == 0]
        if not due:
            return False
        if not again:
            self.path.append((self.now, self.board.drone.state))
        state = self.board.drone.state
        state[:3] += self.noise * self._random.standard_normal(3)
        values = {f"stateEstimateZ.{name}": value for name, value in zip(STATE, pack_state(state), strict=True)}
        values |= {"supervisor.info": int(self.board.status), "pm.vbat": self.board.drone.voltage}
        for block in due:
            content = b"".join(struct.pack(f"<{SIZES[kind]}", values[name]) for name, kind in (self._names[i] for i in self._blocks[block]))
            self._send(LOG, 2, bytes([block]) + self._stamp.to_bytes(4, "little")[:3] + content)
        return any(len(self._blocks[block]) > 1 for block in due)

    def _send(self, port: int, channel: int, content: bytes) -> None:
        if self._peer is not None and not self.silent:
            with suppress(OSError):
                self._socket.sendto(bytes([port << 4 | channel]) + content, self._peer)

    def _listen(self, wait: float) -> None:
        """Take in packets for so many seconds of wall time; in lockstep, only until the first have come."""
        end = time.monotonic() + wait
        while True:
            while select.select([self._socket], [], [], 0.0)[0]:
                with suppress(OSError):
                    packet, self._peer = self._socket.recvfrom(64)
                    if packet and not self.deaf:
                        self._hear(packet[0] >> 4, packet[0] & 3, packet[1:])
                end = time.monotonic() if self.lockstep else end
            left = end - time.monotonic()
            if left <= 0:
                return
            select.select([self._socket], [], [], left)

    def _hear(self, port: int, channel: int, content: bytes) -> None:
        """A packet, by its port."""
        if port == LINK:
            self._answer_link(channel, content)
        elif port == PLATFORM and channel == 1:
            self._send(PLATFORM, 1, bytes([0, self.protocol]))
        elif port in {LOG, PARAMETERS} and channel == 0:
            self._answer_table(port, content)
        elif port == LOG and channel == 1:
            self._answer_log(content)
        elif port == PARAMETERS and channel == 1:
            self._send(PARAMETERS, 1, content[:2] + b"\0" + list(VALUES.values())[content[0]][1])
        elif port == MEMORY:
            self._answer_memory(channel, content)
        elif port in {SETPOINT, RPYT}:
            self._hear_setpoint(port, channel, content)
        elif port == COMMANDER:
            self._hear_commander(content)
        elif port == SUPERVISOR and channel == 1:
            self._hear_supervisor(content)

    def _answer_link(self, channel: int, content: bytes) -> None:
        """Echo, or who it is."""
        if channel == 1:
            self._send(LINK, 1, MAGIC + bytes(11))
            return
        if len(content) == 9 and content[0] == 1:
            self._echoed = max(self._echoed, struct.unpack("<d", content[1:])[0])
        self._send(LINK, channel, content)

    def _answer_table(self, port: int, content: bytes) -> None:
        """How many variables there are, and what they are called."""
        kinds = self._names if port == LOG else tuple((name, kind) for name, (kind, _) in VALUES.items())
        if content[0] == 3:
            self._send(port, 0, struct.pack("<BHI", 3, len(kinds), zlib.crc32(repr(kinds).encode())))
            return
        number = int.from_bytes(content[1:3], "little")
        name, kind = kinds[number]
        self._send(port, 0, struct.pack("<BHB", 2, number, kind) + name.replace(".", "\0").encode() + b"\0")

    def _answer_log(self, content: bytes) -> None:
        """Blocks of a log: made, extended, started, stopped, all forgotten."""
        command, block = content[0], content[1] if len(content) > 1 else 0
        if command in {6, 7}:
            named = [int.from_bytes(content[i + 1 : i + 3], "little") for i in range(2, len(content) - 2, 3)]
            self._blocks[block] = (self._blocks.get(block, []) if command == 7 else []) + named
        elif command == 3:
            self._running[block] = content[2]
        elif command in {2, 4}:
            self._running.pop(block, None)
        elif command == 5:
            self._blocks, self._running = {}, {}
        self._send(LOG, 1, bytes([command, block, 0]))

    def _answer_memory(self, channel: int, content: bytes) -> None:
        """One memory, of trajectories."""
        if channel == 0 and content[0] == 1:
            self._send(MEMORY, 0, bytes([1, 1]))
        elif channel == 0 and content[0] == 2:
            self._send(MEMORY, 0, struct.pack("<BBBI8x", 2, 0, TRAJECTORIES, len(self.board.memory)))
        elif channel == 2:
            start = int.from_bytes(content[1:5], "little")
            self.board.memory[start : start + len(content) - 5] = content[5:]
            self._send(MEMORY, 2, content[:5] + b"\0")

    def _hear_setpoint(self, port: int, channel: int, content: bytes) -> None:
        if port == SETPOINT and channel == 1:
            self.requests.append((self.now, "give way"))
            self.board.give_way()
        elif port == SETPOINT and content[0] == 6:
            *numbers, quaternion, roll, pitch, yaw = FULL_STATE.unpack(content[1:])
            position, velocity, acceleration = MILLI * np.array(numbers, dtype=np.float64).reshape(3, 3)
            aim = Aim(position, velocity, acceleration, unpack_attitude(quaternion), MILLI * np.array([roll, pitch, yaw], dtype=np.float64))
            self.setpoints.append((self.now, self.board.drone.state, aim))
            self.board.stream(aim)
        else:
            self.requests.append((self.now, "a setpoint that nobody has asked for"))

    def _hear_commander(self, content: bytes) -> None:
        command, error = content[0], 0
        if command == 8:
            _, height, _, _, duration = struct.unpack("<Bff?f", content[1:15])
            self.requests.append((self.now, "land"))
            self.board.land(height, duration)
        elif command == 12:
            *offset, _, duration = struct.unpack("<5f", content[4:24])
            self.requests.append((self.now, "hold"))
            self.board.go_on(np.array(offset), duration)
        elif command == 6:
            offset, count = struct.unpack("<IB", content[4:9])
            self.board.define(offset, count)
        elif command == 13:
            self.requests.append((self.now, "start"))
            error = 0 if self.board.start() else 2
        self._send(COMMANDER, 0, bytes([command, *content[1:3], error]))

    def _hear_supervisor(self, content: bytes) -> None:
        command = content[0]
        if command == 1:
            self.requests.append((self.now, "arm" if content[1] else "disarm"))
            done = self.board.arm(bool(content[1]))
            self._send(SUPERVISOR, 1, bytes([0x81, done, self.board.armed]))
        elif command == 3:
            self.requests.append((self.now, "stop"))
            self.board.stop()
        elif command == 4:
            self.board.beat()


def main() -> None:
    """Serve in real time until Ctrl-C."""
    from hotlap.files.descriptions import load_race  # noqa: PLC0415  it takes its time

    parser = argparse.ArgumentParser(description="A stand-in for a Crazyflie with a drone of hotlap's own, in real time.")
    parser.add_argument("port", type=int, nargs="?", default=19850, help="of UDP, on 127.0.0.1")
    parser.add_argument("--race", default="circle-34", help="whose quadrotor it flies, from below its start")
    parser.add_argument("--brushed", action="store_true", help="it arms by itself")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    race = load_race(options.race)
    drone = StandInDrone(race.vehicle, np.array(race.track.start) - np.array([0.0, 0.0, 1.5]))
    try:
        stand_in = StandIn(OnBoard(drone, options.brushed), options.port, lockstep=False, noise=0.005, seed=options.seed)
    except OSError as error:
        raise SystemExit(f"port {options.port}: {error.strerror}") from None
    stand_in.serve()


if __name__ == "__main__":
    try:
        main()
    except (KeyboardInterrupt, HotlapError) as error:
        raise SystemExit(str(error)) from None
