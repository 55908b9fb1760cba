"""The model-predictive controller (Eq. 3 of the paper) as a real-time iteration: one linearisation and a few Riccati sweeps a step.

It computes with numbers (`lanes`): one flight, or one flight in each lane. Its memory `Mpc` is seen in two ways: as raw floats
(..., lanes), for what is done lane by lane, and as numbers (...), for what is done on all lanes at once.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from hotlap.dynamics.parameter_layout import NODE_JACOBIAN
from hotlap.flight.compile import compiled, compiled_dynamics
from hotlap.flight.lanes import every, number, select
from hotlap.flight.numbers import COMPILE, aligned_zeros
from hotlap.flight.observer import push
from hotlap.flight.program import Program, Tape, dot
from hotlap.flight.riccati import GAIN_SIZE, P_SIZE, SCRATCH_SIZE, backward_stage, forward_stage, terminal_stage

AT_REST = 1e-4  # change of an input: a lane whose sweep changed none by more needs no further sweep


def retract_stage() -> Program:
    """(x, deviation) -> x moved by it: q o [1, theta / 2], normalised."""
    tape = Tape()
    x, deviation = tape.array(0, 10), tape.array(1, 9)
    (w, a, b, c), (i, j, k) = x[3:7], [0.5 * part for part in deviation[3:6]]
    turned = [w - a * i - b * j - c * k, a + w * i + b * k - c * j, b + w * j - a * k + c * i, c + w * k + a * j - b * i]
    scale = 1.0 / dot(turned, turned).square_root()
    moved = [x[n] + deviation[n] for n in range(3)], [part * scale for part in turned], [x[7 + n] + deviation[6 + n] for n in range(3)]
    tape.store(2, [entry for part in moved for entry in part])
    return tape.program


linearise = compiled_dynamics("linearised_node_map")
terminal = compiled(terminal_stage)
backward = compiled(backward_stage)
forward = compiled(forward_stage)
retract = compiled(retract_stage)


class Mpc(NamedTuple):
    """Memory of the controller: the plan, the problem and what the solver needs; N nodes.

    Attributes:
        X: (N + 1, 10) planned states p q v; X[0] is where the drone is.
        U: (N, 4) planned inputs: thrust per mass, body rates.
        reference: (N + 1, 14) p q v, inputs.
        weights: (N + 1, 4) Q of p_xy, p_z, attitude, velocity.
        input_weights: (4,) R.
        spacing: (1,) [s] time between nodes.
        low, high: (4,) bounds of the inputs.
        push: (N + 1, 3) [m/s^2] (world) acceleration that acts at each node besides the model; see `observer`.
        constants: (V,) parameters of the model: gravity [m/s^2] first, which is all that the paper's model has.
        inputs: (N, 4) inputs that the present sweep has found.
        deviation: (N + 1, 9) of the states that the present sweep has found from the planned ones, in tangent coordinates.
        change: (2, 9) of the deviation, at two nodes.
        jacobian: (N, J) of each node; of the paper's model as in `dynamics.node_jacobian`.
        gains, feed: (N, 36), (N, 4) policy.
        value, slope: (2, 45), (2, 9) P and p, at two nodes.
        scratch: of the backward stage.
        needs_sweep: (1,) 1 where the solution has not converged: another sweep may change it.
        convergence: (2,) of the last sweep: largest change of an input; 1 if an input is at a bound.
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


