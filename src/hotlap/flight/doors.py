"""Doors: how each controller enters the flight core; a new one is a file with these four functions, and a line here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from hotlap.controllers import ControllerKind
from hotlap.flight.control import aim, begin_control, control
from hotlap.flight.geometric import aim_geometric, allocate_geometric, begin_geometric, control_geometric
from hotlap.flight.mpc import allocate_mpc
from hotlap.flight.own_model import allocate_own, begin_own, own_control


class Door(NamedTuple):
    """What a controller brings; the functions are compiled, their memory is a named tuple of its own.

    Attributes:
        allocate: (nodes, lanes, kind of float) -> raw memory.
        begin: (job, settings, raw memory, lane): sets a lane up for a new flight.
        aim: (job, settings, raw memory, raw pilot, lane, flight, piece before, time, elapsed) -> piece: what a lane is asked to do.
        control: (settings, memory, pilot): a control step on numbers, from `pilot.seen` to `pilot.history[0]`.
    """

    allocate: Callable[..., Any]
    begin: Any
    aim: Any
    control: Any


DOORS: Mapping[ControllerKind, Door] = {
    ControllerKind.MPC: Door(allocate_mpc, begin_control, aim, control),
    ControllerKind.MPC_DRAG: Door(allocate_own, begin_own, aim, own_control("drag_node_map")),
    ControllerKind.GEOMETRIC: Door(allocate_geometric, begin_geometric, aim_geometric, control_geometric),
}
