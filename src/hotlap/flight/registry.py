"""Doors: how each controller enters the flight core; a new one is a file with these four functions, and a line here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from hotlap.flight.generic_mpc import allocate_own, begin_own, own_control
from hotlap.flight.geometric import aim_geometric, allocate_geometric, begin_geometric, control_geometric
from hotlap.flight.mpc import allocate_mpc
from hotlap.flight.mpc_step import aim, begin_control, control
from hotlap.race.controllers import ControllerKind


class ControllerFunctions(NamedTuple):
    """What a controller brings; the functions are compiled, their memory is a named tuple of its own.

    Attributes:
        allocate: (nodes, lanes, kind of float) -> raw memory.
        begin: (job, settings, raw memory, lane): sets a lane up for a new flight.
        aim: (job, settings, raw memory, raw loop, lane, flight, piece before, time, elapsed) -> piece: what a lane is asked to do.
        control: (settings, memory, loop): a control step on numbers, from `loop.seen` to `loop.history[0]`.
    """

    allocate: Callable[..., Any]
    begin: Any
    aim: Any
    control: Any


CONTROLLERS: Mapping[ControllerKind, ControllerFunctions] = {
    ControllerKind.MPC: ControllerFunctions(allocate_mpc, begin_control, aim, control),
    ControllerKind.MPC_DRAG: ControllerFunctions(allocate_own, begin_own, aim, own_control("drag_node_map")),
    ControllerKind.GEOMETRIC: ControllerFunctions(allocate_geometric, begin_geometric, aim_geometric, control_geometric),
}