def allocate_mpc(
    nodes: int, lanes: int, kind: type[np.floating[Any]], *, constants: int = 1, jacobian: int = NODE_JACOBIAN, scratch: int = SCRATCH_SIZE
) -> Mpc:
    """Raw memory, of one kind of float; a lane without a flight computes with ones, so that it divides by no zero.

    Args:
        nodes: N.
        lanes: how many flights it is for.
        kind: of float.
        constants: numbers that the model takes.
        jacobian: numbers of a node's Jacobian.
        scratch: numbers that the backward stage keeps.
    """
    sizes = {
        "X": (nodes + 1, 10), "U": (nodes, 4), "reference": (nodes + 1, 14), "weights": (nodes + 1, 4), "input_weights": (4,),
        "spacing": (1,), "low": (4,), "high": (4,), "push": (nodes + 1, 3), "constants": (constants,),
        "inputs": (nodes, 4), "deviation": (nodes + 1, 9),
        "change": (2, 9), "jacobian": (nodes, jacobian), "gains": (nodes, GAIN_SIZE), "feed": (nodes, 4), "value": (2, P_SIZE),
        "slope": (2, 9), "scratch": (scratch,), "needs_sweep": (1,), "convergence": (2,),
    }  # fmt: skip
    memory = Mpc(**{name: aligned_zeros((*size, lanes), kind) for name, size in sizes.items()})
    for array in (memory.weights, memory.input_weights, memory.spacing, memory.constants, memory.X[:, 3], memory.reference[:, 3]):
        array.fill(1)
    return memory


def solver(linearise: Callable[..., None], backward: Callable[..., None], forward: Callable[..., None]) -> Any:
    """A compiled solver made of given stages: (memory, sweeps, stop_early, pushed) replaces the plan (X, U) by the solution around it.

    A push of `Mpc.push` is an acceleration that does not depend on state and input: it moves where a node leads, and leaves the Jacobian.

    A sweep that meets no bound is exact. Further ones change only lanes in which a bound was met and an input moved, so that no lane
    depends on its neighbours.
    """

    @njit(**COMPILE)
    def sweep(m: Mpc) -> None:
        nodes = len(m.U)
        zero = number(m.X[0, 0], 0.0)
        terminal(m.X[nodes], m.deviation[nodes], m.reference[nodes], m.weights[nodes], m.value[0], m.slope[0])
        for n in range(nodes - 1, -1, -1):
            now = (nodes - 1 - n) % 2
            backward(
                m.value[now], m.slope[now], m.jacobian[n], m.X[n], m.deviation[n], m.inputs[n], m.reference[n], m.weights[n],
                m.input_weights, m.spacing, m.low, m.high, m.value[1 - now], m.slope[1 - now], m.gains[n], m.feed[n], m.scratch,
            )  # fmt: skip
        for i in range(9):
            m.change[0, i] = zero
        m.convergence[0] = zero
        m.convergence[1] = zero
        for n in range(nodes):
            now = n % 2
            forward(
                m.jacobian[n], m.gains[n], m.feed[n], m.change[now], m.inputs[n], m.deviation[n + 1], m.spacing, m.low, m.high,
                m.needs_sweep, m.convergence, m.inputs[n], m.change[1 - now], m.deviation[n + 1], m.convergence,
            )  # fmt: skip

    @njit(**COMPILE)
    def solve(m: Mpc, sweeps: int, stop_early: bool = True, pushed: bool = False) -> None:
        nodes = len(m.U)
        zero = number(m.X[0, 0], 0.0)
        for i in range(9):
            m.deviation[0, i] = zero
        for n in range(nodes):
            linearise(
                m.X[n], m.U[n], m.X[n + 1], m.deviation[n], m.spacing, m.low, m.high, m.constants,
                m.inputs[n], m.deviation[n + 1], m.jacobian[n],
            )  # fmt: skip
            if pushed:
                push(m.deviation[n + 1], m.push[n], m.spacing[0], 6)
        m.needs_sweep[0] = number(zero, 1.0)
        for _ in range(sweeps):
            sweep(m)
            m.needs_sweep[0] = select(m.convergence[0] > AT_REST, select(m.convergence[1] > 0.5, m.needs_sweep[0], zero), zero)
            if stop_early and every(m.needs_sweep[0] < 0.5):
                break
        for n in range(nodes + 1):
            retract(m.X[n], m.deviation[n], m.X[n])
        for n in range(nodes):
            for a in range(4):
                m.U[n, a] = m.inputs[n, a]

    return solve


solve = solver(linearise, backward, forward)
