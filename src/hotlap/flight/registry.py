"""The controller registry: the functions with which each controller flies. A new controller is a file with these and an entry here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from hotlap.core.parameters import Parameters
from hotlap.flight.generic_mpc import allocate_generic_mpc, begin_generic_mpc, generic_control
from hotlap.flight.geometric import aim_geometric, allocate_geometric, begin_geometric, control_geometric, gains_of
from hotlap.flight.mpc import allocate_mpc
from hotlap.flight.mpc_step import aim, begin_control, control, weights_of
from hotlap.race.controllers import ControllerKind
from hotlap.race.race import ControllerSettings


class ControllerFunctions(NamedTuple):
    """The functions of one controller, compiled by Numba but for the first two; each has memory of its own, a named tuple of arrays.

    Attributes:
        parameters_of: (settings, tuned parameters) -> the parameters in the units in which the controller computes, of the same shape.
        allocate: (nodes, lanes, kind of float) -> raw memory.
        begin: (job, settings, raw memory, lane): prepares a lane for a new flight.
        aim: (job, settings, raw memory, raw loop, lane, flight, piece before, time, elapsed) -> piece: reads the reference and the
            parameters of a lane's control step.
        control: (settings, memory, loop): one control step of all lanes, from the state `loop.seen` to the command `loop.history[0]`.
    """

    parameters_of: Callable[[ControllerSettings, Parameters], Parameters]
    allocate: Callable[..., Any]
    begin: Any
    aim: Any
    control: Any


CONTROLLERS: Mapping[ControllerKind, ControllerFunctions] = {
    ControllerKind.MPC: ControllerFunctions(weights_of, allocate_mpc, begin_control, aim, control),
    ControllerKind.MPC_DRAG: ControllerFunctions(
        weights_of, allocate_generic_mpc, begin_generic_mpc, aim, generic_control("drag_node_map")
    ),
    ControllerKind.GEOMETRIC: ControllerFunctions(gains_of, allocate_geometric, begin_geometric, aim_geometric, control_geometric),
}
