"""Signals become one exception, whatever a library makes of it, and handlers are given back."""

from __future__ import annotations

import ctypes
import signal
import threading

import pytest

from hotlap.cli.stopping import HANGUP, SIGNALS, Stopped, remark, stopped_by_signals


@pytest.fixture(autouse=True)
def terminal():
    """Tests may themselves run without one."""
    if HANGUP is None:
        yield
        return
    before = signal.signal(HANGUP, signal.SIG_DFL)
    yield
    signal.signal(HANGUP, before)


@pytest.mark.skipif(HANGUP is None, reason="a terminal that is closed sends no signal here")
def test_a_command_that_outlives_its_terminal_goes_on():
    signal.signal(HANGUP, signal.SIG_IGN)
    with stopped_by_signals():
        signal.raise_signal(HANGUP)
    assert signal.getsignal(HANGUP) is signal.SIG_IGN


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_stops_and_handlers_are_given_back(number):
    before = [signal.getsignal(each) for each in SIGNALS]
    with pytest.raises(Stopped) as stopped, stopped_by_signals():
        signal.raise_signal(number)
    assert stopped.value.code == 128 + number
    assert [signal.getsignal(each) for each in SIGNALS] == before


def through_a_library():
    """As wrappers of C++ do it."""
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt:
        raise RuntimeError("the solver was interrupted") from None


def test_what_a_library_makes_of_a_signal_is_still_a_stop():
    with pytest.raises(Stopped) as stopped, stopped_by_signals(), remark("outer"), remark("inner"):
        through_a_library()
    assert stopped.value.__notes__ == ["inner", "outer"]


def test_other_errors_pass():
    with pytest.raises(ValueError, match="mine"), stopped_by_signals():
        raise ValueError("mine")


def handlers_when_stopped() -> list:
    try:
        signal.raise_signal(signal.SIGTERM)
    except Stopped:
        return [signal.getsignal(number) for number in SIGNALS]
    return []


def test_a_second_signal_is_the_systems():
    with stopped_by_signals():
        assert handlers_when_stopped() == [signal.SIG_DFL] * len(SIGNALS)


def test_in_a_thread_signals_are_left_alone():
    ended = []

    def work():
        with stopped_by_signals():
            ended.append(True)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert ended


def wait_after(callback) -> None:
    callback()
    threading.Event().wait(10)
    raise AssertionError("the signal was lost")


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_in_a_callback_that_cannot_raise_stops_nevertheless(number, capfd):
    """As when a compiler asks for code that it has compiled before."""
    callback = ctypes.CFUNCTYPE(None)(lambda: signal.raise_signal(number))
    with pytest.raises(Stopped) as stop, stopped_by_signals():
        wait_after(callback)
    assert stop.value.signal == number
    assert stop.value.__cause__ is None
    assert capfd.readouterr().err == ""


def test_what_else_a_callback_raises_is_told_as_ever(monkeypatch):
    told = []
    monkeypatch.setattr("sys.unraisablehook", told.append)
    with stopped_by_signals():
        ctypes.CFUNCTYPE(None)(lambda: 1 / 0)()
    assert [type(one.exc_value) for one in told] == [ZeroDivisionError]
