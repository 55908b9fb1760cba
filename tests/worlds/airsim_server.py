"""A server that answers as AirSim's does and flies our plant; it notes every call that the real one would not have survived.

What it keeps to was seen in the real one: a move that is replaced returns false and one that ran out true, `reset` takes API control,
60 ms without a goal the vehicle holds its position, `simContinueForTime` flies more steps than asked for, or fewer, and a
server that gets anything else than `cancelLastTask` while a replaced move waits is dead.
"""

from __future__ import annotations

import select
import socket
import threading
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, Self

import msgpack
import numpy as np

from worlds.airsim_messages import pose_told, rotors_told, state_meant, state_told, vector_told
from worlds.airsim_plant import STEP, Plant

FULL_THRUST, SEA_LEVEL = 4 * 4.179446, 1.225  # N, kg/m^3
HOLDS_AFTER = 60_000_000  # ns without a goal
STAMPS = (3_000_064, 3_000_064, 3_000_320)  # ns of a step
QUICK = 2e-4  # s within which whoever does not wait has sent something
LOWEST_THROTTLE = 0.05
DEFAULT_DENSITY = 1.210716


class RefusedError(Exception):
    """What the server answers in place of a result."""


@dataclass
class Move:
    """A move that the vehicle follows."""

    connection: socket.socket
    number: int
    command: np.ndarray
    end: int


