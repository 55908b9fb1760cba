"""The controller registry: the functions with which each controller flies. A new controller is a file with these and an entry here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from hotlap.core.parameters import Parameters
from hotlap.flight.generic_mpc import allocate_generic_mpc, begin_generic_mpc, generic_control, generic_search
from hotlap.flight.geometric import aim_geometric, allocate_geometric, begin_geometric, control_geometric, gains_of
from hotlap.flight.held_inputs import aim_search
from hotlap.flight.job import Settings
from hotlap.flight.line_search import allocate_search, control_search
from hotlap.flight.mpc import allocate_mpc
from hotlap.flight.mpc_step import aim, begin_control, control, weights_of
from hotlap.race.controller_kind import Solver, law_of
from hotlap.race.controllers import ControllerKind
from hotlap.race.race import ControllerSettings


class ControllerFunctions(NamedTuple):
    """The functions of one controller, compiled by Numba but for the first two; each has memory of its own, a named tuple of arrays.

    Attributes:
        parameters_of: (settings, tuned parameters) -> the parameters in the units in which the controller computes, of the same shape.
        allocate: (settings, lanes, kind of float) -> raw memory.
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


def _by_nodes(allocate: Callable[..., Any]) -> Callable[..., Any]:
    """Memory that depends on the number of nodes alone."""
    return lambda settings, lanes, kind: allocate(settings.nodes, lanes, kind)


def _with_search(allocate: Callable[..., Any]) -> Callable[..., Any]:
    """Memory of an MPC that searches."""

    def allocate_whole(settings: Settings, lanes: int, kind: type[np.floating[Any]]) -> Any:
        return allocate_search(allocate(settings.nodes, lanes, kind), settings.node_parts)

    return allocate_whole


DRAG = "drag_node_map"  # the model of mpc_drag

CONTROLLERS: Mapping[str, ControllerFunctions] = {
    law_of(ControllerKind.MPC): ControllerFunctions(weights_of, _by_nodes(allocate_mpc), begin_control, aim, control),
    law_of(ControllerKind.MPC_DRAG): ControllerFunctions(
        weights_of, _by_nodes(allocate_generic_mpc), begin_generic_mpc, aim, generic_control(DRAG)
    ),
    law_of(ControllerKind.GEOMETRIC): ControllerFunctions(
        gains_of, _by_nodes(allocate_geometric), begin_geometric, aim_geometric, control_geometric
    ),
    law_of(ControllerKind.MPC, Solver.LINE_SEARCH): ControllerFunctions(
        weights_of, _with_search(allocate_mpc), begin_control, aim_search, control_search
    ),
    law_of(ControllerKind.MPC_DRAG, Solver.LINE_SEARCH): ControllerFunctions(
        weights_of, _with_search(allocate_generic_mpc), begin_generic_mpc, aim_search, generic_search(DRAG)
    ),
}
"""By control law: a kind of controller, and how it solves its problem."""
