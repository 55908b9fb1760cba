"""The controller's quadratic problems as they arise in flight, and their solution by DAQP, an exact solver that shares nothing with it.

Arnström, Bemporad, Axehill, "A dual active-set solver for embedded quadratic programming using recursive LDL' updates", IEEE
Transactions on Automatic Control 67(8), 2022.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cache
from typing import Any

import daqp
import numpy as np

from hotlap.flight.control_loop import ControlLoop, allocate_control_loop, begin_control_loop
from hotlap.flight.fly import fly_batch, prepare, settings_of
from hotlap.flight.job import Job, Settings
from hotlap.flight.kernel import Lane, actuate, start_next_flight
from hotlap.flight.mpc import Mpc, allocate_mpc, solve
from hotlap.flight.mpc_step import aim, begin_control, begin_plan
from hotlap.flight.numbers import Numbers, best_numbers
from hotlap.flight.plant import VehicleState, allocate_vehicle_state, fly_period
from hotlap.flight.segment_switch import FRESH
from hotlap.reference.scenario import Scenario

from . import stages
from .kept import kept

NO_FLOOR = -math.inf
INFEASIBLY_FAR = 1e-9  # of an input from its bound: nearer is at the bound


@kept
def begin_one(job: Job, s: Settings, mpc: Mpc, loop: ControlLoop) -> None:
    begin_control(job, s, mpc, 0)
    begin_control_loop(job, s, loop, 0)


@kept
def aim_one(job: Job, s: Settings, mpc: Mpc, loop: ControlLoop, before: int, time: float) -> int:
    return aim(job, s, mpc, loop, 0, 0, before, time, s.period)


@kept
def begin_plan_one(s: Settings, m: Mpc, p: ControlLoop) -> None:
    begin_plan(s, m, p)


@kept
def solve_one(m: Mpc, sweeps: int) -> None:
    solve(m, sweeps, False)


def numbers(memory):
    """Raw memory of one lane as numbers."""
    return type(memory)(*(array[..., 0] for array in memory))


def copied(memory):
    """The same, not shared."""
    return type(memory)(*(array.copy() for array in memory))


def problems(scenario: Scenario, parameters: np.ndarray, seed: int, every: int) -> Iterator[Mpc]:
    """Memory as it stands before the solver, at every so many control steps of a flight; parameters have shape (S, K)."""
    job, _ = prepare(scenario, parameters[None], np.array([seed]), Numbers.FLOAT64, None, ())
    log = fly_batch(scenario, parameters[None], np.array([seed]), numbers=best_numbers(), threads=1, log=[0])[0].logs[0]
    s = settings_of(scenario)
    mpc, loop = allocate_mpc(s.nodes, 1, np.float64), allocate_control_loop(s.predicted_periods + 2, 1, np.float64)
    begin_one(job, s, mpc, loop)
    segment = FRESH
    for tick, (time, state) in enumerate(zip(log.times[:-1], log.states, strict=False)):
        loop.seen[:, 0] = state[:10]
        segment = aim_one(job, s, mpc, loop, segment, time)
        begin_plan_one(s, numbers(mpc), numbers(loop))
        if tick % every == every - 1:
            yield copied(mpc)
        solve_one(numbers(mpc), s.sweeps)
        loop.history[1:], loop.history[0] = loop.history[:-1].copy(), mpc.U[0]


def swept(mpc: Mpc, sweeps: int) -> np.ndarray:
    """Inputs of the plan after so many sweeps, shape (N, 4)."""
    memory = copied(mpc)
    solve_one(numbers(memory), sweeps)
    return memory.U[..., 0]


def exact(mpc: Mpc) -> np.ndarray:
    """Inputs of the quadratic problem's solution, shape (N, 4): states eliminated, then DAQP."""
    return solution(mpc)[0]


