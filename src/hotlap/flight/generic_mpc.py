"""The model-predictive controller with any model of the vehicle: CasADi differentiates it.

`mpc` linearises `models.node_map` in closed form, and `riccati` is written for the structure of that Jacobian. Here a model is any CasADi
function (state p q v, input, duration, constants) -> state after it; the stages leave out entries of its Jacobian that are always zero.
A controller with another model is a function in `dynamics.models`, a `ControllerKind` and an entry in `registry`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any

from numba import njit

from hotlap.dynamics.parameter_layout import MODEL, TANGENT, TANGENT_COLUMNS
from hotlap.flight.compile import compiled, compiled_dynamics, translate
from hotlap.flight.control_loop import predictor
from hotlap.flight.job import Job, Settings
from hotlap.flight.line_search import search
from hotlap.flight.mpc import Mpc, allocate_mpc, solver
from hotlap.flight.mpc_step import begin_control, controls
from hotlap.flight.numbers import INLINE
from hotlap.flight.program import Number, Program
from hotlap.flight.riccati import INNER_STEPS, Backward, forward_stage, state_gradient, triangle

Entry = Number | float
JACOBIAN_SIZE, CONSTANTS = TANGENT * TANGENT_COLUMNS, sum(MODEL.values())


def general_backward_stage(pattern: Any) -> Program:
    """As `riccati.backward_stage`, with C = [A B] row by row."""
    return GeneralBackward(pattern).build()


def general_forward_stage(pattern: Any) -> Program:
    """As `riccati.forward_stage`, with C = [A B] row by row."""

    def follow(c: Sequence[Number], e: Sequence[Number], changes: Sequence[Number], h: Number) -> list[Number]:  # noqa: ARG001
        rows = unpack(c, pattern)
        return [e[0].tape.lift(_sum(zip(row, [*e, *changes], strict=True))) for row in rows]

    return forward_stage(follow, JACOBIAN_SIZE)


def unpack(c: Sequence[Number], pattern: Any) -> list[list[Entry]]:
    """[A B] as numbers in memory and constants, shape (9, 13)."""
    return [[pattern.get((i, j), c[TANGENT_COLUMNS * i + j]) for j in range(TANGENT_COLUMNS)] for i in range(TANGENT)]


def _sum(products: Iterable[tuple[Entry, Entry]]) -> Any:
    """Sum of products, without those that are zero."""
    total: Any = 0.0
    for a, b in products:
        if a == 0.0 or b == 0.0:
            continue
        total = total + (b if a == 1.0 else a * b)
    return total


class GeneralBackward(Backward):
    """The backward stage for a Jacobian with no structure but zeros and ones."""

    jacobian_size, scratch_size = JACOBIAN_SIZE, 240

    def __init__(self, pattern: Any) -> None:
        super().__init__()
        self.J = unpack(self.jacobian, pattern)

    def _column(self, j: int) -> list[Entry]:
        """A column of [A B]."""
        return [row[j] for row in self.J]

    def _propagate(self) -> None:
        """V = P+ [A B]."""
        self.V: list[list[Number]] = []
        for i in range(TANGENT):
            row = [_sum((self.J[k][j], self._value(i, k)) for k in range(TANGENT)) for j in range(TANGENT_COLUMNS)]
            self.V.append(self._keep(row))
            self.tape.section()

    def _congruence_of(self, i: int, j: int) -> Number:
        """([A B]' P+ [A B])(i, j)."""
        return self.tape.lift(_sum(zip(self._column(i), [row[j] for row in self.V], strict=True)))

    def _collect(self) -> None:
        """Q_uu and the gradients."""
        self.Quu = {(a, b): self._congruence_of(9 + a, 9 + b) + (self.R[a] if a == b else 0.0) for a in range(4) for b in range(a + 1)}
        slopes = [self.tape.lift(_sum(zip(self._column(j), self.p, strict=True))) for j in range(TANGENT_COLUMNS)]
        self.Qu = [slopes[9 + a] + self.R[a] * (self.u[a] - self.r[10 + a]) for a in range(4)]
        gradient = state_gradient(self.Q, self.x, self.deviation, self.r)
        self.Qx = self._keep([slopes[i] + gradient[i] for i in range(TANGENT)])

    def _minimise(self) -> None:
        """The input's box problem by projected Newton steps."""
        room = [(self.low[a] - self.u[a], self.high[a] - self.u[a]) for a in range(4)]
        inverse, step, gradient = self._newton(room, None, self.Qu)
        for _ in range(INNER_STEPS - 1):
            inverse, step, gradient = self._newton(room, step, gradient)
        self.tape.store(15, step)
        self.inverse = self._keep([inverse[a, b] for a in range(4) for b in range(a + 1)])
        self.gradient, self.step = self._keep(gradient), self._keep(step)
        self.tape.section()
        self.Y = [self._keep([self._congruence_of(9 + a, j) for j in range(TANGENT)]) for a in range(4)]  # Q_ux
        self.tape.section()
        self.Qxx: list[Number] = []
        for i in range(TANGENT):
            row = [self._congruence_of(i, j) for j in range(i + 1)]
            row[i] = row[i] + self.Q[i]
            self.Qxx += self._keep(row)
            self.tape.section()

    def _state_curvature(self, i: int, j: int) -> Number:
        return self.Qxx[triangle(i, j)]


@njit(**INLINE)
def begin_generic_mpc(job: Job, s: Settings, mpc: Mpc, k: int) -> None:
    """Prepare a lane for a new flight: bounds, weights and the parameters of the control model."""
    begin_control(job, s, mpc, k)
    for n in range(len(job.control_model)):
        mpc.constants[n, k] = job.control_model[n]


allocate_generic_mpc = partial(allocate_mpc, constants=CONSTANTS, jacobian=JACOBIAN_SIZE, scratch=GeneralBackward.scratch_size)


def generic_control(name: str) -> Any:
    """A control step with the model of that name in `hotlap.dynamics.models`; CasADi is loaded when the step is compiled, not before."""
    solve = solver(*_stages(name))
    predict = predictor(compiled_dynamics(name))
    return controls(predict, solve, model_has_drag=True)[1]


def generic_search(name: str) -> Any:
    """The same for `line_search`."""
    linearise, backward, _ = _stages(name)
    node = compiled_dynamics(name)
    return search(predictor(node), linearise, backward, node, model_has_drag=True)


def _stages(name: str) -> tuple[Callable[..., None], Callable[..., None], Callable[..., None]]:
    """Linearisation, backward and forward stage of a model."""

    def with_node(build: Callable[..., Program]) -> Callable[..., None]:
        def program() -> Program:
            from hotlap.dynamics import linearisation, models  # noqa: PLC0415  CasADi takes its time to load

            return build(getattr(models, name)(), linearisation)

        return compiled(program)

    return (
        with_node(lambda node, linearisation: translate(linearisation.linearised(node))),
        with_node(lambda node, linearisation: general_backward_stage(linearisation.pattern_of(node))),
        with_node(lambda node, linearisation: general_forward_stage(linearisation.pattern_of(node))),
    )
