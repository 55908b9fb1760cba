"""Multi-phase multiple shooting: a minimum-time problem as a sparse nonlinear program with exact derivatives.

    minimise    sum of T_i                            over z = [T_1 .. T_M; x_0, u_0; x_1, u_1; ..; x_N]
    subject to  x_{k+1} - F(x_k, u_k, T_i / K) = 0    the gaps, N nx rows
                |p_{iK} - waypoint_i|^2 <= r^2        the balls, M rows
                |u_k|^2 <= a^2                        the thrusts, N rows, point mass only
                l_j <= c_j . (p_k, v_k) <= h_j        linear rows: openings and obstacles

A phase may have another number K of intervals than the rest.
All intervals share one stage; the non-zeros of its derivatives are put where they belong in the large sparse matrices.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from hotlap.planning.batch import evaluate
from hotlap.planning.linear_rows import LinearRows
from hotlap.planning.problem import Floats, Problem, Trajectory
from hotlap.planning.stage import Stage

Indices = NDArray[np.intp]


@dataclass(frozen=True)
class Shooting:
    """The program of M phases with K intervals each, or with numbers of their own.

    Parameters of the program are the waypoints, flattened, and the stage's parameters.

    Attributes:
        stage: one interval.
        phases: M.
        intervals: K of each phase.
        thrust_ball: whether the norm of each control is constrained.
        counts: intervals of each phase where they differ.
        linear: rows of positions and velocities at nodes.
    """

    stage: Stage
    phases: int
    intervals: int
    thrust_ball: bool = False
    counts: tuple[int, ...] = ()
    linear: LinearRows = field(default_factory=LinearRows.none)

    @classmethod
    def of(cls, stage: Stage, problem: Problem, rows: LinearRows | None = None, *, thrust_ball: bool = False) -> Shooting:
        """The program of a problem, with rows besides those of its openings."""
        linear = LinearRows.joined([problem.rows(), rows or LinearRows.none()])
        return cls(stage, problem.phases, problem.intervals, thrust_ball, problem.counts, linear)

    @cached_property
    def owners(self) -> Indices:
        """Phase of each interval, shape (N,)."""
        return np.repeat(np.arange(self.phases), self.counts or self.intervals)

    @cached_property
    def ends(self) -> Indices:
        """Node at which each phase ends, shape (M,)."""
        return np.cumsum(np.bincount(self.owners))

    @property
    def total(self) -> int:
        """N intervals."""
        return len(self.owners)

    @property
    def gap_rows(self) -> int:
        """Rows of the gaps; the balls follow, then the thrusts, then the linear ones."""
        return self.total * self.stage.nx

    @property
    def size(self) -> int:
        """Number of variables."""
        return self.phases + self.total * (self.stage.nx + self.stage.nu) + self.stage.nx

    @property
    def rows(self) -> int:
        """Number of constraints."""
        return self.nonlinear_rows + self.linear.count

    @property
    def nonlinear_rows(self) -> int:
        """Rows of gaps, balls and thrusts."""
        return self.gap_rows + self.phases + self.total * self.thrust_ball

    def pack(self, trajectory: Trajectory) -> Floats:
        """Variables z of a trajectory."""
        nodes = np.hstack([trajectory.states[:-1], trajectory.controls])
        return np.concatenate([trajectory.durations, nodes.ravel(), trajectory.states[-1]])

    def unpack(self, z: Floats) -> Trajectory:
        """The trajectory of variables z."""
        nodes = z[self.phases : -self.stage.nx].reshape(self.total, -1)
        states = np.vstack([nodes[:, : self.stage.nx], z[-self.stage.nx :]])
        return Trajectory(z[: self.phases], states, nodes[:, self.stage.nx :], self.counts)

    def parameters(self, waypoints: Floats, model: Floats) -> Floats:
        """Parameters of the program from waypoints, shape (M, 3), and parameters of the model."""
        return np.concatenate([waypoints.ravel(), model])

    @cached_property
    def program(self) -> dict[str, Any]:
        """What `casadi.nlpsol` takes as the problem."""
        s = self._symbols
        residual = s.next_states - evaluate(self.stage.step, *s.stage_inputs)[0]
        return {"x": s.z, "p": s.parameters, "f": ca.sum1(s.durations), "g": self._constraints(residual)}

    @cached_property
    def derivatives(self) -> dict[str, Any]:
        """What `casadi.nlpsol` takes as options: gradient, Jacobian and Hessian of the Lagrangian."""
        return {"grad_f": self._gradient(), "jac_g": self._jacobian(), "hess_lag": self._hessian()}

    @cached_property
    def _symbols(self) -> _Symbols:
        return _Symbols(self)

    @cached_property
    def _nodes(self) -> Indices:
        """Index in z of state and control of each node, shape (nx + nu, N)."""
        return self.phases + np.arange(self.total * (self.stage.nx + self.stage.nu)).reshape(self.total, -1).T

    @cached_property
    def _columns(self) -> Indices:
        """Index in z of the stage's w = (x, u, h) of each interval, shape (nx + nu + 1, N); h = T_i / K."""
        return np.vstack([self._nodes, self.owners])

    @cached_property
    def _next_nodes(self) -> Indices:
        """Index in z of the state after each interval, shape (nx, N)."""
        nx = self.stage.nx
        return np.hstack([self._nodes[:nx, 1:], np.arange(self.size - nx, self.size)[:, None]])

    @cached_property
    def _weights(self) -> Floats:
        """d w / d z: 1, and 1 / K for the step, shape (nx + nu + 1, N)."""
        weights = np.ones((self.stage.nx + self.stage.nu + 1, self.total))
        weights[-1] = 1 / np.bincount(self.owners)[self.owners]
        return weights

    @cached_property
    def _ball_columns(self) -> Indices:
        """Index in z of the position at the end of each phase, shape (3, M)."""
        return self._next_nodes[:3, self.ends - 1]

    @cached_property
    def _linear_entries(self) -> tuple[Indices, Indices, Floats]:
        """Row (from the first linear one), index in z and coefficient of each entry of the linear rows."""
        row, part = np.nonzero(self.linear.coefficients)
        states = np.hstack([self._nodes[:6], np.arange(self.size - self.stage.nx, self.size)[:6, None]])
        return row, states[part, self.linear.nodes[row]], self.linear.coefficients[row, part]

    @cached_property
    def _thrust_columns(self) -> Indices:
        """Index in z of the controls, shape (nu, N)."""
        return self._nodes[self.stage.nx :]

    def _constraints(self, residual: Any) -> Any:
        s = self._symbols
        thrusts = [ca.sum2(s.controls**2)] if self.thrust_ball else []
        return ca.vertcat(ca.vec(residual), ca.sum2(s.offsets**2), *thrusts, *self._linear(s.z))

    def _linear(self, z: Any) -> list[Any]:
        if not self.linear.count:
            return []
        row, column, coefficients = self._linear_entries
        return [ca.mtimes(ca.DM.triplet(row.tolist(), column.tolist(), ca.DM(coefficients), self.linear.count, self.size), z)]

    def _gradient(self) -> Any:
        s = self._symbols
        gradient = np.append(np.ones(self.phases), np.zeros(self.size - self.phases))
        return ca.Function("nlp_grad_f", [s.z, s.parameters], [ca.sum1(s.durations), ca.DM(gradient)], ["x", "p"], ["f", "grad_f_x"])

    def _jacobian(self) -> Any:
        s = self._symbols
        after, nonzeros = evaluate(self.stage.jacobian, *s.stage_inputs)
        row, column = (np.array(part) for part in self.stage.jacobian_sparsity.get_triplet())
        gaps = np.arange(self.gap_rows).reshape(self.stage.nx, self.total)
        balls = self.gap_rows + np.arange(self.phases)
        blocks = [
            _Block(gaps[row], self._columns[column], nonzeros, -self._weights[column]),
            _Block(gaps, self._next_nodes, ca.DM.ones(gaps.size), 1.0),
            _Block(balls, self._ball_columns, s.offsets, 2.0),
        ]
        if self.thrust_ball:
            thrusts = self.gap_rows + self.phases + np.arange(self.total)
            blocks.append(_Block(thrusts, self._thrust_columns, s.controls, 2.0))
        if self.linear.count:
            row, column, coefficients = self._linear_entries
            blocks.append(_Block(self.nonlinear_rows + row, column, ca.DM(coefficients), 1.0))
        outputs = [self._constraints(s.next_states - after), _assemble(blocks, (self.rows, self.size))]
        return ca.Function("nlp_jac_g", [s.z, s.parameters], outputs, ["x", "p"], ["g", "jac_g_x"])

    def _hessian(self) -> Any:
        """Upper triangle; the objective is linear, so that only constraints contribute."""
        s = self._symbols
        objective, multipliers = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", self.rows)
        marks = [0, self.gap_rows, self.gap_rows + self.phases, self.nonlinear_rows, self.rows]
        gaps, balls, thrusts, _ = ca.vertsplit(multipliers, marks)
        nonzeros = evaluate(self.stage.hessian, *s.stage_inputs, ca.reshape(gaps, self.total, self.stage.nx))[0]
        row, column = (np.array(part) for part in self.stage.hessian_sparsity.get_triplet())
        first, second = self._columns[row], self._columns[column]
        weights = -self._weights[row] * self._weights[column]
        blocks = [
            _Block(np.minimum(first, second), np.maximum(first, second), nonzeros, weights),
            _Block(self._ball_columns, self._ball_columns, ca.repmat(balls, 1, 3), 2.0),
        ]
        if self.thrust_ball:
            blocks.append(_Block(self._thrust_columns, self._thrust_columns, ca.repmat(thrusts, 1, self.stage.nu), 2.0))
        hessian = _assemble(blocks, (self.size, self.size))
        inputs, names = [s.z, s.parameters, objective, multipliers], ["x", "p", "lam_f", "lam_g"]
        return ca.Function("nlp_hess_l", inputs, [hessian], names, ["triu_hess_gamma_x_x"])


