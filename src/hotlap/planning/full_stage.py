"""Full stage: one shooting interval of a vehicle whose motors lag, whose rate loop is bounded, and on which all of its drags act.

States: p v q w (13), rotor thrusts f (n) and the rates y (3) that the rate loop has been asked for. Controls: commands u of the rotors [N].

    f' = (u - f) / tau                                          motors: a first-order lag, solved exactly
    (p v q w)' = airframe(p v q w, f)
    y_{k+1} = w_k + (1 + d) / k J^-1 (M u_k - w_k x J w_k)      rate loop: what makes it command u_k, as in the plant

y is no state of the vehicle: it stands among the states so that bounds of the rate command are bounds of variables.
"""

from __future__ import annotations

import dataclasses
from functools import cache
from typing import Any

import casadi as ca
import numpy as np

from hotlap.dynamics.models import airframe, angular_acceleration, power_series
from hotlap.dynamics.parameter_layout import airframe_layout
from hotlap.planning.problem import Floats, Problem, Trajectory
from hotlap.planning.stage import SUBSTEPS, Stage, normalised, runge_kutta, stage, symbols
from hotlap.race.airframe import airframe_parameters

BODY, ROTORS, COMMANDED = slice(0, 13), slice(13, -3), slice(-3, None)  # of the state
DRAGS = frozenset({"drag", "rotor_drag", "body_drag"})
SERIES_ORDER = 14  # of a function of z below 1: to rounding
SHORTEST_LAG = 1e-4  # s, of motors that answer at once


@cache
def full_stage(drags: frozenset[str] = DRAGS, rotors: int = 4) -> Stage:
    """The vehicle with motors and rate loop: parameters are those of `full_parameters`.

    Args:
        drags: parts of `AIRFRAME` that are not 0; without the others the derivatives are up to half as long.
        rotors: how many.
    """
    layout = airframe_layout(rotors)
    count = sum(layout.values())
    state, control, step, parameters = symbols(16 + rotors, rotors, count + 4)
    used = [name in drags or name not in DRAGS for name, size in layout.items() for _ in range(size)]
    vehicle, lag, gain = ca.SX(used) * parameters[:count], parameters[count], parameters[count + 1 :]
    model, h = airframe(rotors), step / SUBSTEPS
    forcing, kept = _moments(h / lag)
    body, thrusts = state[BODY], state[13 : 13 + rotors]
    for _ in range(SUBSTEPS):
        held = tuple(control + share * (thrusts - control) for share in forcing)
        body = runge_kutta(lambda state, thrusts: model(state, thrusts, vehicle), body, held, h)
        thrusts = control + kept * (thrusts - control)
    rates, inertia, torques = state[10:13], vehicle[2:5], ca.reshape(vehicle[5 : 5 + 3 * rotors], rotors, 3).T
    commanded = rates + angular_acceleration(rates, torques @ control, inertia) / gain
    return stage(state, control, step, parameters, ca.vertcat(normalised(body), thrusts, commanded))


def _moments(z: Any) -> tuple[tuple[Any, Any, Any], Any]:
    """Values at the beginning, the middle and the end of a step that stand for exp(-z s), s from 0 to 1, in a Runge-Kutta step.

    They have its integrals, up to the third repeated one, exactly, however short the lag is beside the step. And exp(-z).
    """
    large = ca.fmax(z, 1)
    closed = (1 / 2 - (1 - (1 - ca.exp(-large)) / large) / large) / large
    third = ca.if_else(z < 1, power_series(z, 1 / 6, lambda k: k + 4, SERIES_ORDER), closed)  # integral of exp(-z s) (1 - s)^2 / 2
    second = 1 / 2 - z * third
    first = 1 - z * second
    return (24 * third - 6 * second, 6 * second - 12 * third, 6 * first - 18 * second + 24 * third), 1 - z * first


def full_parameters(problem: Problem) -> Floats:
    """Parameters of `full_stage`: `airframe_layout`, the lag of the motors, and the gains of the rate loop, damping included."""
    quadrotor = problem.quadrotor
    damping = quadrotor.torque_damping if quadrotor.rate_loop is None else 0.0
    lag, gains = max(*quadrotor.motor_time, SHORTEST_LAG), quadrotor.hover_rate_gain / (1 + damping)
    return np.concatenate([airframe_parameters(quadrotor), [lag], gains])


def full_stage_of(problem: Problem) -> Stage:
    """The stage with what drags the quadrotor has."""
    return full_stage(frozenset(name for name in DRAGS if np.any(getattr(problem.quadrotor, name))), problem.quadrotor.rotor_count)


def hover_thrust(problem: Problem) -> float:
    """[N] of each rotor at the start, within the rotors' range."""
    quadrotor = problem.quadrotor
    return float(np.clip(quadrotor.mass * quadrotor.gravity / quadrotor.rotor_count, *quadrotor.rotor_thrust))


def with_rotors(problem: Problem, guess: Trajectory) -> Trajectory:
    """A guess of the body's states with rotor thrusts that equal the commands, and commanded rates that equal the rates."""
    rotors = np.vstack([np.full((1, problem.quadrotor.rotor_count), hover_thrust(problem)), guess.controls])
    largest = problem.command_rates
    commanded = np.vstack([np.zeros(3), np.clip(guess.states[:-1, 10:13], -largest, largest)])
    return dataclasses.replace(guess, states=np.hstack([guess.states[:, BODY], rotors, commanded]))


def limit_start_and_commands(problem: Problem, low: Floats, high: Floats) -> None:
    """Enter what the full model adds to bounds of the states, shape (N + 1, 16 + n): the start at rest with its rotors, commanded rates."""
    low[0, 10:13] = high[0, 10:13] = 0.0
    low[0, ROTORS] = high[0, ROTORS] = hover_thrust(problem)
    low[1:, COMMANDED], high[1:, COMMANDED] = -problem.command_rates, problem.command_rates
    low[0, COMMANDED] = high[0, COMMANDED] = 0.0
