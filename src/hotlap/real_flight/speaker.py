"""Speaker: says lines in a thread of its own, so that a terminal that takes none, or a slow one, does not hold up a flight."""

from __future__ import annotations

import threading
from collections.abc import Callable
from queue import SimpleQueue
from types import TracebackType
from typing import Self

PATIENCE = 1.0  # s for what is still to be said at the end


class Speaker:
    """Takes lines at once, and says them as fast as they are taken; a context, at whose end all has been said.

    Args:
        say: what may take its time.
    """

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say, self._lines = say, SimpleQueue[str | None]()
        self._thread = threading.Thread(target=self._speak, name="speaker", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._lines.put(None)
        self._thread.join(PATIENCE)

    def __call__(self, line: str) -> None:
        """Say a line, later."""
        self._lines.put(line)

    def _speak(self) -> None:
        while (line := self._lines.get()) is not None:
            self._say(line)
