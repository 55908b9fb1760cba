"""A control step: where the drone is and what it is asked to track in, a command out.

`aim` is done lane by lane on raw memory, `control` on all lanes at once. The same functions fly in the simulation and in `Controller`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from hotlap.flight.job import Job, Settings
from hotlap.flight.lanes import number
from hotlap.flight.mpc import Mpc, propagate, solve
from hotlap.flight.numbers import INLINE, aligned_zeros
from hotlap.flight.tracking import hover_inputs, plan_as_reference, read_reference, respace_plan

FRESH = -1  # segment of a lane that has not been controlled yet


class Pilot(NamedTuple):
    """Memory of the control loop around the controller; raw floats (..., lanes), or numbers (...).

    Attributes:
        seen: (10,) state p q v as measured.
        history: (H, 4) commands, the newest first.
        shift: (1,) share of a node by which the plan moves on.
        span: (1,) [s] of a prediction.
        predicted: (10,) state after it.
    """

    seen: Any
    history: Any
    shift: Any
    span: Any
    predicted: Any


def allocate_pilot(commands: int, lanes: int, kind: type[np.floating[Any]]) -> Pilot:
    """Raw memory, of one kind of float, for so many commands."""
    sizes = ((10,), (commands, 4), (1,), (1,), (10,))
    return Pilot(*(aligned_zeros((*size, lanes), kind) for size in sizes))


@njit(**INLINE)
def begin_control(job: Job, s: Settings, mpc: Mpc, pilot: Pilot, k: int) -> None:
    """Set a lane up for a new flight: it has been hovering."""
    for n in range(4):
        mpc.input_weights[n, k], mpc.low[n, k], mpc.high[n, k] = job.input_weights[n], job.low[n], job.high[n]
    mpc.gravity[0, k] = s.gravity
    pilot.history[:, :, k] = 0
    pilot.history[:, 0, k] = s.gravity


@njit(**INLINE)
def aim(job: Job, s: Settings, mpc: Mpc, pilot: Pilot, k: int, flight: int, before: int, time: float, elapsed: float) -> int:
    """Reference and weights of a lane's control step, and how its plan moves on.

    Args:
        job: whose reference and parameters.
        s: settings.
        mpc: raw memory, of which the lane's is written.
        pilot: likewise.
        k: the lane.
        flight: whose parameters.
        before: segment of the step before, or FRESH.
        time: [s] of the flight.
        elapsed: [s] since the step before.

    Returns:
        The segment that the weights are of.
    """
    ahead = time + s.lead
    segment = job.row_segments[min(int(ahead / s.table_period + 1e-6), len(job.row_segments) - 1)]
    parameters = job.parameters[flight, segment]
    spacing = parameters[4]
    read_reference(mpc, k, job.table, s.table_period, ahead, spacing)
    if not s.feed_forward:
        hover_inputs(mpc, k)
    pilot.shift[0, k] = 0
    if before == segment:
        pilot.shift[0, k] = min(elapsed / spacing, 1.0)
    else:
        if before == FRESH:
            plan_as_reference(mpc, k)
        else:
            respace_plan(mpc, k, job.parameters[flight, before, 4], spacing, elapsed)
        for n in range(4):
            mpc.weights[n, k] = parameters[n]
        mpc.spacing[0, k] = spacing
    return segment


@njit(**INLINE)
def control(s: Settings, m: Mpc, p: Pilot) -> None:
    """One control step on all lanes: from the state seen to the command, `history[0]`."""
    for n in range(len(m.U)):  # the warm start
        for i in range(10):
            m.X[n, i] += p.shift[0] * (m.X[n + 1, i] - m.X[n, i])
    for n in range(len(m.U) - 1):
        for a in range(4):
            m.U[n, a] += p.shift[0] * (m.U[n + 1, a] - m.U[n, a])
    for i in range(10):
        m.X[0, i] = p.seen[i]
    _predict(s, m, p)
    solve(m, s.sweeps)
    for n in range(len(p.history) - 1, 0, -1):
        for a in range(4):
            p.history[n, a] = p.history[n - 1, a]
    for a in range(4):
        p.history[0, a] = m.U[0, a]


@njit(**INLINE)
def _predict(s: Settings, m: Mpc, p: Pilot) -> None:
    """Where the drone will be when the command acts: through the commands on their way, by the controller's own model."""
    for n in range(s.predicted_periods, -1, -1):
        duration = s.predicted_rest if n == s.predicted_periods else s.period
        if duration > 0:
            p.span[0] = number(m.X[0, 0], duration)
            propagate(m.X[0], p.history[n], p.span, m.gravity, p.predicted)
            for i in range(10):
                m.X[0, i] = p.predicted[i]
