"""Stage: one shooting interval, its state after RK4 steps, with exact sparse derivatives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import casadi as ca

from hotlap.dynamics.models import planning_model, point_mass, point_mass_in_air
from hotlap.dynamics.parameter_layout import airframe_layout, planning_parameters

ATTITUDE = slice(6, 10)  # of the full state
SUBSTEPS = 2  # of the quadrotor, in an interval


@dataclass(frozen=True)
class Stage:
    """CasADi functions of one interval; w stands for (state, control, step).

    Attributes:
        nx: number of states.
        nu: number of controls.
        step: (x, u, h, parameters) -> next state.
        jacobian: (x, u, h, parameters) -> next state, non-zeros of its Jacobian in w.
        hessian: (x, u, h, parameters, multipliers) -> non-zeros of the upper triangle of (multipliers . next state)'s Hessian in w.
        jacobian_sparsity, hessian_sparsity: where the non-zeros stand.
    """

    nx: int
    nu: int
    step: Any
    jacobian: Any
    hessian: Any
    jacobian_sparsity: Any
    hessian_sparsity: Any


@cache
def point_mass_stage() -> Stage:
    """A point mass: parameters are gravity and drag."""
    return _derive(point_mass(), 2, substeps=1, finish=lambda state: state)


@cache
def point_mass_in_air_stage(rotors: int = 4) -> Stage:
    """A point mass: parameters are those of `airframe_layout`."""
    return _derive(point_mass_in_air(rotors), sum(airframe_layout(rotors).values()), substeps=1, finish=lambda state: state)


@cache
def quadrotor_stage(rotors: int = 4) -> Stage:
    """The full quadrotor: parameters are those of `planning_model`."""
    return _derive(planning_model(rotors), planning_parameters(rotors), substeps=SUBSTEPS, finish=normalised)


def normalised(state: Any) -> Any:
    """The quaternion brought back to norm 1; without it the optimiser inflates it to gain thrust."""
    return ca.vertcat(state[:6], state[ATTITUDE] / ca.norm_2(state[ATTITUDE]), state[10:])


def _runge_kutta(model: Any, state: Any, control: Any, step: Any, parameters: Any) -> Any:
    """The classical fourth-order step, control held."""
    return runge_kutta(lambda state, control: model(state, control, parameters), state, (control, control, control), step)


def runge_kutta(model: Callable[[Any, Any], Any], state: Any, controls: tuple[Any, Any, Any], step: Any) -> Any:
    """The classical fourth-order step, with the controls at its beginning, in its middle and at its end."""
    k1 = model(state, controls[0])
    k2 = model(state + step / 2 * k1, controls[1])
    k3 = model(state + step / 2 * k2, controls[1])
    k4 = model(state + step * k3, controls[2])
    return state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def _derive(model: Any, parameter_count: int, substeps: int, finish: Callable[[Any], Any]) -> Stage:
    """The stage of a model of (state, control, parameters)."""
    state, control, step, parameters = symbols(model.size1_in(0), model.size1_in(1), parameter_count)
    after = state
    for _ in range(substeps):
        after = _runge_kutta(model, after, control, step / substeps, parameters)
    return stage(state, control, step, parameters, finish(after))


def symbols(nx: int, nu: int, parameter_count: int) -> tuple[Any, Any, Any, Any]:
    """State, control, step and parameters of a stage."""
    return ca.SX.sym("x", nx), ca.SX.sym("u", nu), ca.SX.sym("h"), ca.SX.sym("c", parameter_count)


def stage(state: Any, control: Any, step: Any, parameters: Any, after: Any) -> Stage:
    """The stage of an expression of its symbols: the state after the step."""
    nx, nu = state.size1(), control.size1()
    multipliers = ca.SX.sym("l", nx)
    w = ca.vertcat(state, control, step)
    jacobian = ca.jacobian(after, w)
    hessian = ca.triu(ca.hessian(ca.dot(multipliers, after), w)[0])
    inputs, options = [state, control, step, parameters], {"cse": True}
    return Stage(
        nx=nx,
        nu=nu,
        step=ca.Function("step", inputs, [after], options),
        jacobian=ca.Function("stage_jacobian", inputs, [after, jacobian.nz[:]], options),
        hessian=ca.Function("stage_hessian", [*inputs, multipliers], [hessian.nz[:]], options),
        jacobian_sparsity=jacobian.sparsity(),
        hessian_sparsity=hessian.sparsity(),
    )
