"""Controller kinds by name; imports nothing that takes time."""

from __future__ import annotations

from enum import StrEnum


class ControllerKind(StrEnum):
    """Which controller flies.

    MPC: model-predictive, as in the paper (Eq. 3).
    MPC_DRAG: the same with a model that knows the drag of the vehicle; about half as fast.
    GEOMETRIC: geometric tracking on SE(3) (Lee, Leok, McClamroch, CDC 2010) with the reference's inputs fed forward.
    """

    MPC = "mpc"
    MPC_DRAG = "mpc_drag"
    GEOMETRIC = "geometric"


class Solver(StrEnum):
    """How an MPC solves its problem in each control step.

    REAL_TIME: one linearisation around the last plan, whose quadratic problem is swept: the paper's, and the fastest.
    LINE_SEARCH: each sweep linearises anew, and takes a step that lowers the cost; inputs are offsets from the reference's.
    """

    REAL_TIME = "real_time"
    LINE_SEARCH = "line_search"


def law_of(kind: ControllerKind, solver: Solver = Solver.REAL_TIME) -> str:
    """The name of a control law: a kind of controller, and how it solves its problem where that is not usual."""
    return str(kind) if solver is Solver.REAL_TIME else f"{kind}-{solver}"


def kind_and_solver(law: str) -> tuple[ControllerKind, Solver]:
    """The inverse of `law_of`."""
    kind, _, solver = law.partition("-")
    return ControllerKind(kind), Solver(solver) if solver else Solver.REAL_TIME
