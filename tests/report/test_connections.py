"""Connections are open for a limited time, and only so many at once."""

from __future__ import annotations

import socket
from contextlib import ExitStack

import pytest

from hotlap.report.connections import Connections


@pytest.fixture
def pairs():
    with ExitStack() as stack:
        yield [tuple(map(stack.enter_context, socket.socketpair())) for _ in range(4)]


def is_open(pair):
    """Whether the other side of a pair still waits."""
    pair[1].settimeout(0.01)
    try:
        return pair[1].recv(1) != b""
    except TimeoutError:
        return True


def test_the_oldest_makes_way(pairs):
    connections = Connections(2, 10.0)
    for ours, _ in pairs:
        connections.add(ours)
    assert [is_open(pair) for pair in pairs] == [False, False, True, True]
    connections.remove(pairs[2][0])
    connections.remove(pairs[0][0])
    assert len(connections) == 1


def test_whose_time_is_over_is_cut_off(pairs):
    now = 0.0
    connections = Connections(10, 10.0, lambda: now)
    for ours, _ in pairs:
        connections.add(ours)
        now += 4.0
    pairs[0][0].close()
    now = 14.0
    connections.expire()
    assert [is_open(pair) for pair in pairs[1:]] == [False, True, True]
    assert len(connections) == 2
