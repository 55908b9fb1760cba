"""Crazyflies that stand in for one, over UDP on loopback, each in a thread of its own."""

from __future__ import annotations

import threading
import time
from contextlib import contextmanager

from hotlap.real_flight import open_link
from hotlap.real_flight.crazyflie.onboard import OnBoard
from hotlap.real_flight.crazyflie.stand_in import StandIn
from real_flight.hangar import make_drone, make_scenario

SCENARIO = make_scenario()
PERIOD = 0.02  # s between states: as few as the race allows


@contextmanager
def serving(airborne=False, refuses=False, arms_itself=False, **settings):
    """One that stands below the start, or hovers there."""
    board = OnBoard(make_drone(SCENARIO, delay=0.0), arms_itself, refuses)
    if airborne:
        board.hover(SCENARIO.reference.position[0])
    stand_in = StandIn(board, **settings)
    thread = threading.Thread(target=stand_in.serve, daemon=True)
    thread.start()
    try:
        yield stand_in
    finally:
        stand_in.stop()
        thread.join()


def name_of(stand_in, *options):
    chosen = [*options, *(["clock=vehicle"] if stand_in.lockstep else [])]
    return f"crazyflie:udp://127.0.0.1:{stand_in.port}{'?' if chosen else ''}{'&'.join(chosen)}"


@contextmanager
def linked(stand_in, *options, mute=False):
    """An open link to it."""
    link = open_link(name_of(stand_in, *options), PERIOD, mute=mute)
    try:
        link.open(20.0)
        yield link
    finally:
        link.close()


def until(is_done, link=None):
    """Wait for something, and let the link hear meanwhile."""
    end = time.monotonic() + 20.0
    while not is_done():
        assert time.monotonic() < end
        if link is not None:
            link.receive(0.02)
        else:
            time.sleep(0.01)