class _Symbols:
    """The variables of a program as CasADi sees them; matrices have one row an interval."""

    def __init__(self, shooting: Shooting) -> None:
        nx, count, phases = shooting.stage.nx, shooting.total, shooting.phases
        self.z = ca.MX.sym("z", shooting.size)
        self.parameters = ca.MX.sym("p", 3 * phases + shooting.stage.step.size1_in(3))
        self.durations = self.z[:phases]
        nodes = ca.reshape(self.z[phases:-nx], nx + shooting.stage.nu, count).T
        states = ca.vertcat(nodes[:, :nx], self.z[-nx:].T)
        self.controls = nodes[:, nx:]
        self.next_states = states[1:, :]
        steps = (self.durations / ca.DM(np.bincount(shooting.owners).astype(float)))[shooting.owners.tolist()]
        self.stage_inputs = [states[:-1, :], self.controls, steps, self.parameters[3 * phases :].T]
        self.offsets = states[shooting.ends.tolist(), :3] - ca.reshape(self.parameters[: 3 * phases], 3, phases).T


@dataclass(frozen=True)
class _Block:
    """Entries of a sparse matrix; what stands at the same place is added up.

    Attributes:
        rows, columns: shape (entries, groups), or what broadcasts to it.
        values: of shape (groups, entries).
        weights: factors, broadcast likewise.
    """

    rows: Indices
    columns: Indices
    values: Any
    weights: Floats | float


def _assemble(blocks: list[_Block], shape: tuple[int, int]) -> Any:
    """The sparse matrix of blocks: its non-zeros are a fixed linear map of all values."""
    triplets = [np.broadcast_arrays(block.rows, block.columns, block.weights) for block in blocks]
    rows, columns, weights = (np.concatenate([triplet[part].ravel() for triplet in triplets]) for part in range(3))
    places, place = np.unique(columns * shape[0] + rows, return_inverse=True)  # column by column, as CasADi stores them
    sparsity = ca.Sparsity.triplet(*shape, (places % shape[0]).tolist(), (places // shape[0]).tolist())
    collect = ca.DM.triplet(place.tolist(), range(len(place)), ca.DM(weights), len(places), len(place))
    return ca.MX(sparsity, ca.mtimes(collect, ca.vertcat(*[ca.vec(block.values) for block in blocks])))
