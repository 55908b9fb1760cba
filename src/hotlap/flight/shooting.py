"""Straight-line stages with which `line_search` flies a policy through the controller's model, and what that costs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from hotlap.flight.compile import compiled
from hotlap.flight.program import Number, Program, Tape, dot
from hotlap.flight.riccati import GAIN_SIZE, attitude_error


def policy_stage() -> Program:
    """(x, planned x, planned u, k, K, share, low, high) -> u + share k + K e within bounds, e the deviation from the planned x."""
    tape = Tape()
    sizes = (10, 10, 4, 4, GAIN_SIZE, 1, 4, 4)
    x, planned, u, feed, gains, (share,), low, high = (tape.array(k, size) for k, size in enumerate(sizes))
    turn = attitude_error(planned[3:7], x[3:7])
    e = [*(x[i] - planned[i] for i in range(3)), *(2.0 * part for part in turn), *(x[7 + i] - planned[7 + i] for i in range(3))]
    wanted = [u[a] + share * feed[a] + dot(gains[9 * a : 9 * a + 9], e) for a in range(4)]
    tape.store(8, _within(wanted, low, high))
    return tape.program


def part_stage() -> Program:
    """(u, reference, inputs of the reference in a part of the node, low, high) -> input in that part, as far from the reference as u."""
    tape = Tape()
    u, r, part, low, high = (tape.array(k, size) for k, size in enumerate((4, 14, 4, 4, 4)))
    tape.store(5, _within([part[a] + (u[a] - r[10 + a]) for a in range(4)], low, high))
    return tape.program


def state_cost_stage() -> Program:
    """(x, reference, Q, cost) -> cost + |x - reference|^2_Q / 2."""
    tape = Tape()
    x, r, (xy, z, attitude, velocity), (cost,) = (tape.array(k, size) for k, size in enumerate((10, 14, 4, 1)))
    weights = [xy, xy, z, *[attitude] * 4, *[velocity] * 3]
    tape.store(4, [cost + _half_square(weights, [x[i] - r[i] for i in range(10)])])
    return tape.program


def input_cost_stage() -> Program:
    """(u, reference, R, cost) -> cost + |u - reference|^2_R / 2."""
    tape = Tape()
    u, r, weights, (cost,) = (tape.array(k, size) for k, size in enumerate((4, 14, 4, 1)))
    tape.store(4, [cost + _half_square(weights, [u[a] - r[10 + a] for a in range(4)])])
    return tape.program


def unit_stage() -> Program:
    """x -> x with a quaternion of length 1."""
    tape = Tape()
    x = tape.array(0, 10)
    scale = 1.0 / dot(x[3:7], x[3:7]).square_root()
    tape.store(0, [part * scale for part in x[3:7]], 3)
    return tape.program


def _within(wanted: Sequence[Number], low: Sequence[Number], high: Sequence[Number]) -> list[Number]:
    return [value.maximum(least).minimum(most) for value, least, most in zip(wanted, low, high, strict=True)]


def _half_square(weights: Sequence[Any], errors: Sequence[Number]) -> Any:
    return 0.5 * dot([weight * error for weight, error in zip(weights, errors, strict=True)], errors)


follow_policy = compiled(policy_stage)
input_in_part = compiled(part_stage)
add_state_cost = compiled(state_cost_stage)
add_input_cost = compiled(input_cost_stage)
make_unit = compiled(unit_stage)