def solution(mpc: Mpc) -> tuple[np.ndarray, list[np.ndarray]]:
    """Inputs of the quadratic problem's solution, (N, 4), and the deviations of its states from the planned ones, N + 1 of (9,)."""
    low, high = mpc.low[:, 0], mpc.high[:, 0]
    states, inputs, reference = mpc.X[..., 0], mpc.U[..., 0], mpc.reference[..., 0]
    nodes = len(inputs)
    near, defects, As, Bs = linearised(mpc)
    Q, R = stages.diagonal(mpc.weights[0, :, 0]), mpc.input_weights[:, 0]
    free, response = np.zeros(9), np.zeros((9, 4 * nodes))  # deviation = free + response (inputs - near)
    H, f = np.diag(np.tile(R, nodes)), (R * (near - reference[:nodes, 10:])).ravel()
    paths = []
    for n in range(nodes + 1):
        paths.append((free, response))
        error = free - stages.difference(states[n], reference[n, :10])
        H += response.T * Q @ response
        f += response.T @ (Q * error)
        if n < nodes:
            free, response = As[n] @ free + defects[n], As[n] @ response
            response[:, 4 * n : 4 * n + 4] += Bs[n]
    upper, lower = np.tile(high, nodes) - near.ravel(), np.tile(low, nodes) - near.ravel()
    step, _, flag, _ = daqp.solve(
        H, f, np.zeros((0, 4 * nodes)), upper, lower, np.zeros(4 * nodes, dtype=np.int32), primal_tol=1e-10, dual_tol=1e-12
    )
    assert flag == 1, "a strictly convex problem within bounds has a solution"
    return near + step.reshape(nodes, 4), [free + response @ step for free, response in paths]


@cache
def linearised_nodes(nodes: int) -> Any:
    """The linearised node map for all nodes in one call: calls take longer than what they compute."""
    return stages.linearised_node_map().map(nodes)


def linearised(mpc: Mpc) -> tuple[np.ndarray, np.ndarray, list[np.ndarray], list[np.ndarray]]:
    """Inputs within their bounds, defects, A and B of all nodes around the plan."""
    states, inputs, h = mpc.X[..., 0], mpc.U[..., 0], mpc.spacing[0, 0]
    alike = (np.tile(column, (len(inputs), 1)).T for column in (mpc.spacing[:, 0], mpc.low[:, 0], mpc.high[:, 0], mpc.constants[:1, 0]))
    parts = linearised_nodes(len(inputs))(states[:-1].T, inputs.T, states[1:].T, np.zeros((9, len(inputs))), *alike)
    near, defects, jacobians = (np.array(part).T for part in parts)
    As, Bs = zip(*(stages.unpack(jacobian, h) for jacobian in jacobians), strict=True)
    return near, defects, list(As), list(Bs)


def is_bounded(mpc: Mpc, inputs: np.ndarray) -> bool:
    """Whether some input is at a bound."""
    low, high = mpc.low[:, 0], mpc.high[:, 0]
    return bool(((inputs <= low + INFEASIBLY_FAR) | (inputs >= high - INFEASIBLY_FAR)).any())


@kept
def take_off(job: Job, s: Settings, loop: ControlLoop, vehicle_state: VehicleState, lane: Lane) -> None:
    start_next_flight(job, s, NO_FLOOR, loop, vehicle_state, lane, 0)


@kept
def fly_on(job: Job, s: Settings, loop: ControlLoop, vehicle_state: VehicleState, numbers: VehicleState, lane: Lane) -> None:
    actuate(job, s, loop, vehicle_state, lane, 0)
    fly_period(numbers, s.steps)
    lane.tick[0] += 1


def closed_loop(scenario: Scenario, parameters: np.ndarray, seed: int, steps: int, sweeps: int | None) -> np.ndarray:
    """Positions of a flight, shape (steps, 3), whose quadratic problems are solved by so many sweeps, or exactly where that is None."""
    job, _ = prepare(scenario, parameters[None], np.array([seed]), Numbers.FLOAT64, None, ())
    s = settings_of(scenario)
    mpc, vehicle_state = allocate_mpc(s.nodes, 1, np.float64), allocate_vehicle_state(1, np.float64)
    loop = allocate_control_loop(max(int(job.delay_periods.max()), s.predicted_periods) + 2, 1, np.float64)
    lane = Lane(*np.zeros((3, 1), dtype=np.int64), np.zeros((7, 1)), np.zeros((2, 1)))
    take_off(job, s, loop, vehicle_state, lane)
    begin_one(job, s, mpc, loop)
    segment, flown = FRESH, []
    for tick in range(steps):
        loop.seen[:, 0] = vehicle_state.state[:10, 0]
        segment = aim_one(job, s, mpc, loop, segment, tick * s.period)
        begin_plan_one(s, numbers(mpc), numbers(loop))
        if sweeps is None:
            mpc.U[..., 0], deviations = solution(mpc)
            mpc.X[..., 0] = [stages.moved(x, change) for x, change in zip(mpc.X[..., 0], deviations, strict=True)]
        else:
            solve_one(numbers(mpc), sweeps)
        loop.history[1:], loop.history[0] = loop.history[:-1].copy(), mpc.U[0]
        fly_on(job, s, loop, vehicle_state, numbers(vehicle_state), lane)
        flown.append(vehicle_state.state[:3, 0].copy())
    return np.array(flown)
