"""Sampling: a plan at its nodes as a reference every 10 ms."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hotlap.dynamics.models import airframe
from hotlap.planning.attitude import continuous
from hotlap.planning.full_stage import airframe_parameters
from hotlap.planning.minimum_time import RATES, model_parameters, rotor_thrusts, stage_of
from hotlap.planning.problem import Floats, Problem, Trajectory
from hotlap.planning.stage import ATTITUDE
from hotlap.reference.reference import Reference, row_times


def sample(problem: Problem, plan: Trajectory, cpu_time: float) -> Reference:
    """The reference of a plan, up to its duration, without run-out.

    Args:
        problem: what was planned.
        plan: of the full quadrotor.
        cpu_time: [s] that it took.
    """
    states, intervals = states_at(problem, plan, row_times(plan.duration))
    thrusts = rotor_thrusts(problem, states, plan.controls[intervals])
    thrusts = np.clip(thrusts, *problem.quadrotor.rotor_thrust)  # IPOPT relaxes bounds by 1e-8
    return Reference(
        position=states[:, :3],
        attitude=continuous(states[:, ATTITUDE]),
        velocity=states[:, 3:6],
        rates=states[:, RATES],
        thrust=thrusts.sum(axis=1) / problem.quadrotor.mass,
        rotor_thrusts=thrusts,
        gate_times=np.cumsum(plan.durations)[: problem.gates],
        duration=plan.duration,
        cpu_time=cpu_time,
    )


def states_at(problem: Problem, plan: Trajectory, times: Floats) -> tuple[Floats, NDArray[np.intp]]:
    """States at given times, shape (times, nx), integrated from the node before; and the interval of each."""
    intervals = np.clip(np.searchsorted(plan.times, times, side="right") - 1, 0, len(plan.controls) - 1)
    step = stage_of(problem).step.map(len(times))
    model = np.tile(model_parameters(problem)[:, None], len(times))
    states = step(plan.states[intervals].T, plan.controls[intervals].T, (times - plan.times[intervals])[None], model)
    return np.asarray(states).T, intervals


def last_acceleration(problem: Problem, reference: Reference) -> Floats | None:
    """Acceleration at the last planned row of a plan with all drags, shape (3,) [m/s^2] (world); None with linear drag alone."""
    if not problem.full:
        return None
    last = reference.planned_rows - 1
    rows = (reference.position, reference.velocity, reference.attitude, reference.rates)
    state = np.concatenate([values[last] for values in rows])
    return np.asarray(airframe()(state, reference.rotor_thrusts[last], airframe_parameters(problem.quadrotor))).ravel()[3:6]
