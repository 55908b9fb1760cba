"""Sampling: a plan at its nodes as a reference every 10 ms."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hotlap.dynamics.models import airframe
from hotlap.planning.minimum_time import RATES, model_parameters, rotor_thrusts, stage_of
from hotlap.planning.problem import Floats, Problem, Trajectory
from hotlap.planning.stage import ATTITUDE
from hotlap.race.airframe import airframe_parameters
from hotlap.race.gate_plane import GatePlane
from hotlap.reference.attitude import continuous
from hotlap.reference.reference import Reference, row_times

CROSSING_SAMPLES = 200  # of the way through a gate


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
        gate_times=gate_times(problem, plan),
        duration=plan.duration,
        cpu_time=cpu_time,
    )


def gate_times(problem: Problem, plan: Trajectory) -> Floats:
    """When a plan passes the gates that count, shape (gates,) [s]: where it crosses their planes, or at the end of their phase."""
    ends, found = np.cumsum(plan.durations), {}
    for phase, target in enumerate(problem.targets):
        if not target.counts:
            continue
        through = target.plane if target.inside else None
        found[target.index] = ends[phase] if through is None else _crossing(problem, plan, phase, through)
    return np.array(list(found.values()))


def _crossing(problem: Problem, plan: Trajectory, phase: int, plane: GatePlane) -> float:
    """[s] when a plan crosses the plane of a gate, in the phase from the plane in front to that behind it."""
    end = float(np.cumsum(plan.durations)[phase])
    times = np.linspace(end - plan.durations[phase], end, CROSSING_SAMPLES)
    along = plane.to_gate(states_at(problem, plan, times)[0][:, :3])[:, 0]
    after = int(np.argmax(along > 0))
    share = along[after - 1] / (along[after - 1] - along[after])
    return float(times[after - 1] + share * (times[after] - times[after - 1]))


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
    model = airframe(problem.quadrotor.rotor_count)
    return np.asarray(model(state, reference.rotor_thrusts[last], airframe_parameters(problem.quadrotor))).ravel()[3:6]
