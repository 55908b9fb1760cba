"""The plan of `line_search` as offsets from its reference: the reference is corrected, added, left again, and the command is read off."""

from __future__ import annotations

from typing import Any

from numba import njit

from hotlap.flight.control_loop import ControlLoop
from hotlap.flight.job import Settings
from hotlap.flight.lanes import number, select
from hotlap.flight.numbers import INLINE
from hotlap.flight.observer import disturbance_of, observe, plan_bounds, push_of, turn_target
from hotlap.flight.shooting import make_unit

PASSES = 2  # the last plan's attitudes are offsets from targets that its drag turns


def corrector(*, model_has_drag: bool) -> tuple[Any, Any]:
    """Two compiled functions of (settings, memory, loop): observe; and, with the state predicted, correct for what was learnt and for drag.

    The second corrects targets, inputs and bounds, with the drag of the last plan as it was moved on, from the state predicted.

    Args:
        model_has_drag: whether the model has the vehicle's drags itself.
    """

    @njit(**INLINE)
    def look(s: Settings, p: ControlLoop) -> None:
        observe(s, p)
        push_of(p, p.seen, p.acted, p.push)
        if model_has_drag:
            disturbance_of(p, p.push)

    @njit(**INLINE)
    def correct(s: Settings, m: Any, p: ControlLoop) -> None:
        for n in range(len(m.reference)):
            thrust = m.reference[n, 10]
            for i in range(4):
                m.attitude[i] = m.reference[n, 3 + i]
            for _ in range(PASSES):
                planned_at(m, p, n)
                push_of(p, m.after, m.acting, m.push[n])
                m.reference[n, 10] = thrust
                for i in range(4):
                    m.reference[n, 3 + i] = m.attitude[i]
                turn_target(m.reference[n], m.push[n], m.reference[n])
            if model_has_drag:
                disturbance_of(p, m.push[n])
            add_thrust(m, n, m.reference[n, 10] - thrust)
        if s.offset_free:
            plan_bounds(s, p, m.low, m.high)

    return look, correct


@njit(**INLINE)
def planned_at(m: Any, p: ControlLoop, n: int) -> None:
    """State and input of the last plan at a node, to `after` and `acting`, whose first state is the one predicted."""
    for i in range(10):
        m.after[i] = m.X[n, i] + m.reference[n, i] if n > 0 else p.seen[i]
    make_unit(m.after)
    for a in range(4):
        m.acting[a] = m.U[min(n, len(m.U) - 1), a] + m.reference[n, 10 + a]


@njit(**INLINE)
def add_thrust(m: Any, n: int, change: Any) -> None:
    """Change the thrust of the reference over a node."""
    if n == 0:
        m.inputs_now[0] = m.inputs_now[0] + change
    if n < len(m.U):
        m.mean_inputs[n, 0] = m.mean_inputs[n, 0] + change
        for j in range(m.inputs_in_parts.shape[1]):
            m.inputs_in_parts[n, j, 0] = m.inputs_in_parts[n, j, 0] + change


@njit(**INLINE)
def add_reference(m: Any) -> None:
    """Offsets become the plan."""
    for n in range(len(m.X)):
        for i in range(10):
            m.X[n, i] = m.X[n, i] + m.reference[n, i]
        make_unit(m.X[n])
    for n in range(len(m.U)):
        for a in range(4):
            m.reference[n, 10 + a] = m.mean_inputs[n, a]
            m.U[n, a] = clipped(m.U[n, a] + m.reference[n, 10 + a], m.low[a], m.high[a])


@njit(**INLINE)
def leave_reference(m: Any) -> None:
    """The plan becomes offsets."""
    for n in range(len(m.X)):
        for i in range(10):
            m.X[n, i] = m.X[n, i] - m.reference[n, i]
    for n in range(len(m.U)):
        for a in range(4):
            m.U[n, a] = m.U[n, a] - m.reference[n, 10 + a]


@njit(**INLINE)
def command_of(s: Settings, m: Any) -> None:
    """What is commanded for a control period, `acting`: the reference's inputs over it, and the mean of the plan's offsets."""
    span, begin = number(m.cost[1], s.period), number(m.cost[1], 0.0)
    for a in range(4):
        m.acting[a] = m.inputs_now[a]
    for n in range(len(m.U)):
        end = begin + m.spacing[0]
        end = select(end < span, end, span)
        for a in range(4):
            m.acting[a] = m.acting[a] + (end - begin) / span * m.U[n, a]
        begin = end
    for a in range(4):
        m.acting[a] = clipped(m.acting[a], m.low[a], m.high[a])


@njit(**INLINE)
def clipped(value: Any, low: Any, high: Any) -> Any:
    """A number within bounds, lane by lane."""
    value = select(value < low, low, value)
    return select(value > high, high, value)
