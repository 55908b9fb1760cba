"""A control step of the model-predictive controller: from the state and the reference to a command.

`aim` is done lane by lane on raw memory, `control` on all lanes at once. The same functions fly in the simulation and in `Controller`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from hotlap.core.parameters import Parameters
from hotlap.flight.control_loop import ControlLoop, issue, predict
from hotlap.flight.job import Job, Settings
from hotlap.flight.mpc import Mpc, solve
from hotlap.flight.mpc_reference import hover_inputs, plan_as_reference, read_reference, respace_plan
from hotlap.flight.numbers import INLINE
from hotlap.flight.observer import disturbance_of, observe, plan_bounds, push_of, turn_target
from hotlap.flight.segment_switch import BY_NODE, FRESH, piece_at, piece_flown
from hotlap.race.controllers import TUNABLE, ControllerKind
from hotlap.race.race import ControllerSettings

_NAMES = TUNABLE[ControllerKind.MPC].names
HORIZON = _NAMES.index("horizon")
WEIGHTS = tuple(_NAMES.index(name) for name in ("Q_pos_xy", "Q_pos_z", "Q_attitude", "Q_velocity"))  # in the order of `Mpc.weights`


def weights_of(settings: ControllerSettings, parameters: Parameters) -> Parameters:
    """The tuned parameters with the time between the nodes [s] in place of the horizon; a copy."""
    changed = np.array(parameters, dtype=np.float64, order="C")
    changed[..., HORIZON] *= settings.horizon_unit / settings.nodes
    return changed


@njit(**INLINE)
def begin_control(job: Job, s: Settings, mpc: Mpc, k: int) -> None:
    """Prepare a lane for a new flight."""
    for n in range(4):
        mpc.input_weights[n, k], mpc.low[n, k], mpc.high[n, k] = job.input_weights[n], job.low[n], job.high[n]
    mpc.constants[0, k] = s.gravity


@njit(**INLINE)
def aim(job: Job, s: Settings, mpc: Mpc, loop: ControlLoop, k: int, flight: int, before: int, time: float, elapsed: float) -> int:
    """Read the reference and the weights of a lane's control step, and say by how much its last plan is shifted.

    Args:
        job: the batch, with the reference and the parameters.
        s: its settings.
        mpc: raw memory of the controller; that of the lane is written.
        loop: raw memory of the control loop; likewise.
        k: the lane.
        flight: whose parameters.
        before: piece of the step before, or FRESH.
        time: [s] since the start of the flight.
        elapsed: [s] since the step before.

    Returns:
        The piece that the parameters belong to.
    """
    ahead = time + s.lead
    piece = piece_flown(job, s, loop.seen, k, before, ahead)
    segment = job.piece_segments[piece]
    spacing = job.parameters[flight, segment, HORIZON]
    read_reference(mpc, k, job.table, s.table_period, ahead, spacing)
    if not s.feed_forward:
        hover_inputs(mpc, k, s.gravity)
    loop.shift[0, k] = 0
    if before != FRESH and job.piece_segments[before] == segment:
        loop.shift[0, k] = min(elapsed / spacing, 1.0)
    else:
        if before == FRESH:
            plan_as_reference(mpc, k)
        else:
            respace_plan(mpc, k, job.parameters[flight, job.piece_segments[before], HORIZON], spacing, elapsed)
        for n in range(len(mpc.weights)):
            for i in range(4):
                mpc.weights[n, i, k] = job.parameters[flight, segment, WEIGHTS[i]]
        mpc.spacing[0, k] = spacing
    if s.segment_switch == BY_NODE:
        for n in range(len(mpc.weights)):
            segment = job.piece_segments[piece_at(job.row_pieces, s.table_period, ahead + n * spacing)]
            for i in range(4):
                mpc.weights[n, i, k] = job.parameters[flight, segment, WEIGHTS[i]]
    return piece


@njit(**INLINE)
def move_plan(m: Mpc, p: ControlLoop) -> None:
    """The warm start on all lanes: the last plan, shifted by the time that has passed."""
    for n in range(len(m.U)):
        for i in range(10):
            m.X[n, i] += p.shift[0] * (m.X[n + 1, i] - m.X[n, i])
    for n in range(len(m.U) - 1):
        for a in range(4):
            m.U[n, a] += p.shift[0] * (m.U[n + 1, a] - m.U[n, a])


def controls(predict: Any, solve: Any, *, model_has_drag: bool = False) -> tuple[Any, Any]:
    """Two compiled functions of (settings, memory, loop), on all lanes, made from a model's predictor and solver.

    Args:
        predict: from `predictor`.
        solve: from `solver`.
        model_has_drag: whether the model has the vehicle's drags itself.

    Returns:
        The plan that a control step begins with, from the state seen as it will be when the command acts; and the whole step, from
        the state seen to the command, `history[0]`.
    """

    @njit(**INLINE)
    def correct(s: Settings, m: Mpc, p: ControlLoop) -> None:
        """Correct targets and bounds, at the last plan, for what was learnt and for drag."""
        for n in range(len(m.reference)):
            push_of(p, m.X[n], m.U[min(n, len(m.U) - 1)], m.push[n])
            turn_target(m.reference[n], m.push[n], m.reference[n])
            if model_has_drag:
                disturbance_of(p, m.push[n])
        if s.offset_free:
            plan_bounds(s, p, m.low, m.high)

    @njit(**INLINE)
    def begin_plan(s: Settings, m: Mpc, p: ControlLoop) -> None:
        """Move the last plan on, and begin it at the state predicted."""
        if s.corrected:
            observe(s, p)
            push_of(p, p.seen, p.acted, p.push)
            if model_has_drag:
                disturbance_of(p, p.push)
        move_plan(m, p)
        predict(s, m.constants, p)
        for i in range(10):
            m.X[0, i] = p.seen[i]
        if s.corrected:
            correct(s, m, p)

    @njit(**INLINE)
    def control(s: Settings, m: Mpc, p: ControlLoop) -> None:
        """The whole step."""
        begin_plan(s, m, p)
        solve(m, s.sweeps, s.stop_early, s.corrected)
        issue(s, p, m.U[0])

    return begin_plan, control


begin_plan, control = controls(predict, solve)
