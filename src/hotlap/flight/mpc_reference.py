"""The reference over the horizon of one lane, and the plan that the solver starts from."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from hotlap.flight.mpc import Mpc
from hotlap.flight.numbers import INLINE


@njit(**INLINE)
def read_reference(m: Any, lane: int, table: np.ndarray, period: float, time: float, spacing: float) -> None:
    """Read the reference at the nodes of a lane's horizon: linear between rows; the last row holds for ever.

    Args:
        m: raw memory of a controller; `reference` of the lane is written.
        lane: which one.
        table: shape (rows, 14) p q v, inputs.
        period: [s] between rows.
        time: [s] of the first node.
        spacing: [s] of the nodes.
    """
    last = len(table) - 2
    for n in range(len(m.reference)):
        place = (time + n * spacing) / period
        row = int(min(place, last))
        share = m.reference.dtype.type(min(place - row, 1.0))
        for i in range(14):
            m.reference[n, i, lane] = table[row, i] + share * (table[row + 1, i] - table[row, i])


@njit(**INLINE)
def hover_inputs(m: Any, lane: int, gravity: float) -> None:
    """Replace the reference's inputs by those of hovering."""
    for n in range(len(m.reference)):
        m.reference[n, 10, lane] = gravity
        for a in range(11, 14):
            m.reference[n, a, lane] = 0


@njit(**INLINE)
def plan_as_reference(m: Mpc, lane: int) -> None:
    """Take the reference as the first plan."""
    for n in range(len(m.X)):
        for i in range(10):
            m.X[n, i, lane] = m.reference[n, i, lane]
    for n in range(len(m.U)):
        for a in range(4):
            m.U[n, a, lane] = m.reference[n, 10 + a, lane]


@njit(**INLINE)
def respace_plan(m: Mpc, lane: int, old: float, new: float, later: float) -> None:
    """Interpolate the plan to nodes of another spacing; beyond its end, take the reference.

    Args:
        m: raw memory, with the reference on the new nodes.
        lane: which one.
        old: [s] spacing of the plan.
        new: [s] spacing wanted.
        later: [s] by which the new plan begins later.
    """
    nodes = len(m.U)
    states, inputs = m.X[:, :, lane].copy(), m.U[:, :, lane].copy()
    for n in range(nodes + 1):
        place = (n * new + later) / old
        row = int(min(place, nodes))
        share = m.X.dtype.type(place - row)
        for i in range(10):
            if row < nodes:
                m.X[n, i, lane] = states[row, i] + share * (states[row + 1, i] - states[row, i])
            else:
                m.X[n, i, lane] = m.reference[n, i, lane]
        if n < nodes:
            for a in range(4):
                if row < nodes - 1:
                    m.U[n, a, lane] = inputs[row, a] + share * (inputs[row + 1, a] - inputs[row, a])
                elif row < nodes:
                    m.U[n, a, lane] = inputs[row, a]
                else:
                    m.U[n, a, lane] = m.reference[n, 10 + a, lane]