@dataclass
class Server:
    """One vehicle; used as a context, it serves on a free port of this machine.

    Attributes:
        plant: what flies.
        vehicle: its name, besides "".
        spawn: where it was set up in the level [m] (north, east, down).
        scene: objects by name: position and orientation (x, y, z; w, x, y, z; north, east, down) and scale.
        racing_lab: whether it is Drone Racing Lab: poses with noise or without, no kinematics to be set, no rotors.
        cosys: whether it is Cosys-AirSim: poses in its frame or in the Unreal Engine's.
        loses_cancel: numbers of the moves that do not notice that they were replaced.
        cancels_successor: whether `cancelLastTask` hits the next move, too.
        cut_at: number of the move with which the connection ends.
        silent_at: call that is never answered.
        disowned_at: number of the move with which API control is lost.
        altered: what is made of a call's result.
        raw: bytes that are sent in place of the reply to a call.
        violations: what the real one would not have survived.
        calls: how often each was called.
        paused, controlled: whether the simulation is, and whether the API has control.
        thrusts: [N] of each move.
        periods: steps of each `simContinueForTime`.
        holds: steps in which the vehicle held its position.
    """

    plant: Plant
    vehicle: str = "Drone1"
    scene: dict[str, tuple[list[float], list[float], list[float]]] = field(default_factory=dict)
    racing_lab: bool = False
    cosys: bool = False
    loses_cancel: tuple[int, ...] = ()
    cancels_successor: bool = False
    cut_at: int = -1
    silent_at: str = ""
    disowned_at: int = -1
    altered: dict[str, Callable[[Any], Any]] = field(default_factory=dict)
    raw: dict[str, bytes] = field(default_factory=dict)
    spawn: tuple[float, float, float] = (0.0, 0.0, 0.0)
    density: float = DEFAULT_DENSITY
    violations: list[str] = field(default_factory=list)
    calls: Counter[str] = field(default_factory=Counter)
    holds: int = 0
    thrusts: list[float] = field(default_factory=list)
    periods: list[int] = field(default_factory=list)

    def __enter__(self) -> Self:
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]
        self._open: list[socket.socket] = []
        self._lock, self._threads = threading.Lock(), [threading.Thread(target=self._accept)]
        self.stamp, self._steps, self._continued, self._moves = 1_700_000_000_000_000_000, 0, 0, 0
        self.controlled = self._armed = self.paused = self._placed = False
        self._move: Move | None = None
        self._more = False
        self._goal, self._goal_stamp, self._stuck = np.zeros(4), 0, None
        self._threads[0].start()
        return self

    def __exit__(self, *_: object) -> None:
        self.kill()
        for thread in self._threads:
            thread.join(5)
            assert not thread.is_alive()

    def kill(self) -> None:
        """End everything, as when the simulator's window is closed."""
        for connection in (self._listener, *self._open):
            with suppress(OSError):
                connection.shutdown(socket.SHUT_RDWR)
            connection.close()

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                connection, _ = self._listener.accept()
                connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                self._open.append(connection)
                self._threads.append(threading.Thread(target=self._serve, args=(connection,)))
                self._threads[-1].start()

    def _serve(self, connection: socket.socket) -> None:
        unpacker = msgpack.Unpacker(raw=False)
        with suppress(OSError, ValueError):
            while data := connection.recv(65536):
                unpacker.feed(data)
                requests = list(unpacker)
                for k, (_, number, method, arguments) in enumerate(requests, 1):
                    with self._lock:
                        self._more = k < len(requests)
                        self._take(connection, number, method, arguments)
                    if self._moves == self.cut_at:
                        self._moves += 1
                        connection.shutdown(socket.SHUT_RDWR)

    def _take(self, connection: socket.socket, number: int, method: str, arguments: list) -> None:
        """Answer one request."""
        self.calls[method] += 1
        if self._stuck and method != "cancelLastTask":
            self.violations.append(f"{method} while a replaced move waits")
            self.silent_at = method
        if method == self.silent_at:
            return
        if method in self.raw:
            connection.sendall(self.raw[method])
            return
        try:
            result = self._call(connection, number, method, arguments)
        except RefusedError as error:
            connection.sendall(msgpack.packb([1, number, str(error), None]))
            return
        if method != "moveByAngleRatesThrottle":
            self._reply(connection, number, self.altered.get(method, lambda told: told)(result))

    def _reply(self, connection: socket.socket, number: int, result: Any) -> None:
        with suppress(OSError):
            connection.sendall(msgpack.packb([1, number, None, result]))

    def _end(self, move: Move, ran_out: bool) -> None:
        """Answer the call of a move that is over."""
        self._reply(move.connection, move.number, ran_out)

    def _call(self, connection: socket.socket, number: int, method: str, arguments: list) -> Any:
        """The result of a call."""
        known = self._known()
        if method not in known:
            raise RefusedError(f"rpclib: server could not find function '{method}' with argument count {len(arguments)}.")
        kinds, answer = known[method]
        if len(kinds) != len(arguments):
            expected = f"Expected: {len(kinds)}, got: {len(arguments)}"
            raise RefusedError(f"rpclib: Function '{method}' was called with an invalid number of arguments. {expected}")
        for kind, argument in zip(kinds, arguments, strict=True):
            if type(argument) is not kind:
                self.violations.append(f"{method}: {argument!r} is no {kind.__name__}")
                raise RefusedError("std::bad_cast")
        of_vehicle = kinds and kinds[-1] is str and method not in {"simListSceneObjects", "simGetObjectPose", "simGetObjectScale"}
        if of_vehicle and arguments[-1] not in {"", self.vehicle}:
            raise RefusedError(f"rpclib: Vehicle API for '{arguments[-1]}' is not available. This vehicle does not exist")
        if method == "moveByAngleRatesThrottle":
            return self._begin_move(connection, number, arguments)
        if method == "cancelLastTask":
            return self._cancel()
        if method == "reset":
            return self._reset()
        if method == "simContinueForTime":
            return self._continue(arguments[0])
        return answer(*arguments)

    def _known(self) -> dict[str, tuple[tuple[type, ...], Callable[..., Any]]]:
        """Every call, with the kinds of its arguments."""

        def none(*_: Any) -> None:
            return None

        every: dict[str, tuple[tuple[type, ...], Callable[..., Any]]] = {
            "ping": ((), lambda: True),
            "listVehicles": ((), lambda: [self.vehicle]),
            "enableApiControl": ((bool, str), lambda on, _: setattr(self, "controlled", on)),
            "isApiControlEnabled": ((str,), lambda _: self.controlled),
            "armDisarm": ((bool, str), self._arm),
            "simPause": ((bool,), lambda on: setattr(self, "paused", on)),
            "simIsPaused": ((), lambda: self.paused),
            "reset": ((), none),
            "cancelLastTask": ((str,), none),
            "simContinueForTime": ((float,), none),
            "moveByAngleRatesThrottle": ((float, float, float, float, float, str), none),
            "getMultirotorState": ((str,), lambda _: state_told(self.plant.state, self.stamp, landed=not self._placed)),
            "simGetGroundTruthEnvironment": ((str,), lambda _: {"air_density": self.density, "gravity": vector_told([0, 0, 9.80665])}),
            "simSetVehiclePose": ((dict, bool, str), lambda pose, *_: self._place(pose)),
            "simListSceneObjects": ((str,), lambda _: list(self.scene)),
            "simGetObjectScale": ((str,), lambda name: vector_told(self.scene[name][2])),
            "simGetObjectPose": ((str, bool) if self.racing_lab or self.cosys else (str,), self._object),
        }
        if self.racing_lab:
            every["simGetLastGatePassed"] = ((str,), lambda _: 65535)
        else:
            every["simSetKinematics"] = ((dict, bool, str), lambda kinematics, *_: self._place(kinematics))
            every["getRotorStates"] = ((str,), lambda _: {"rotors": rotors_told(self.plant.rotor_thrusts), "timestamp": self.stamp})
        return every

    def _object(self, name: str, way: bool | None = None) -> dict[str, Any]:
        """Where something of the level is; NaN where there is no such thing."""
        if way is not None and way is not self.cosys:
            return pose_told([1e3, 1e3, 1e3], [1, 0, 0, 0])  # with noise, or of the Unreal Engine
        if name == self.vehicle:
            return pose_told(self.plant.state[:3] * [1, -1, -1] + self.spawn, [1, 0, 0, 0])
        nowhere = [np.nan] * 3, [np.nan] * 4
        return pose_told(*self.scene.get(name, nowhere)[:2])

    def _arm(self, on: bool, _: str) -> bool:
        if not self.controlled:
            self.violations.append("armDisarm without API control")
        self._armed = on
        return True

    def _begin_move(self, connection: socket.socket, number: int, arguments: list) -> None:
        p, q, r, throttle, duration, _ = arguments
        self._moves += 1
        if not (self.controlled and self._armed and self.paused):
            self.violations.append(f"a move with API control {self.controlled}, armed {self._armed}, paused {self.paused}")
        if not LOWEST_THROTTLE < throttle <= 1 or not np.isfinite([p, q, r, throttle]).all():
            self.violations.append(f"a move with rates {p}, {q}, {r} and throttle {throttle}")
        if duration < HOLDS_AFTER * 1e-9:
            self.violations.append(f"a move of {duration} s")
        if self._moves == self.disowned_at:
            self.controlled = False
        before = self._move
        newtons = throttle * FULL_THRUST * self.density / SEA_LEVEL
        self._move = Move(connection, number, np.array([newtons / self.plant.quadrotor.mass, p, -q, -r]), self.stamp + int(duration * 1e9))
        self.thrusts.append(newtons)
        if before is None:
            return
        early = self._more or select.select([connection], [], [], QUICK)[0]
        if early or self._moves in self.loses_cancel:
            self._stuck = before  # what comes now must be to cancel it
        else:
            self._end(before, False)

    def _cancel(self) -> None:
        if self._stuck:
            self._end(self._stuck, False)
            self._stuck = None
            if not self.cancels_successor:
                return
        if self._move is not None:
            self._end(self._move, False)
            self._move = None

    def _reset(self) -> None:
        if self._move is not None:
            self.violations.append("reset in the middle of a move")
            self._end(self._move, False)
        self._move, self.controlled, self._armed, self._placed = None, False, False, False
        self._continued = self._steps = 0
        self._goal = np.zeros(4)
        self.plant.stop()

    def _continue(self, seconds: float) -> None:
        """Fly: the steps that were asked for, now and then one more, or none at all."""
        if not self.paused:
            self.violations.append("simContinueForTime without simPause")
        self._continued += 1
        steps = int(np.ceil(seconds / STEP)) + (self._continued % 7 == 3)
        steps = 0 if self._continued % 11 == 5 else steps
        self.periods.append(steps)
        for _ in range(steps):
            self._step()

    def _step(self) -> None:
        if self._move is not None:
            self._goal, self._goal_stamp = self._move.command, self.stamp
        held = self.stamp - self._goal_stamp > HOLDS_AFTER
        self.holds += held
        self.plant.step(np.array([self.plant.quadrotor.gravity, 0, 0, 0]) if held else self._goal)
        self.stamp += STAMPS[self._steps % len(STAMPS)]
        self._steps += 1
        if not self._placed:
            self.plant.stand()
        if self._move is not None and self.stamp >= self._move.end:
            self._end(self._move, True)
            self._move = None

    def _place(self, kinematics: dict) -> None:
        if not self.paused:
            self.violations.append("placed while the simulation runs")
        self.plant.state, self._placed = state_meant(kinematics, self.plant.state), True
