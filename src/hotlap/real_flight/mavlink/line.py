"""Line: a connection on which one vehicle is heard, and told, whoever else talks on it.

pymavlink joins what all senders say to a port of UDP, and sends to all of them. Two vehicles often have the same number, so each sender is
read by itself here, and once one is kept nothing is sent to another.
"""

from __future__ import annotations

import select
import socket
import time
from collections import deque
from contextlib import suppress
from types import ModuleType
from typing import Any

LARGEST = 65535  # bytes of a datagram
GONE = 0.005  # s after a line that is gone was read
FORGETTING = 0.5  # s at most

Sender = tuple[str, int] | None  # None: a serial line, or TCP, on which there is one


class Line:
    """Messages with their senders.

    Args:
        connection: of pymavlink.
        messages: its dialect.

    Attributes:
        only_kept: whether nobody but the sender that is kept is heard any more.
    """

    def __init__(self, connection: Any, messages: ModuleType) -> None:
        self._connection, self._messages = connection, messages
        port = connection.port
        self._is_udp = isinstance(port, socket.socket) and port.type == socket.SOCK_DGRAM
        self._parsers, self._waiting = dict[Sender, Any](), deque[tuple[Any, Sender]]()
        self._kept, self.only_kept = None, False

    @property
    def system(self) -> int:
        """Which number this end has."""
        return self._connection.mav.srcSystem

    def wait(self, longest: float) -> None:
        """Wait until something has come, for so many seconds at most."""
        if not self._waiting:
            with suppress(OSError, ValueError):
                select.select([self._connection.fd], [], [], longest)

    def receive(self) -> tuple[Any, Sender] | None:
        """The next message that has come, and who has sent it; None: there is none."""
        try:
            if self._is_udp:
                return self._receive_datagram()
            message = self._connection.recv_msg()
        except OSError:
            time.sleep(GONE)  # it counts as silent, and is ready to be read all the time
            return None
        return None if message is None else (message, None)

    def forget(self) -> None:
        """Drop what has come so far, as it is old."""
        end = time.monotonic() + FORGETTING
        while time.monotonic() < end and self.receive() is not None:
            pass

    def keep(self, sender: Sender, system: int) -> None:
        """Talk to one sender alone from now on, as a part of its system."""
        self._connection.mav.srcSystem, self._kept = system, sender
        self._tell({sender})

    def send(self, kind: str, *values: Any) -> None:
        """Send a message; a line that is gone takes none."""
        with suppress(OSError):
            getattr(self._connection.mav, f"{kind}_send")(*values)

    def close(self) -> None:
        """Close the connection."""
        with suppress(OSError):
            self._connection.close()

    def _receive_datagram(self) -> tuple[Any, Sender] | None:
        while not self._waiting:
            try:
                data, sender = self._connection.port.recvfrom(LARGEST)
            except (BlockingIOError, ConnectionRefusedError):
                return None
            if self.only_kept and sender != self._kept:
                continue
            if self._kept is None:
                self._tell({*self._parsers, sender})
            self._waiting.extend((message, sender) for message in self._parser(sender).parse_buffer(data) or [])
        return self._waiting.popleft()

    def _parser(self, sender: Sender) -> Any:
        if sender not in self._parsers:
            self._parsers[sender] = self._messages.MAVLink(None)
            self._parsers[sender].robust_parsing = True
        return self._parsers[sender]

    def _tell(self, senders: set[Sender]) -> None:
        """Who is sent what is sent from a port that listens; a connection to an address sends there."""
        if self._is_udp:
            self._connection.clients = senders
            self._connection.last_address = next(iter(senders))
