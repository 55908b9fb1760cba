"""Stopping: Ctrl-C, SIGTERM and a terminal that is closed end a command in order, once; a second one ends it at once."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any, NoReturn

HANGUP = getattr(signal, "SIGHUP", None)  # Windows has none
SIGNALS = (signal.SIGINT, signal.SIGTERM, *([] if HANGUP is None else [HANGUP]))
AGAIN = 0.02  # s after which a signal that was dropped comes again


class Stopped(KeyboardInterrupt):
    """The user, or the machine, wants the command to end.

    Attributes:
        signal: which of `SIGNALS` said so.
    """

    def __init__(self, number: int) -> None:
        super().__init__()
        self.signal = number

    @property
    def code(self) -> int:
        """The exit status by which a shell knows it."""
        return 128 + self.signal


@contextmanager
def stopped_by_signals() -> Iterator[None]:
    """Raise `Stopped` where a signal arrives, also where a library made another error of it.

    A callback that a compiler calls, or the end of an object, cannot raise: Python drops what is raised there. Then the signal comes again.
    """
    received: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(number: int, _: FrameType | None) -> NoReturn:
        """The first signal stops the work in good order, a second one at once."""
        received.append(number)
        _restore(dict.fromkeys(before, signal.SIG_DFL))
        raise Stopped(number)

    def dropped(told: sys.UnraisableHookArgs) -> None:
        """Python has dropped an exception."""
        if not isinstance(told.exc_value, Stopped):
            hook(told)
            return
        _restore(dict.fromkeys(before, stop))
        again = threading.Timer(AGAIN, signal.pthread_kill, (threading.main_thread().ident, told.exc_value.signal))
        again.daemon = True
        again.start()

    hook, sys.unraisablehook = sys.unraisablehook, dropped
    before = {number: signal.signal(number, stop) for number in SIGNALS if not _outlives(number)}
    try:
        yield
    except Exception as error:
        if not received:
            raise
        stopped = Stopped(received[0])
        for remark in getattr(error, "__notes__", ()):
            stopped.add_note(remark)
        raise stopped from error
    finally:
        sys.unraisablehook = hook
        _restore(before)


@contextmanager
def remark(text: str) -> Iterator[None]:
    """What to say where what runs within is stopped; of several, the innermost counts."""
    try:
        yield
    except BaseException as error:
        error.add_note(text)
        raise


def _outlives(number: int) -> bool:
    """Whether the command is to go on without its terminal, as `nohup` has it."""
    return number == HANGUP and signal.getsignal(number) is signal.SIG_IGN


def _restore(handlers: dict[signal.Signals, Any]) -> None:
    for number, handler in handlers.items():
        signal.signal(number, handler)
