"""A plan with full dynamics begins at rest, asks of motors and rate loop what they can do, and meets the air as the vehicle does."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from hotlap.files.descriptions import load_quadrotor
from hotlap.planning.full_stage import full_parameters, full_stage, full_stage_of
from hotlap.planning.planner import find_plan
from hotlap.planning.problem import Problem
from hotlap.planning.sampling import last_acceleration, states_at
from hotlap.race.flight_performance import top_speed
from hotlap.race.race import PlanDynamics, PlanningSettings, Race
from hotlap.race.track import Gate, Track
from hotlap.reference import run_out

from . import small

each = pytest.mark.parametrize("name", list(small.FULL))


def motion(problem: Problem, state: np.ndarray, command: np.ndarray) -> np.ndarray:
    """(p v q w f)' of the vehicle, written without the library's equations; motors lag by the longer of their times."""
    quadrotor = problem.quadrotor
    v, q, w, f = state[3:6], state[6:10], state[10:13], state[13:17]
    turned = Rotation.from_quat(np.roll(q, -1))
    air = turned.inv().apply(v)
    force = -np.array(quadrotor.body_drag) * air * np.abs(air) - quadrotor.mass * np.array(quadrotor.drag) * air
    force[:2] -= quadrotor.rotor_drag * np.sqrt(np.maximum(f, 0.0)).sum() * air[:2]
    force[2] += f.sum()
    acceleration = turned.apply(force) / quadrotor.mass - np.array([0, 0, quadrotor.gravity])
    inertia = quadrotor.inertia_vector
    turn = (quadrotor.torque_matrix @ f - np.cross(w, inertia * w)) / inertia
    quaternion = 0.5 * np.concatenate([[-q[1:] @ w], q[0] * w + np.cross(q[1:], w)])
    return np.concatenate([v, acceleration, quaternion, turn, (command - f) / max(*quadrotor.motor_time, 1e-4)])


@pytest.mark.check
@each
def test_it_starts_at_rest_with_rotors_that_hover(name):
    _, problem, trajectory, reference = small.planned(name)
    assert_allclose(reference.rates[0], 0.0, atol=1e-6)
    assert_allclose(reference.velocity[0], 0.0, atol=1e-6)
    assert_allclose(reference.thrust[0], problem.quadrotor.gravity, rtol=1e-6)
    assert_allclose(trajectory.states[0, 13:17], problem.quadrotor.mass * problem.quadrotor.gravity / 4, rtol=1e-6)


def test_thrust_changes_no_faster_than_the_motors():
    _, problem, _, reference = small.planned("full")
    low, high = problem.quadrotor.rotor_thrust
    kept, now, later = np.exp(-0.01 / 0.05), reference.rotor_thrusts[:-1], reference.rotor_thrusts[1:]
    assert np.all(later <= high + kept * (now - high) + 1e-6)
    assert np.all(later >= low + kept * (now - low) - 1e-6)
    assert np.ptp(reference.rotor_thrusts) > 0.3 * (high - low)


def test_motors_without_lag_give_what_they_are_asked_for():
    _, _, trajectory, _ = small.planned("at once")
    assert_allclose(trajectory.states[1:, 13:17], trajectory.controls, atol=1e-4)


@each
def test_the_rate_loop_is_asked_for_no_more_than_its_share(name):
    race, problem, trajectory, _ = small.planned(name)
    quadrotor, rates = problem.quadrotor, trajectory.states[:-1, 10:13]
    torque = trajectory.controls @ quadrotor.torque_matrix.T - np.cross(rates, quadrotor.inertia_vector * rates)
    asked = rates + (1 + quadrotor.torque_damping) * torque / (quadrotor.inertia_vector * np.array(quadrotor.rate_gain))
    bounds = race.planning.rate_share * np.array(race.controller.rates)
    assert np.all(np.abs(asked) <= bounds * (1 + 1e-3))
    assert np.abs(asked).max() > 0.9 * bounds[0]


@each
def test_the_planned_commands_fly_the_planned_path(name):
    _, problem, trajectory, _ = small.planned(name)
    state, times = trajectory.states[0, :17], trajectory.times
    for command, begin, end in zip(trajectory.controls, times[:-1], times[1:], strict=True):

        def derivative(_, state, command=command):
            return motion(problem, state, command)

        state = solve_ivp(derivative, (begin, end), state, method="LSODA", rtol=1e-8, atol=1e-9).y[:, -1]
    assert_allclose(state[:3], trajectory.states[-1, :3], atol=0.02)
    assert_allclose(state[3:6], trajectory.states[-1, 3:6], atol=0.05)


def test_position_and_velocity_go_on_behind_the_end():
    _, problem, trajectory, planned = small.planned("full")
    reference = run_out.extend(planned, problem.quadrotor.gravity, problem.drag, last_acceleration(problem, planned))
    rows = planned.planned_rows
    last = states_at(problem, trajectory, planned.times[-1:])[0][0, :17]
    acceleration = motion(problem, last, np.zeros(4))[3:6]
    assert len(reference.position) > rows
    assert_allclose(np.diff(reference.velocity[rows - 1 : rows + 1], axis=0)[0], 0.01 * acceleration, atol=5e-3)


@pytest.mark.parametrize("lag", [0.0, 0.004, 0.03, 0.5])
def test_a_step_agrees_with_a_tight_integrator_however_short_the_lag(lag):
    problem = Problem.of(small.FULL["full"])
    quadrotor = problem.quadrotor.model_copy(update={"motor_time": (lag, lag)})
    problem, rng = dataclasses.replace(problem, quadrotor=quadrotor), np.random.default_rng(7)
    state = np.concatenate([np.zeros(3), 5 * rng.normal(size=3), [1, 0, 0, 0], rng.normal(size=3), rng.uniform(2.0, 2.2, 4), np.zeros(3)])
    command = rng.uniform(2.3, 2.5, 4)
    after = np.asarray(full_stage().step(state, command, 0.05, full_parameters(problem))).ravel()
    exact = solve_ivp(lambda _, x: motion(problem, x, command), (0, 0.05), state[:17], method="LSODA", rtol=1e-10, atol=1e-12).y[:, -1]
    assert_allclose(after[:17], exact, atol=2e-4)


def test_drags_that_a_quadrotor_has_not_change_no_step():
    problem = Problem.of(bare("split-s-racer", (0.0, 0.0, 1.0), (5.0, 0.0, 1.0)))
    assert not any((*problem.quadrotor.drag, problem.quadrotor.rotor_drag, *problem.quadrotor.body_drag))
    lean, whole, parameters = full_stage_of(problem), full_stage(), full_parameters(problem)
    state, command = small.planned("full")[2].states[7], small.planned("full")[2].controls[7]
    assert lean.hessian_sparsity.nnz() < whole.hessian_sparsity.nnz()
    assert_allclose(np.asarray(lean.step(state, command, 0.05, parameters)), np.asarray(whole.step(state, command, 0.05, parameters)))


def bare(vehicle: str, start: tuple[float, float, float], *gates: tuple[float, float, float], **planning) -> Race:
    """A race with a built-in vehicle and nothing else set."""
    track = Track(name="bare", start=start, gates=tuple(Gate(position=gate) for gate in gates))
    return Race(name="bare", track=track, vehicle=load_quadrotor(vehicle), planning=PlanningSettings(**planning))


@pytest.mark.check
def test_quadratic_drag_keeps_the_plan_below_the_top_speed():
    race = small.make_race([(80.0, 0.0, 0.5)], planning=small.WITH_ALL, quadrotor={**small.OWN, "body_drag": (0.05, 0.05, 0.05)})
    speeds = np.linalg.norm(find_plan(Problem.of(race)).states[:, 3:6], axis=1)
    assert 0.7 * top_speed(race.planning_model) < speeds.max() < top_speed(race.planning_model)


def test_v_max_stands_in_place_of_the_linear_drag_alone():
    race = bare("hummingbird", (0.0, 0.0, 2.0), (60.0, 0.0, 2.0), v_max=15.0)
    planned = Problem.of(race).quadrotor
    assert planned.drag == (race.planning_drag,) * 3
    assert planned.rotor_drag == race.vehicle.rotor_drag > 0


@pytest.mark.parametrize("dynamics", [PlanDynamics.IDEAL, pytest.param(PlanDynamics.FULL, marks=pytest.mark.check)])
def test_a_drop_straight_down_takes_as_long_as_one_a_centimetre_aside(dynamics):
    straight, aside = (
        find_plan(Problem.of(bare("split-s-racer", (0.0, 0.0, 50.0), (x, 0.0, 1.0), dynamics=dynamics))).duration for x in (0.0, 0.01)
    )
    assert straight == pytest.approx(aside, rel=0.1)
    assert straight < 0.8 * np.sqrt(2 * 49 / 9.81)  # faster than upright: it turns over and pulls
