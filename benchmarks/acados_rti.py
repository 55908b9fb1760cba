"""acados with a real-time iteration, given the problem that hotlap's controller solves; generated, compiled by gcc, one core.

From PyPI: `pip install comma-deps-acados` (its own CasADi is for another Python: ours is used, as it is imported first).
"""

from __future__ import annotations

import ctypes
import os
import tempfile
import time
from contextlib import chdir
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from hotlap.core.records import Log
from hotlap.dynamics import models
from hotlap.reference.scenario import Scenario

Floats = NDArray[np.float64]

TUNED = {"ext_fun_compile_flags": "-O3 -march=native", "hpipm_mode": "SPEED_ABS"}


def build(scenario: Scenario, *, tuned: bool) -> Any:
    """A solver of Eq. 3 of the paper with the default weights.

    Args:
        scenario: what is flown.
        tuned: hotlap's own discrete step, compiled for this processor, and HPIPM's quickest mode, in place of what acados does by default
            (Runge-Kutta of fourth order).
    """
    import acados  # noqa: PLC0415  optional

    os.environ |= {"ACADOS_SOURCE_DIR": acados.DIR, "TERA_PATH": acados.TERA_PATH, "ACADOS_PYTHON_INTERFACE_PATH": acados.TEMPLATE_DIR}
    for name in ("qpOASES_e", "blasfeo", "hpipm"):  # so that its own library finds them
        for library in Path(acados.LIB_DIR).glob(f"lib{name}.*"):
            ctypes.CDLL(str(library), ctypes.RTLD_GLOBAL)
    from acados.acados_template import AcadosModel, AcadosOcp, AcadosOcpSolver  # noqa: PLC0415

    settings, weights = scenario.race.controller, scenario.space.default
    nodes, gravity = settings.nodes, scenario.race.control_model.gravity
    h = float(weights[4] * settings.horizon_unit / nodes)
    state, command = ca.SX.sym("x", 10), ca.SX.sym("u", 4)
    model = AcadosModel()
    model.name, model.x, model.u = f"hotlap_{'tuned' if tuned else 'plain'}", state, command
    if tuned:
        model.disc_dyn_expr = models.node_map()(state, command, h, gravity)
    else:
        q, turn = state[3:7], command[1:]
        spin = ca.vertcat(-ca.dot(q[1:], turn), q[0] * turn + ca.cross(q[1:], turn)) / 2
        w, x, y, z = ca.vertsplit(q)
        up = ca.vertcat(2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y))
        model.f_expl_expr = ca.vertcat(state[7:], spin, command[0] * up - ca.DM([0, 0, gravity]))
        model.xdot = ca.SX.sym("xdot", 10)
        model.f_impl_expr = model.xdot - model.f_expl_expr
    ocp = AcadosOcp()
    ocp.model = model
    ocp.dims.N, ocp.solver_options.tf = nodes, nodes * h
    Q = np.array([weights[0], weights[0], weights[1], *[weights[2]] * 4, *[weights[3]] * 3])
    R = np.array([settings.input_weights[0], settings.input_weights[1], settings.input_weights[1], settings.input_weights[2]])
    cost = ocp.cost
    cost.cost_type, cost.cost_type_e = "LINEAR_LS", "LINEAR_LS"
    cost.W, cost.W_e = np.diag(np.concatenate([Q, R])) / h, np.diag(Q)  # acados integrates over a step, the paper sums
    cost.Vx, cost.Vu, cost.Vx_e = np.eye(14, 10), np.eye(14, 4, -10), np.eye(10)
    cost.yref, cost.yref_e = np.zeros(14), np.zeros(10)
    limits = ocp.constraints
    limits.x0, limits.idxbu = np.zeros(10), np.arange(4)
    limits.lbu, limits.ubu = (
        np.array([thrust, *(sign * np.array(settings.rates))]) for sign, thrust in zip((-1, 1), settings.thrust, strict=True)
    )
    options = ocp.solver_options
    options.nlp_solver_type, options.qp_solver, options.hessian_approx = "SQP_RTI", "PARTIAL_CONDENSING_HPIPM", "GAUSS_NEWTON"
    options.integrator_type = "DISCRETE" if tuned else "ERK"
    for name, value in TUNED.items() if tuned else ():
        setattr(options, name, value)
    folder = Path(tempfile.mkdtemp())
    ocp.code_export_directory = str(folder / "code")
    with chdir(folder):
        return AcadosOcpSolver(ocp, json_file=str(folder / "ocp.json"), verbose=False)


def solve_steps(solver: Any, scenario: Scenario, log: Log, count: int) -> tuple[Floats, Floats, Floats]:
    """Of each control step: the processor's time to solve it [us], and with all that is set before [us]; the difference of thrust [m/s^2].

    Each solution is moved on by a period before the next step, as hotlap's is.
    """
    settings = scenario.race.controller
    nodes = settings.nodes
    h = scenario.space.default[4] * settings.horizon_unit / nodes
    table, times = scenario.reference.table, scenario.reference.times
    inside, outside, apart = [], [], []
    plan: Floats | None = None
    for now, state, command in zip(log.times[:count], log.states[:count], log.commands[:count], strict=True):
        rows = np.transpose([np.interp(now + h * np.arange(nodes + 1), times, column) for column in table.T])
        if plan is None:
            plan = rows[:, :14].copy()
        began = time.process_time()
        solver.set(0, "lbx", state[:10])
        solver.set(0, "ubx", state[:10])
        for n in range(nodes):
            solver.set(n, "yref", rows[n, :14])
            solver.set(n, "x", plan[n, :10])
            solver.set(n, "u", plan[n, 10:])
        solver.set(nodes, "yref", rows[nodes, :10])
        solver.set(nodes, "x", plan[nodes, :10])
        ready = time.process_time()
        solver.solve()
        ended = time.process_time()
        first = solver.get(0, "u")
        inside.append(1e6 * (ended - ready))
        outside.append(1e6 * (ended - began))
        apart.append(abs(first[0] - command[0]))
        states, inputs = (np.array([solver.get(n, key) for n in range(nodes + last)]) for key, last in (("x", 1), ("u", 0)))
        plan = np.column_stack([states, np.vstack([inputs, inputs[-1:]])])
        plan += settings.period / h * (np.vstack([plan[1:], plan[-1:]]) - plan)
    return np.array(inside), np.array(outside), np.array(apart)
