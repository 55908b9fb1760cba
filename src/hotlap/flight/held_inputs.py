"""What `line_search` aims at: the reference over the horizon of a lane, its inputs as control periods hold them, and the last plan moved.

Between nodes that lie far apart the reference's inputs go on changing, and at its rate a controller can follow them. So a node's input is
an offset from them that is held, and the model is flown in parts of a node with the reference's inputs of that part. Commands are held
over a control period: where that is longer than a part, the inputs of the reference are averaged as the commands will be.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from hotlap.flight.control_loop import ControlLoop
from hotlap.flight.job import Job, Settings
from hotlap.flight.mpc_reference import hover_inputs, read_reference
from hotlap.flight.mpc_step import HORIZON, WEIGHTS
from hotlap.flight.numbers import INLINE
from hotlap.flight.segment_switch import BY_NODE, FRESH, piece_at, piece_flown

NEARLY = 1e-9  # of a period: as good as its end


@njit(**INLINE)
def aim_search(job: Job, s: Settings, m: Any, loop: ControlLoop, k: int, flight: int, before: int, time: float, elapsed: float) -> int:
    """Read the reference and the weights of a lane's control step, and move its last plan on; as `mpc_step.aim`.

    Between control steps `X` and `U` are offsets from the reference.
    """
    ahead = time + s.lead
    piece = piece_flown(job, s, loop.seen, k, before, ahead)
    segment = job.piece_segments[piece]
    spacing = job.parameters[flight, segment, HORIZON]
    m.fresh[0, k] = 0
    if before == FRESH:
        m.fresh[0, k], m.X[:, :, k], m.U[:, :, k] = 1, 0, 0
    else:
        move_offsets(m, k, spacing, elapsed)
    m.spacing[0, k], m.part[0, k] = spacing, spacing / m.inputs_in_parts.shape[1]
    read_reference(m, k, job.table, s.table_period, ahead, spacing)
    read_inputs(m, k, job.table, s, ahead)
    for n in range(len(m.weights)):
        if s.segment_switch == BY_NODE:
            segment = job.piece_segments[piece_at(job.row_pieces, s.table_period, ahead + n * spacing)]
        for i in range(4):
            m.weights[n, i, k] = job.parameters[flight, segment, WEIGHTS[i]]
    return piece


@njit(**INLINE)
def move_offsets(m: Any, k: int, spacing: float, later: float) -> None:
    """Interpolate a lane's plan to nodes of another spacing [s] that begin later [s]; offsets behind its end are those at its end."""
    nodes, old = len(m.U), float(m.spacing[0, k])
    states, inputs, gains = m.X[:, :, k].copy(), m.U[:, :, k].copy(), m.gains[:, :, k].copy()
    for n in range(nodes + 1):
        place = min((n * spacing + later) / old, float(nodes))
        row = min(int(place), nodes - 1)
        share = m.X.dtype.type(place - row)
        for i in range(10):
            m.X[n, i, k] = states[row, i] + share * (states[row + 1, i] - states[row, i])
        if n < nodes:
            following = min(row + 1, nodes - 1)
            for a in range(4):
                m.U[n, a, k] = inputs[row, a] + share * (inputs[following, a] - inputs[row, a])
            nearest = min(int(place + 0.5), nodes - 1)
            if nearest != n:
                for i in range(gains.shape[1]):
                    m.gains[n, i, k] = gains[nearest, i]


@njit(**INLINE)
def read_inputs(m: Any, k: int, table: np.ndarray, s: Settings, time: float) -> None:
    """Read the reference's inputs in the parts of a lane's nodes, their means, and that of the present control period."""
    parts, part = m.inputs_in_parts.shape[1], float(m.part[0, k])
    if not s.feed_forward:
        hover_inputs(m, k, s.gravity)
        for a in range(4):
            m.inputs_now[a, k] = m.reference[0, 10 + a, k]
            m.mean_inputs[:, a, k], m.inputs_in_parts[:, :, a, k] = m.inputs_now[a, k], m.inputs_now[a, k]
        return
    for a in range(4):
        m.inputs_now[a, k] = mean_input(table, a, s.table_period, time, s.period)
        for n in range(len(m.U)):
            total = table.dtype.type(0)
            for j in range(parts):
                m.inputs_in_parts[n, j, a, k] = part_input(table, a, s, time, (n * parts + j) * part, part)
                total += m.inputs_in_parts[n, j, a, k]
            m.mean_inputs[n, a, k] = total / parts


@njit(**INLINE)
def part_input(table: np.ndarray, a: int, s: Settings, time: float, begin: float, part: float) -> Any:
    """Mean of an input over a part that begins so much later [s], as control periods hold it where these are not much shorter."""
    if s.period < 0.5 * part:
        return mean_input(table, a, s.table_period, time + begin, part)
    end, tick, total = begin + part, math.floor(begin / s.period + NEARLY), table.dtype.type(0)
    while tick * s.period < end - NEARLY * s.period:
        share = (min(end, (tick + 1) * s.period) - max(begin, tick * s.period)) / part
        total += table.dtype.type(share) * mean_input(table, a, s.table_period, time + tick * s.period, s.period)
        tick += 1
    return total


@njit(**INLINE)
def mean_input(table: np.ndarray, a: int, row_period: float, time: float, span: float) -> Any:
    """Mean of an input of the reference from a time on over a span [s]: of two places, which is exact for a line."""
    return (_input_at(table, a, row_period, time + 0.25 * span) + _input_at(table, a, row_period, time + 0.75 * span)) / 2


@njit(**INLINE)
def _input_at(table: np.ndarray, a: int, row_period: float, time: float) -> Any:
    place = time / row_period
    row = int(min(place, len(table) - 2))
    share = table.dtype.type(min(place - row, 1.0))
    return table[row, 10 + a] + share * (table[row + 1, 10 + a] - table[row, 10 + a])
