"""The model-predictive controller for horizons on which a real-time iteration does not converge.

`mpc` linearises once, and takes the solution of the linear problem whole: right where the plan of the step before is close. Here each
sweep linearises anew, and its policy is flown through the model itself, with its feedback and within bounds. Of the whole step and shorter
ones the first is taken that lowers the cost (Li, Todorov, "Iterative linear quadratic regulator design for nonlinear biological movement
systems", ICINCO 2004; with bounds Tassa, Mansard, Todorov, "Control-limited differential dynamic programming", ICRA 2014). So a plan always
obeys the model, and no sweep makes it worse. A node's input is an offset from the reference's (`held_inputs`), and so no node is too long.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable
from typing import Any

from numba import njit

from hotlap.flight.compile import compiled_dynamics
from hotlap.flight.control_loop import ControlLoop, issue, predict
from hotlap.flight.job import Settings
from hotlap.flight.lanes import every, number, select
from hotlap.flight.mpc import Mpc, backward, linearise, terminal
from hotlap.flight.numbers import COMPILE, INLINE, aligned_zeros
from hotlap.flight.observer import push
from hotlap.flight.plan_offsets import add_reference, command_of, corrector, leave_reference
from hotlap.flight.riccati import GAIN_SIZE
from hotlap.flight.shooting import add_input_cost, add_state_cost, follow_policy, input_in_part, make_unit

TRIALS, SHORTER = 5, 0.25  # steps that are tried: 1, 1 / 4, 1 / 16, ...
LONGEST_PART = 0.05  # s, of a node


def _own_sizes(nodes: int, parts: int) -> dict[str, tuple[int, ...]]:
    """Shapes of what a search needs besides `Mpc`, for nodes of so many parts."""
    return {
        "states": (nodes + 1, 10), "cost": (2,), "share": (1,), "open": (1,), "fresh": (1,), "part": (1,),
        "inputs_in_parts": (nodes, parts, 4), "mean_inputs": (nodes, 4), "inputs_now": (4,), "gains_before": (nodes, GAIN_SIZE),
        "acting": (4,), "after": (10,), "attitude": (4,),
    }  # fmt: skip


SearchMpc = namedtuple("SearchMpc", (*Mpc._fields, *_own_sizes(0, 0)))  # noqa: PYI024  its first fields are those of another
"""Memory of the controller: that of `Mpc`, where X and U are offsets from the reference between control steps, and

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
    acting, after: (4,), (10,) input in a part, and the state after it; before that, the last plan's at a node.
    attitude: (4,) of a target before it is corrected.
"""


def allocate_search(memory: Mpc, parts: int) -> Any:
    """Raw memory `SearchMpc`, with that of a controller as its first part, for so many parts of a node."""
    lanes, kind, nodes = memory.X.shape[-1], memory.X.dtype.type, len(memory.U)
    memory.X[:, 3].fill(0)
    return SearchMpc(*memory, **{name: aligned_zeros((*size, lanes), kind) for name, size in _own_sizes(nodes, parts).items()})


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
    look, correct = corrector(model_has_drag=model_has_drag)
    warm_start, sweep = _iteration(_trial(node), _policy(linearise, backward))

    @njit(**INLINE)
    def control(s: Settings, m: Any, p: ControlLoop) -> None:
        """The whole step."""
        if s.corrected:
            look(s, p)
        predict(s, m.constants, p)
        if s.corrected:
            correct(s, m, p)
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


def _trial(node: Callable[..., None]) -> Any:
    """A compiled function of (memory, pushed) that flies the policy from the first state of the trial, and adds up what it costs."""

    @njit(**COMPILE)
    def fly_trial(m: Any, pushed: bool) -> None:
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

    return fly_trial


@njit(**COMPILE)
def take_trial(m: Any) -> None:
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


def _policy(linearise: Callable[..., None], backward: Callable[..., None]) -> Any:
    """A compiled function of (memory): gains and feed-forward around the plan, which obeys the model: deviations are zero."""

    @njit(**COMPILE)
    def find_policy(m: Any) -> None:
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

    return find_policy


def _iteration(fly_trial: Any, find_policy: Any) -> tuple[Any, Any]:
    """Two compiled functions, made from a trial and a policy: the warm start (memory, pushed), and a sweep (memory, stop_early, pushed)."""

    @njit(**COMPILE)
    def begin_policy(m: Any) -> None:
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
    def warm_start(m: Any, pushed: bool) -> None:
        """The last plan, flown with its own feedback from the state that the drone is in."""
        one = number(m.cost[1], 1.0)
        if not every(m.fresh[0] < 0.5):
            begin_policy(m)
        m.share[0] = number(one, 0.0)
        fly_trial(m, pushed)
        m.open[0], m.cost[0] = one, m.cost[1] + one
        take_trial(m)

    @njit(**COMPILE)
    def sweep(m: Any, stop_early: bool, pushed: bool) -> None:
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

    return warm_start, sweep


control_search = search(predict, linearise, backward, compiled_dynamics("node_map"))
