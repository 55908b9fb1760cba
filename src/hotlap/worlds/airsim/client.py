"""Client: msgpack-rpc over TCP, as AirSim's server speaks it; every reply has a time-out, and every fault is one line."""

from __future__ import annotations

import itertools
import socket
from collections.abc import Iterator
from time import monotonic
from typing import Any

from hotlap.core.printable import printable
from hotlap.system.text_files import cause_of
from hotlap.worlds.simulator import SimulatorError

REQUEST, REPLY = 0, 1  # kinds of message
TIMEOUT = 5.0  # s, in which any call is answered
MOST_BYTES = 10_000_000  # of one reply
CHUNK = 65536  # bytes
LONGEST = 300  # characters of what a server says
IS_IT_RUNNING = 'is the simulator running, with "SimMode": "Multirotor" in its settings.json?'


class CallError(SimulatorError):
    """The server refuses a call.

    Attributes:
        said: what it says.
    """

    said = ""

    @property
    def unknown(self) -> bool:
        """Whether the server has no such call."""
        return "could not find function" in self.said

    @property
    def wants_other_arguments(self) -> bool:
        """Whether the server has the call with another number of arguments."""
        return "invalid number of arguments" in self.said


class Client:
    """One connection.

    Args:
        host: name or address.
        port: of TCP.
        timeout: [s] of the connection and of every reply.

    Attributes:
        name: of the simulator, for messages.
        lost: whether nothing more is to be expected of it.

    Raises:
        SimulatorError: nobody listens there, or msgpack is not installed; all methods raise it when the connection is lost.
    """

    def __init__(self, host: str, port: int, timeout: float = TIMEOUT) -> None:
        try:
            import msgpack  # noqa: PLC0415  an extra
        except ModuleNotFoundError:
            raise SimulatorError("msgpack is not installed: pip install 'hotlap[airsim]'") from None
        self.name, self.lost, self._timeout = f"AirSim at {host}:{port}", False, timeout
        self._packer = msgpack.Packer()
        self._unpacker = msgpack.Unpacker(raw=False, strict_map_key=False, unicode_errors="replace", max_buffer_size=MOST_BYTES)
        self._faults = (ValueError, TypeError, OverflowError, RecursionError, msgpack.UnpackException)
        self._numbers = itertools.count(1)
        self._asked: dict[int, str] = {}
        self._replies: dict[int, tuple[Any, Any]] = {}
        try:
            self._socket = socket.create_connection((host, port), timeout)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        except ConnectionRefusedError:
            raise self.fault(f"nobody listens there: {IS_IT_RUNNING}") from None
        except TimeoutError:
            raise self.fault(f"no answer within {timeout:g} s: {IS_IT_RUNNING}") from None
        except (OSError, UnicodeError) as error:
            raise self.fault(f"cannot be reached: {_reason(error)}") from None

    def fault(self, reason: str) -> SimulatorError:
        """The error that says what is wrong with this simulator."""
        return SimulatorError(f"{self.name}: {printable(reason)}")

    def call(self, method: str, *arguments: Any, patience: float = 0.0) -> Any:
        """Send a call and wait for what it returns.

        Args:
            method: its name.
            arguments: numbers, texts, lists and tables.
            patience: [s] more than the time-out.

        Raises:
            CallError: the server refuses it.
        """
        return self.reply(self.send(method, *arguments), patience)

    def send(self, method: str, *arguments: Any) -> int:
        """Send a call; returns the number by which its reply is known."""
        number = next(self._numbers)
        self._asked[number] = method
        try:
            self._socket.settimeout(self._timeout)
            self._socket.sendall(self._packer.pack([REQUEST, number, method, list(arguments)]))
        except OSError as error:
            raise self._broken(error) from None
        return number

    def reply(self, number: int, patience: float = 0.0) -> Any:
        """What a call that was sent returns.

        Raises:
            CallError: the server refuses it.
        """
        if not self.has_replied(number, self._timeout + patience):
            raise self._lose(f"{self._asked[number]} was not answered within {self._timeout + patience:.3g} s")
        method, (error, result) = self._asked.pop(number), self._replies.pop(number)
        if error is not None:
            said = error if isinstance(error, str) else repr(error)
            refusal = CallError(f"{self.name}: {method}: {printable(said[:LONGEST])}")
            refusal.said = said
            raise refusal
        return result

    def has_replied(self, number: int, patience: float) -> bool:
        """Whether a call is answered within a time [s]."""
        end = monotonic() + patience
        while number not in self._replies:
            left = end - monotonic()
            if left <= 0 or not self._receive(left):
                return False
        return True

    def close(self) -> None:
        """End the connection; may be called twice."""
        self._socket.close()

    def _receive(self, patience: float) -> bool:
        """Take in what arrives within a time [s]; returns whether something did."""
        try:
            self._socket.settimeout(patience)
            data = self._socket.recv(CHUNK)
        except TimeoutError:
            return False
        except OSError as error:
            raise self._broken(error) from None
        if not data:
            raise self._lose("it has closed the connection")
        for message in self._messages(data):
            self._keep(message)
        return True

    def _messages(self, data: bytes) -> Iterator[Any]:
        """The messages that are complete with these bytes."""
        try:
            self._unpacker.feed(data)
            yield from self._unpacker
        except self._faults:
            raise self._foreign() from None

    def _keep(self, message: Any) -> None:
        """Keep a reply until it is asked for."""
        if not isinstance(message, list) or len(message) != 4 or message[0] != REPLY:
            raise self._foreign()
        if not isinstance(message[1], int) or message[1] not in self._asked:
            raise self._foreign()
        self._replies[message[1]] = message[2], message[3]

    def _lose(self, reason: str) -> SimulatorError:
        """The error that ends the connection."""
        self.lost = True
        return self.fault(reason)

    def _foreign(self) -> SimulatorError:
        return self._lose("what it answers is not msgpack-rpc: is this the port of its API (41451 by default)?")

    def _broken(self, error: OSError) -> SimulatorError:
        return self._lose(f"the connection broke: {_reason(error)}")


def _reason(error: Exception) -> str:
    """Why a connection fails, in words."""
    return cause_of(error) if isinstance(error, OSError) else "this is no name of a machine"
