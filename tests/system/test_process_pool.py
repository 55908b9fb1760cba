"""Work spread over processes: everything arrives, errors are heard, and no worker outlives its parent."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from hotlap.core.errors import HotlapError, InputError, PlanningError, StudyError, UnknownNameError
from hotlap.system.blas_threads import VARIABLES as ONE_THREAD
from hotlap.system.process_pool import spread

HERE = Path(__file__).parents[1]


def count(piece: int):
    for k in range(piece):
        yield piece, k, os.getpid()


def fail(piece: int):
    yield piece
    raise ValueError(f"piece {piece} is bad")


OURS = [
    HotlapError("plain"),
    InputError("file", "key", "is bad"),
    StudyError("folder", "", "is held"),
    UnknownNameError("race", "x", ["a"], "--race"),
    PlanningError("track", "gate 3", "too far"),
]


class ForeignError(Exception):
    """Cannot be built from its own arguments."""

    def __init__(self, one: int, two: int) -> None:
        super().__init__(f"{one} and {two}")


def complain(piece: int):
    yield piece
    raise OURS[piece] if piece < len(OURS) else ForeignError(1, 2)


def die(piece: int):
    yield piece
    os.kill(os.getpid(), signal.SIGKILL)


class Stillborn:
    """Work that ends the process which receives it."""

    def __call__(self, piece):
        yield piece

    def __reduce__(self):
        return os._exit, (1,)


def environment(_: int):
    yield {name: os.environ.get(name) for name in ONE_THREAD}


@pytest.mark.parametrize("processes", [1, 2, 3])
def test_every_result_of_every_piece_arrives_in_the_order_of_its_piece(processes):
    pieces = [3, 1, 4, 0, 2]
    found = list(spread(count, pieces, processes))
    assert all(piece == item[0] for piece, item in found)
    for piece in pieces:
        assert [item[1] for asked, item in found if asked == piece] == list(range(piece))
    helpers = {item[2] for _, item in found}
    assert (helpers == {os.getpid()}) == (processes == 1)


def test_nothing_to_do_is_done():
    assert list(spread(count, [], 2)) == []


@pytest.mark.parametrize("processes", [1, 2])
def test_an_error_of_a_piece_is_raised_after_its_results(processes):
    results, found = spread(fail, [1, 2], processes), []

    def take():
        for _, item in results:
            found.append(item)

    with pytest.raises(ValueError, match="is bad"):
        take()
    assert found


@pytest.mark.parametrize("piece", range(len(OURS)))
def test_our_errors_arrive_as_they_were(piece):
    with pytest.raises(type(OURS[piece])) as raised:
        list(spread(complain, [piece, piece], 2))
    assert str(raised.value) == str(OURS[piece])
    assert vars(raised.value) == vars(OURS[piece])


def test_a_foreign_error_arrives_in_words():
    with pytest.raises(RuntimeError, match="ForeignError: 1 and 2"):
        list(spread(complain, [len(OURS)] * 2, 2))


def test_a_worker_that_dies_is_not_waited_for():
    with pytest.raises(HotlapError, match="worker process has died"):
        list(spread(die, [1, 2], 2))


@pytest.mark.parametrize("size", [1, 10_000_000])
def test_a_worker_that_dies_before_it_has_read_its_piece_is_told_in_the_same_words(size):
    with pytest.raises(HotlapError, match="worker process has died"):
        list(spread(Stillborn(), [bytes(size)] * 2, 2))


def test_workers_use_one_thread_of_linear_algebra_and_the_parent_keeps_its_own(monkeypatch):
    monkeypatch.setenv(ONE_THREAD[0], "7")
    monkeypatch.delenv(ONE_THREAD[1], raising=False)
    found = [item for _, item in spread(environment, [1, 2], 2)]
    assert found == [dict.fromkeys(ONE_THREAD, "1")] * 2
    assert os.environ[ONE_THREAD[0]] == "7"
    assert ONE_THREAD[1] not in os.environ


def alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="ascii").split()[2] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="there is no /proc")
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_no_worker_outlives_a_parent_that_is_killed(number):
    program = "import system.test_process_pool as t\nfor _, pid in t.spread(t.count_slowly, [1, 2], 2): print(pid, flush=True)"
    with subprocess.Popen([sys.executable, "-c", program], cwd=HERE, stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        workers = {int(parent.stdout.readline()) for _ in range(6)}
        parent.send_signal(number)
    until = time.monotonic() + 20
    while any(map(alive, workers)) and time.monotonic() < until:
        time.sleep(0.05)
    assert not any(map(alive, workers))


def count_slowly(_: int):
    while True:
        yield os.getpid()
        time.sleep(0.05)
