"""Linearises any model of a node by CasADi, in the controller's tangent coordinates, and finds the constants of the Jacobian."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import casadi as ca

from hotlap.dynamics.models import Expression, quaternion_product, tangent
from hotlap.dynamics.parameter_layout import TANGENT, TANGENT_COLUMNS

Pattern = Mapping[tuple[int, int], float]
"""Entries of the Jacobian that are the same number everywhere; those that are not zero and not among them lie in memory."""


def jacobian_of(node: ca.Function, x: Expression, u: Expression, h: Expression, constants: Expression) -> Expression:
    """[A B] of a node map in (p, theta, v) and inputs, shape (9, 13); attitudes are perturbed as q o [1, theta / 2].

    Args:
        node: (state p q v, input, duration, constants) -> state after it.
        x: shape (10,), where.
        u: shape (4,), where.
        h: [s].
        constants: shape (V,), what else the model takes.
    """
    moved = ca.SX.sym("d", TANGENT_COLUMNS)
    turned = quaternion_product(x[3:7], ca.vertcat(1, moved[3:6] / 2))
    after = node(ca.vertcat(x[:3] + moved[:3], turned, x[7:] + moved[6:9]), u + moved[9:], h, constants)
    change = difference(node(x, u, h, constants), after)
    return ca.substitute(ca.jacobian(change, moved), moved, ca.DM.zeros(TANGENT_COLUMNS))


def difference(a: Expression, b: Expression) -> Expression:
    """From a to b (p q v) in tangent coordinates, shape (9,)."""
    return ca.vertcat(b[:3] - a[:3], tangent(a[3:7], b[3:7]), b[7:] - a[7:])


def linearised(node: ca.Function) -> ca.Function:
    """A node map linearised around the plan, and the defect of the plan; as `models.linearised_node_map`, for any node map.

    (state, input, next state of the plan, deviation at this node, duration, bounds of the input, constants)
    -> input within its bounds, deviation at the next node, [A B] row by row, shape (117,).
    """
    x, u, following, deviation = ca.SX.sym("x", 10), ca.SX.sym("u", 4), ca.SX.sym("x+", 10), ca.SX.sym("dx", TANGENT)
    h, low, high, constants = ca.SX.sym("h"), ca.SX.sym("low", 4), ca.SX.sym("high", 4), ca.SX.sym("c", node.size1_in(3))
    bounded = ca.fmin(ca.fmax(u, low), high)
    jacobian = jacobian_of(node, x, u, h, constants)
    reached = difference(following, node(x, u, h, constants)) + jacobian @ ca.vertcat(deviation, bounded - u)
    inputs = [x, u, following, deviation, h, low, high, constants]
    return ca.Function("linearised", inputs, [bounded, reached, ca.densify(ca.vec(jacobian.T))], {"cse": True})


def pattern_of(node: ca.Function) -> Pattern:
    """The entries of the Jacobian of a node map that are constants; most of them are 0."""
    symbols: list[Any] = [ca.SX.sym("x", 10), ca.SX.sym("u", 4), ca.SX.sym("h"), ca.SX.sym("c", node.size1_in(3))]
    jacobian = ca.densify(jacobian_of(node, *symbols))
    places = [(i, j) for i in range(TANGENT) for j in range(TANGENT_COLUMNS)]
    return {place: float(jacobian[place]) for place in places if jacobian[place].is_constant()}
