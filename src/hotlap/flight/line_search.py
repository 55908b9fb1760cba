"""The model-predictive controller for horizons on which a real-time iteration does not converge.

`mpc` linearises once, and takes the solution of the linear problem whole: right where the plan of the step before is close. Here each
sweep linearises anew, and its policy is flown through the model itself, with its feedback and within bounds. Of the whole step and shorter
ones the first is taken that lowers the cost (Li, Todorov, "Iterative linear quadratic regulator design for nonlinear biological movement
systems", ICINCO 2004; with bounds Tassa, Mansard, Todorov, "Control-limited differential dynamic programming", ICRA 2014). So a plan always
obeys the model, and no sweep makes it worse. A node's input is an offset from the reference's (`held_inputs`), and so no node is too long.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from numba import njit

from hotlap.flight.compile import compiled_dynamics
from hotlap.flight.control_loop import ControlLoop, issue, predict
from hotlap.flight.job import Settings
from hotlap.flight.lanes import every, number, select
from hotlap.flight.mpc import Mpc, backward, linearise, terminal
from hotlap.flight.numbers import COMPILE, INLINE, aligned_zeros
from hotlap.flight.observer import disturbance_of, observe, plan_bounds, push, push_of, turn_target
from hotlap.flight.riccati import GAIN_SIZE
from hotlap.flight.shooting import add_input_cost, add_state_cost, follow_policy, input_in_part, make_unit

TRIALS, SHORTER = 5, 0.25  # steps that are tried: 1, 1 / 4, 1 / 16, ...
LONGEST_PART = 0.05  # s, of a node


class SearchMpc(NamedTuple):
    """Memory of the controller; the first part is that of `Mpc`, where X and U are offsets from the reference between control steps.

    Attributes:
        states: (N + 1, 10) of the trial; its inputs are `inputs`.
        cost: (2,) of the plan, of the trial.
        share: (1,) of the feed-forward that the trial takes.
        open: (1,) 1 where the sweep has not lowered the cost yet.
        fresh: (1,) 1 where a flight begins.
        part: (1,) [s] length of a part of a node.
        inputs_in_parts: (N, parts, 4) of the reference.
        mean_inputs: (N, 4) of the reference over each node.
        inputs_now: (4,) of the reference over the present control period.
        gains_before: (N, 36) of the last control step.
        acting, after: (4,), (10,) input in a part, and the state after it.
    """

    X: Any
    U: Any
    reference: Any
    weights: Any
    input_weights: Any
    spacing: Any
    low: Any
    high: Any
    push: Any
    constants: Any
    inputs: Any
    deviation: Any
    change: Any
    jacobian: Any
    gains: Any
    feed: Any
    value: Any
    slope: Any
    scratch: Any
    needs_sweep: Any
    convergence: Any
    states: Any
    cost: Any
    share: Any
    open: Any
    fresh: Any
    part: Any
    inputs_in_parts: Any
    mean_inputs: Any
    inputs_now: Any
    gains_before: Any
    acting: Any
    after: Any


def allocate_search(memory: Mpc, parts: int) -> SearchMpc:
    """Raw memory, with that of a controller as its first part, for so many parts of a node."""
    lanes, kind, nodes = memory.X.shape[-1], memory.X.dtype.type, len(memory.U)
    sizes = {
        "states": (nodes + 1, 10), "cost": (2,), "share": (1,), "open": (1,), "fresh": (1,), "part": (1,),
        "inputs_in_parts": (nodes, parts, 4), "mean_inputs": (nodes, 4), "inputs_now": (4,), "gains_before": (nodes, GAIN_SIZE),
        "acting": (4,), "after": (10,),
    }  # fmt: skip
    memory.X[:, 3].fill(0)
    return SearchMpc(*memory, **{name: aligned_zeros((*size, lanes), kind) for name, size in sizes.items()})


def search(
    predict: Any, linearise: Callable[..., None], backward: Callable[..., None], node: Callable[..., None], *, model_has_drag: bool = False
) -> Any:
    """A compiled control step of (settings, memory, loop), on all lanes, made from a model; from the state seen to the command.

    Args:
        predict: from `predictor`.
        linearise: a node, as for `mpc.solver`.
        backward: likewise.
        node: (state, input, duration, constants, state after it).
        model_has_drag: whether the model has the vehicle's drags itself.
    """

    @njit(**COMPILE)
    def fly_trial(m: SearchMpc, pushed: bool) -> None:
        """Fly the policy from the first state of the trial, and add up what it costs."""
        nodes = len(m.U)
        m.cost[1] = number(m.cost[1], 0.0)
        for n in range(nodes):
            follow_policy(m.states[n], m.X[n], m.U[n], m.feed[n], m.gains[n], m.share, m.low, m.high, m.inputs[n])
            add_state_cost(m.states[n], m.reference[n], m.weights[n], m.cost[1:], m.cost[1:])
            add_input_cost(m.inputs[n], m.reference[n], m.input_weights, m.cost[1:], m.cost[1:])
            for i in range(10):
                m.states[n + 1, i] = m.states[n, i]
            for j in range(m.inputs_in_parts.shape[1]):
                input_in_part(m.inputs[n], m.reference[n], m.inputs_in_parts[n, j], m.low, m.high, m.acting)
                node(m.states[n + 1], m.acting, m.part, m.constants, m.after)
                if pushed:
                    push(m.after, m.push[n], m.part[0], 7)
                for i in range(10):
                    m.states[n + 1, i] = m.after[i]
                make_unit(m.states[n + 1])
        add_state_cost(m.states[nodes], m.reference[nodes], m.weights[nodes], m.cost[1:], m.cost[1:])

    @njit(**COMPILE)
    def take_trial(m: SearchMpc) -> None:
        """Make the trial the plan in lanes that are open and in which it costs less."""
        nodes, zero = len(m.U), number(m.cost[1], 0.0)
        better = select(m.cost[1] < m.cost[0], m.open[0], zero) > 0.5
        for n in range(nodes + 1):
            for i in range(10):
                m.X[n, i] = select(better, m.states[n, i], m.X[n, i])
        for n in range(nodes):
            for a in range(4):
                m.U[n, a] = select(better, m.inputs[n, a], m.U[n, a])
        m.cost[0] = select(better, m.cost[1], m.cost[0])
        m.open[0] = select(better, zero, m.open[0])

    @njit(**COMPILE)
    def find_policy(m: SearchMpc) -> None:
        """Gains and feed-forward around the plan, which obeys the model: deviations are zero."""
        nodes = len(m.U)
        for n in range(nodes):
            linearise(
                m.X[n], m.U[n], m.X[n + 1], m.deviation[n], m.spacing, m.low, m.high, m.constants,
                m.inputs[n], m.change[0], m.jacobian[n],
            )  # fmt: skip
        terminal(m.X[nodes], m.deviation[nodes], m.reference[nodes], m.weights[nodes], m.value[0], m.slope[0])
        for n in range(nodes - 1, -1, -1):
            now = (nodes - 1 - n) % 2
            backward(
                m.value[now], m.slope[now], m.jacobian[n], m.X[n], m.deviation[n], m.U[n], m.reference[n], m.weights[n],
                m.input_weights, m.spacing, m.low, m.high, m.value[1 - now], m.slope[1 - now], m.gains[n], m.feed[n], m.scratch,
            )  # fmt: skip

    @njit(**COMPILE)
    def begin_policy(m: SearchMpc) -> None:
        """Gains around the reference where a flight begins; other lanes keep theirs."""
        begins = m.fresh[0] > 0.5
        for n in range(len(m.U)):
            for i in range(m.gains.shape[1]):
                m.gains_before[n, i] = m.gains[n, i]
        find_policy(m)
        for n in range(len(m.U)):
            for i in range(m.gains.shape[1]):
                m.gains[n, i] = select(begins, m.gains[n, i], m.gains_before[n, i])

    @njit(**COMPILE)
    def warm_start(m: SearchMpc, pushed: bool) -> None:
        """The last plan, flown with its own feedback from the state that the drone is in."""
        one = number(m.cost[1], 1.0)
        if not every(m.fresh[0] < 0.5):
            begin_policy(m)
        m.share[0] = number(one, 0.0)
        fly_trial(m, pushed)
        m.open[0], m.cost[0] = one, m.cost[1] + one
        take_trial(m)

    @njit(**COMPILE)
    def sweep(m: SearchMpc, stop_early: bool, pushed: bool) -> None:
        """One policy, and the longest of its steps that lowers the cost."""
        find_policy(m)
        m.open[0] = number(m.cost[1], 1.0)
        m.share[0] = number(m.cost[1], 1.0)
        for _ in range(TRIALS):
            fly_trial(m, pushed)
            take_trial(m)
            m.share[0] = m.share[0] * SHORTER
            if stop_early and every(m.open[0] < 0.5):
                break

    @njit(**INLINE)
    def correct(s: Settings, m: SearchMpc, p: ControlLoop) -> None:
        """Observe, and correct targets, inputs and bounds for what was learnt and for drag."""
        observe(s, p)
        push_of(p, p.seen, p.acted, p.push)
        if model_has_drag:
            disturbance_of(p, p.push)
        for n in range(len(m.reference)):
            thrust = m.reference[n, 10]
            target = m.reference[n]
            push_of(p, target[:10], target[10:], m.push[n])
            turn_target(target, m.push[n], target)
            if model_has_drag:
                disturbance_of(p, m.push[n])
            change = m.reference[n, 10] - thrust
            if n == 0:
                m.inputs_now[0] = m.inputs_now[0] + change
            if n < len(m.U):
                m.mean_inputs[n, 0] = m.mean_inputs[n, 0] + change
                for j in range(m.inputs_in_parts.shape[1]):
                    m.inputs_in_parts[n, j, 0] = m.inputs_in_parts[n, j, 0] + change
        if s.offset_free:
            plan_bounds(s, p, m.low, m.high)

    @njit(**INLINE)
    def add_reference(m: SearchMpc) -> None:
        """Offsets become the plan."""
        for n in range(len(m.X)):
            for i in range(10):
                m.X[n, i] = m.X[n, i] + m.reference[n, i]
            make_unit(m.X[n])
        for n in range(len(m.U)):
            for a in range(4):
                m.reference[n, 10 + a] = m.mean_inputs[n, a]
                m.U[n, a] = m.U[n, a] + m.reference[n, 10 + a]
                m.U[n, a] = clipped(m.U[n, a], m.low[a], m.high[a])

    @njit(**INLINE)
    def leave_reference(m: SearchMpc) -> None:
        """The plan becomes offsets."""
        for n in range(len(m.X)):
            for i in range(10):
                m.X[n, i] = m.X[n, i] - m.reference[n, i]
        for n in range(len(m.U)):
            for a in range(4):
                m.U[n, a] = m.U[n, a] - m.reference[n, 10 + a]

    @njit(**INLINE)
    def command_of(s: Settings, m: SearchMpc) -> None:
        """What is commanded for a control period: the reference's inputs over it, and the mean of the plan's offsets."""
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
    def control(s: Settings, m: SearchMpc, p: ControlLoop) -> None:
        """The whole step."""
        if s.corrected:
            correct(s, m, p)
        predict(s, m.constants, p)
        add_reference(m)
        for i in range(10):
            m.states[0, i] = p.seen[i]
        warm_start(m, s.corrected)
        for _ in range(s.sweeps):
            sweep(m, s.stop_early, s.corrected)
        leave_reference(m)
        command_of(s, m)
        issue(s, p, m.acting)

    return control


@njit(**INLINE)
def clipped(value: Any, low: Any, high: Any) -> Any:
    """A number within bounds, lane by lane."""
    value = select(value < low, low, value)
    return select(value > high, high, value)


control_search = search(predict, linearise, backward, compiled_dynamics("node_map"))
