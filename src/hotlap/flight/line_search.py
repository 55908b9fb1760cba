"""The model-predictive controller where its problem is too long or too coarse for a real-time iteration.

One linearisation and its solution taken whole (`mpc`) converge where the plan of the step before is close. Here each sweep linearises
anew, and its policy is flown through the model itself, with feedback and within bounds; of full and smaller steps the first is taken
that lowers the cost (Tassa, Mansard, Todorov, "Control-limited differential dynamic programming", ICRA 2014, with Gauss-Newton
curvature). So a plan always obeys the model, and no sweep makes it worse.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from hotlap.dynamics.parameter_layout import NODE_JACOBIAN
from hotlap.flight.compile import compiled, compiled_dynamics
from hotlap.flight.control_loop import ControlLoop, issue, predict
from hotlap.flight.job import Job, Settings
from hotlap.flight.lanes import every, number, select
from hotlap.flight.mpc import allocate_mpc, backward, linearise, terminal
from hotlap.flight.mpc_reference import read_reference
from hotlap.flight.mpc_step import HORIZON, WEIGHTS
from hotlap.flight.numbers import COMPILE, INLINE, aligned_zeros
from hotlap.flight.program import Program, Tape, dot
from hotlap.flight.riccati import GAIN_SIZE, SCRATCH_SIZE
from hotlap.flight.segment_switch import BY_NODE, FRESH, piece_at, piece_flown

TRIALS = 5  # steps that are tried: 1, 1 / 4, 1 / 16, ...
SMALLER = 0.25
FINE = 80  # steps of the horizon in which plans are flown, at least


def policy_stage() -> Program:
    """(x, planned x, planned u, k, K, share, low, high) -> u + share k + K e within bounds, e from the planned x to x."""
    tape = Tape()
    sizes = (10, 10, 4, 4, GAIN_SIZE, 1, 4, 4)
    x, planned, u, feed, gains, (share,), low, high = (tape.array(k, size) for k, size in enumerate(sizes))
    a, b = planned[3:7], x[3:7]
    turn = [
        a[0] * b[1] - a[1] * b[0] - a[2] * b[3] + a[3] * b[2],
        a[0] * b[2] - a[2] * b[0] - a[3] * b[1] + a[1] * b[3],
        a[0] * b[3] - a[3] * b[0] - a[1] * b[2] + a[2] * b[1],
    ]  # vec(conj(planned) o q)
    e = [*(x[i] - planned[i] for i in range(3)), *(2.0 * part for part in turn), *(x[7 + i] - planned[7 + i] for i in range(3))]
    wanted = [u[n] + share * feed[n] + dot(gains[9 * n : 9 * n + 9], e) for n in range(4)]
    tape.store(8, [wanted[n].maximum(low[n]).minimum(high[n]) for n in range(4)])
    return tape.program


def cost_stage() -> Program:
    """(x, reference, Q, cost) -> cost with that of the state: halves of Q |x - reference|^2."""
    tape = Tape()
    x, r, (xy, z, attitude, velocity), (cost,) = (tape.array(k, size) for k, size in enumerate((10, 14, 4, 1)))
    weights = [xy, xy, z, *[attitude] * 4, *[velocity] * 3]
    errors = [x[i] - r[i] for i in range(10)]
    tape.store(4, [cost + 0.5 * dot([w * e for w, e in zip(weights, errors, strict=True)], errors)])
    return tape.program


def input_cost_stage() -> Program:
    """(u, reference, R, cost) -> cost with that of the input."""
    tape = Tape()
    u, r, weights, (cost,) = (tape.array(k, size) for k, size in enumerate((4, 14, 4, 1)))
    errors = [u[a] - r[10 + a] for a in range(4)]
    tape.store(4, [cost + 0.5 * dot([w * e for w, e in zip(weights, errors, strict=True)], errors)])
    return tape.program


def unit_stage() -> Program:
    """x with its quaternion normalised."""
    tape = Tape()
    x = tape.array(0, 10)
    scale = 1.0 / dot(x[3:7], x[3:7]).square_root()
    tape.store(0, [part * scale for part in x[3:7]], 3)
    return tape.program


def offset_stage() -> Program:
    """(u, reference, inputs of the reference in a part of the node, low, high) -> input in that part."""
    tape = Tape()
    u, r, part, low, high = (tape.array(k, size) for k, size in enumerate((4, 14, 4, 4, 4)))
    wanted = [part[a] + (u[a] - r[10 + a]) for a in range(4)]
    tape.store(5, [wanted[a].maximum(low[a]).minimum(high[a]) for a in range(4)])
    return tape.program


offset = compiled(offset_stage)
policy = compiled(policy_stage)
state_cost = compiled(cost_stage)
input_cost = compiled(input_cost_stage)
make_unit = compiled(unit_stage)


class SearchingMpc(NamedTuple):
    X: Any
    U: Any
    reference: Any
    weights: Any
    input_weights: Any
    spacing: Any
    low: Any
    high: Any
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
    fresh: Any
    kept: Any
    fine: Any
    now: Any
    part: Any
    step: Any
    after: Any


def allocate_searching(
    nodes: int, lanes: int, kind: type[np.floating[Any]], *, constants: int = 1, jacobian: int = NODE_JACOBIAN, scratch: int = SCRATCH_SIZE
) -> SearchingMpc:
    base = allocate_mpc(nodes, lanes, kind, constants=constants, jacobian=jacobian, scratch=scratch)
    sizes = (nodes + 1, 10), (2,), (1,), (1,), (nodes, GAIN_SIZE), (nodes, max(1, round(FINE / nodes)), 4), (4,), (1,), (4,), (10,)
    memory = SearchingMpc(*base, *(aligned_zeros((*size, lanes), kind) for size in sizes))
    memory.states[:, 3] = 1
    return memory


@njit(**INLINE)
def aim_searching(job: Job, s: Settings, mpc: Any, loop: ControlLoop, k: int, flight: int, before: int, time: float, elapsed: float) -> int:
    ahead = time + s.lead
    piece = piece_flown(job, s, loop.seen, k, before, ahead)
    segment = job.piece_segments[piece]
    spacing = job.parameters[flight, segment, HORIZON]
    leave_reference(mpc, k)
    mpc.fresh[0, k] = 0
    if before == FRESH:
        mpc.fresh[0, k] = 1
        for n in range(len(mpc.X)):
            for i in range(10):
                mpc.X[n, i, k] = 0
        for n in range(len(mpc.U)):
            for i in range(4):
                mpc.U[n, i, k] = 0
    else:
        move(mpc, k, mpc.spacing[0, k], spacing, elapsed)
    mpc.spacing[0, k] = spacing
    read_reference(mpc, k, job.table, s.table_period, ahead, spacing)
    read_inputs(mpc, k, job.table, s, ahead, spacing)
    for n in range(len(mpc.X)):
        for i in range(10):
            mpc.X[n, i, k] += mpc.reference[n, i, k]
    for n in range(len(mpc.U)):
        for a in range(4):
            mpc.U[n, a, k] = min(max(mpc.U[n, a, k] + mpc.reference[n, 10 + a, k], mpc.low[a, k]), mpc.high[a, k])
    for n in range(len(mpc.weights)):
        if s.segment_switch == BY_NODE:
            segment = job.piece_segments[piece_at(job.row_pieces, s.table_period, ahead + n * spacing)]
        for i in range(4):
            mpc.weights[n, i, k] = job.parameters[flight, segment, WEIGHTS[i]]
    return piece


@njit(**INLINE)
def leave_reference(m: Any, k: int) -> None:
    for n in range(len(m.X)):
        for i in range(10):
            m.X[n, i, k] -= m.reference[n, i, k]
    for n in range(len(m.U)):
        for a in range(4):
            m.U[n, a, k] -= m.reference[n, 10 + a, k]


@njit(**INLINE)
def move(m: Any, k: int, old: float, new: float, later: float) -> None:
    nodes = len(m.U)
    states, inputs, gains = m.X[:, :, k].copy(), m.U[:, :, k].copy(), m.gains[:, :, k].copy()
    for n in range(nodes + 1):
        place = (n * new + later) / old
        row = int(min(place, nodes))
        share = m.X.dtype.type(min(place - row, 1.0))
        following = min(row + 1, nodes)
        for i in range(10):
            m.X[n, i, k] = states[row, i] + share * (states[following, i] - states[row, i]) 
        if n < nodes:
            following, row = min(row + 1, nodes - 1), min(row, nodes - 1)
            for a in range(4):
                m.U[n, a, k] = inputs[row, a] + share * (inputs[following, a] - inputs[row, a])
            nearest = min(int(place + 0.5), nodes - 1)
            if nearest != n:
                for i in range(gains.shape[1]):
                    m.gains[n, i, k] = gains[nearest, i]


@njit(**INLINE)
def read_inputs(m: Any, k: int, table: np.ndarray, s: Settings, time: float, spacing: float) -> None:
    parts = m.fine.shape[1]
    last = len(table) - 2
    kind = m.reference.dtype.type
    for a in range(4):
        m.now[a, k] = mean_input(table, a, s, time, s.period, last)
    part = spacing / parts
    for n in range(len(m.U)):
        for a in range(4):
            total = kind(0)
            for j in range(parts):
                value = part_input(table, a, s, time, (n * parts + j) * part, part, last)
                m.fine[n, j, a, k] = value
                total += value
            m.reference[n, 10 + a, k] = total / parts
    m.part[0, k] = spacing / parts


@njit(**INLINE)
def mean_input(table: np.ndarray, a: int, s: Settings, time: float, span: float, last: int) -> Any:
    first = input_at(table, a, (time + 0.25 * span) / s.table_period, last)
    return (first + input_at(table, a, (time + 0.75 * span) / s.table_period, last)) / 2


@njit(**INLINE)
def part_input(table: np.ndarray, a: int, s: Settings, time: float, begin: float, part: float, last: int) -> Any:
    if s.period < 0.5 * part:
        return mean_input(table, a, s, time + begin, part, last)
    end = begin + part
    tick = math.floor(begin / s.period + 1e-9)
    total = table.dtype.type(0)
    while tick * s.period < end - 1e-9 * part:
        share = (min(end, (tick + 1) * s.period) - max(begin, tick * s.period)) / part
        total += table.dtype.type(share) * mean_input(table, a, s, time + tick * s.period, s.period, last)
        tick += 1
    return total


@njit(**INLINE)
def input_at(table: np.ndarray, a: int, place: float, last: int) -> Any:
    row = int(min(place, last))
    share = table.dtype.type(min(place - row, 1.0))
    return table[row, 10 + a] + share * (table[row + 1, 10 + a] - table[row, 10 + a])


def searching(predict: Any, linearise: Callable[..., None], backward: Callable[..., None], node: Callable[..., None]) -> Any:

    @njit(**COMPILE)
    def roll(m: Any) -> None:
        """Fly the policy with a share of its feed-forward from states[0]: states, inputs, cost[1]."""
        nodes = len(m.U)
        m.cost[1] = number(m.X[0, 0], 0.0)
        for n in range(nodes):
            policy(m.states[n], m.X[n], m.U[n], m.feed[n], m.gains[n], m.share, m.low, m.high, m.inputs[n])
            state_cost(m.states[n], m.reference[n], m.weights[n], m.cost[1:], m.cost[1:])
            input_cost(m.inputs[n], m.reference[n], m.input_weights, m.cost[1:], m.cost[1:])
            for i in range(10):
                m.states[n + 1, i] = m.states[n, i]
            for j in range(m.fine.shape[1]):
                offset(m.inputs[n], m.reference[n], m.fine[n, j], m.low, m.high, m.step)
                node(m.states[n + 1], m.step, m.part, m.constants, m.after)
                for i in range(10):
                    m.states[n + 1, i] = m.after[i]
                make_unit(m.states[n + 1])
        state_cost(m.states[nodes], m.reference[nodes], m.weights[nodes], m.cost[1:], m.cost[1:])

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

    @njit(**COMPILE)
    def start_policy(m: Any) -> None:
        for n in range(len(m.U)):
            for i in range(m.gains.shape[1]):
                m.kept[n, i] = m.gains[n, i]
        find_policy(m)
        for n in range(len(m.U)):
            for i in range(m.gains.shape[1]):
                m.gains[n, i] = select(m.fresh[0] > 0.5, m.gains[n, i], m.kept[n, i])

    @njit(**COMPILE)
    def improve(m: Any) -> None:
        one = number(m.X[0, 0], 1.0)
        find_policy(m)
        m.needs_sweep[0] = one
        m.share[0] = one
        for _ in range(TRIALS):
            roll(m)
            adopt(m)
            m.share[0] = m.share[0] * SMALLER
            if every(m.needs_sweep[0] < 0.5):
                break

    @njit(**COMPILE)
    def adopt(m: Any) -> None:
        zero = number(m.X[0, 0], 0.0)
        better = select(m.cost[1] < m.cost[0], m.needs_sweep[0], zero) > 0.5
        for n in range(len(m.U)):
            for i in range(10):
                m.X[n, i] = select(better, m.states[n, i], m.X[n, i])
            for a in range(4):
                m.U[n, a] = select(better, m.inputs[n, a], m.U[n, a])
        for i in range(10):
            m.X[len(m.U), i] = select(better, m.states[len(m.U), i], m.X[len(m.U), i])
        m.cost[0] = select(better, m.cost[1], m.cost[0])
        m.needs_sweep[0] = select(better, zero, m.needs_sweep[0])

    @njit(**COMPILE)
    def control(s: Settings, m: Any, p: ControlLoop) -> None:
        predict(s, m.constants, p)
        zero = number(m.X[0, 0], 0.0)
        for i in range(10):
            m.states[0, i] = p.seen[i]
        for n in range(len(m.X)):
            make_unit(m.X[n])
        if not every(m.fresh[0] < 0.5):
            start_policy(m)
        m.share[0] = zero
        roll(m)
        m.cost[0] = m.cost[1] + 1.0
        m.needs_sweep[0] = number(zero, 1.0)
        adopt(m)
        for _ in range(s.sweeps):
            improve(m)
        for a in range(4):
            m.step[a] = m.now[a]
        begin = number(m.X[0, 0], 0.0)
        span = number(m.X[0, 0], s.period)
        for n in range(len(m.U)):
            end = begin + m.spacing[0]
            end = select(end < span, end, span)
            for a in range(4):
                m.step[a] += (end - begin) / span * (m.U[n, a] - m.reference[n, 10 + a])
            begin = end
        for a in range(4):
            m.step[a] = select(m.step[a] < m.low[a], m.low[a], select(m.step[a] > m.high[a], m.high[a], m.step[a]))
        issue(p, m.step)

    return control


control_searching = searching(predict, linearise, backward, compiled_dynamics("node_map"))
