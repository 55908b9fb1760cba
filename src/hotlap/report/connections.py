"""Connections: those of a server that are open, each for a limited time, and no more than so many at once."""

from __future__ import annotations

import resource
import socket
import time
from collections.abc import Callable
from contextlib import suppress
from threading import Lock

MOST = 512


def most_at_once() -> int:
    """How many connections a server may have open: half of the files that the system lets a process open, at most 512.

    The other half is for studies, and for connections that are cut off and not yet closed. macOS lets a process open 256.
    """
    files, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return MOST if files == resource.RLIM_INFINITY else max(1, min(MOST, files // 2))


class Connections:
    """Which connections are open, the oldest first.

    A connection is cut off, not closed: whoever serves it finds its end and closes it.

    Args:
        most: how many may be open at once; one more cuts off the oldest of them.
        patience: [s] for which one may be open.
        clock: [s] tells the time.
    """

    def __init__(self, most: int, patience: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._most, self._patience, self._clock = most, patience, clock
        self._since: dict[socket.socket, float] = {}
        self._lock = Lock()

    def __len__(self) -> int:
        return len(self._since)

    def add(self, connection: socket.socket) -> None:
        """Count a new connection, and cut off the oldest where there are too many."""
        with self._lock:
            while len(self._since) >= self._most:
                self._cut(next(iter(self._since)))
            self._since[connection] = self._clock()

    def remove(self, connection: socket.socket) -> None:
        """Forget a connection that is being closed."""
        with self._lock:
            self._since.pop(connection, None)

    def expire(self) -> None:
        """Cut off those whose time is over."""
        with self._lock:
            over = self._clock() - self._patience
            for connection in [one for one, since in self._since.items() if since <= over]:
                self._cut(connection)

    def _cut(self, connection: socket.socket) -> None:
        del self._since[connection]
        with suppress(OSError):  # the other side was faster
            connection.shutdown(socket.SHUT_RDWR)
