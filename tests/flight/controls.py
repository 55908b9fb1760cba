"""One control step of one flight in float64, on memory that a test fills in."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from hotlap.flight.control_loop import ControlLoop, allocate_control_loop, begin_control_loop
from hotlap.flight.fly import prepare, settings_of
from hotlap.flight.job import Job, Settings
from hotlap.flight.lanes import as_numbers, borrow
from hotlap.flight.mpc import Mpc, allocate_mpc
from hotlap.flight.mpc_step import aim, begin_control, control
from hotlap.flight.numbers import Numbers
from hotlap.flight.segment_switch import FRESH

from . import scenarios, stages
from .kept import kept

LOW, HIGH = np.array([0.1, -10.0, -10.0, -3.0]), np.array([20.0, 10.0, 10.0, 3.0])
SPACING, GRAVITY = 0.1, 9.81


@kept
def control_step(s: Settings, mpc: Mpc, loop: ControlLoop) -> None:
    """From the state seen to the command; raw memory of one lane."""
    control(s, as_numbers(borrow(mpc), 0), as_numbers(borrow(loop), 0))


def settings(**changes: Any) -> Settings:
    """Of the small race: no prediction."""
    return settings_of(scenarios.make_scenario())._replace(**changes)


def allocate(nodes: int, commands: int = 3) -> tuple[Mpc, ControlLoop]:
    """Memory with the weights, bounds and spacing that stay."""
    mpc, loop = allocate_mpc(nodes, 1, np.float64), allocate_control_loop(commands, 1, np.float64)
    mpc.weights[..., 0], mpc.input_weights[:] = scenarios.TUNED[:4], 1.0
    mpc.low[:, 0], mpc.high[:, 0] = LOW, HIGH
    mpc.spacing[:], mpc.constants[:] = SPACING, GRAVITY
    return mpc, loop


@kept
def aim_step(job: Job, s: Settings, mpc: Mpc, loop: ControlLoop, before: int, time: float, elapsed: float) -> int:
    """What the lane of flight 0 is to track."""
    return aim(job, s, mpc, loop, 0, 0, before, time, elapsed)


@kept
def begin(job: Job, s: Settings, mpc: Mpc, loop: ControlLoop) -> None:
    """Set the lane up."""
    begin_control(job, s, mpc, 0)
    begin_control_loop(job, s, loop, 0)


@cache
def node() -> Any:
    """The controller's model of a node."""
    from hotlap.dynamics import models  # noqa: PLC0415

    return models.node_map()


def roll_out(x: np.ndarray, inputs: np.ndarray, h: float = SPACING) -> np.ndarray:
    """States of the controller's model, shape (N + 1, 10)."""
    states = [x]
    for u in inputs:
        states.append(np.array(node()(states[-1], u, h, GRAVITY)).ravel())
    return np.array(states)


def draw_problem(seed: int, nodes: int, *, away: float) -> tuple[Mpc, ControlLoop]:
    """A flyable reference whose inputs often lie beyond their bounds, the plan on it, and a state that is so far away."""
    rng = np.random.default_rng(seed)
    mpc, loop = allocate(nodes)
    inputs = np.array([12.0, 0, 0, 0]) + rng.normal(size=(nodes, 4)) * [7, 7, 7, 3]
    start = stages.draw_state(rng)
    possible = np.clip(inputs, LOW, HIGH)
    states = roll_out(start, possible)
    mpc.reference[:, :, 0] = np.hstack([states, np.vstack([inputs, inputs[-1:]])])
    mpc.U[..., 0], mpc.X[..., 0] = possible, states
    scale = away * np.array([1, 1, 1, 0.3, 0.3, 0.3, 2, 2, 2])
    loop.seen[:, 0] = stages.moved(start, scale * rng.normal(size=9))
    return mpc, loop


def best_plan(mpc: Mpc, loop: ControlLoop) -> tuple[np.ndarray, np.ndarray]:
    """States and inputs that solve the quadratic problem around a plan, from the state seen: in dense matrices."""
    linearised = stages.linearised_node_map()
    h, low, high = mpc.spacing[0, 0], mpc.low[:, 0], mpc.high[:, 0]
    states, inputs, reference = mpc.X[..., 0].copy(), mpc.U[..., 0], mpc.reference[..., 0]
    states[0] = loop.seen[:, 0]
    As, Bs, defects, bounded = [], [], [], []
    for x, u, following in zip(states, inputs, states[1:], strict=False):
        parts = linearised(x, u, following, np.zeros(9), h, low, high, GRAVITY)
        near, defect, jacobian = (np.array(part).ravel() for part in parts)
        A, B = stages.unpack(jacobian, h)
        for collected, part in zip((As, Bs, defects, bounded), (A, B, defect, near), strict=True):
            collected.append(part)
    errors = np.array([stages.difference(x, r[:10]) for x, r in zip(states, reference, strict=True)])
    Q, R, near = stages.diagonal(mpc.weights[0, :, 0]), mpc.input_weights[:, 0], np.array(bounded)
    steps, deviations = stages.solve_whole(As, Bs, np.array(defects), errors, Q, R, reference[:-1, 10:] - near, low - near, high - near)
    return np.array([stages.moved(x, d) for x, d in zip(states, deviations, strict=True)]), near + steps


def three_steps(segment: int) -> list[float]:
    """Commands of three control steps that end in a segment, beside the reference and with a dead time."""
    scenario = scenarios.make_scenario(model={"delay": 0.025}, controller={"nodes": 4})
    values = np.array([[scenarios.TUNED, (100.0, 200.0, 30.0, 4.0, 4.0)]])
    job, _ = prepare(scenario, values, np.zeros(1, dtype=np.int64), Numbers.FLOAT64, None, ())
    s = settings_of(scenario)
    mpc, loop = allocate_mpc(s.nodes, 1, np.float64), allocate_control_loop(4, 1, np.float64)
    begin(job, s, mpc, loop)
    before, commands = FRESH, []
    for k in range(3):
        time = scenarios.BORDER - 0.03 + (k + segment) * s.period - s.lead
        loop.seen[:, 0] = scenarios.make_reference().table[round(time * 100), :10] + 0.05
        before = aim_step(job, s, mpc, loop, before, time, s.period)
        control_step(s, mpc, loop)
        commands += loop.history[0, :, 0].tolist()
    assert before == segment
    return commands
