"""A tape records arithmetic in the order in which it was written, and once."""

from __future__ import annotations

import operator

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from hotlap.flight.program import MEANING, Instruction, Number, Program, Tape, dot, run

OPERATORS = {
    "a + b": operator.add,
    "a - b": operator.sub,
    "a * b": operator.mul,
    "a / b": operator.truediv,
    "a + 2": lambda a, b: a + 2.0,
    "2 + a": lambda a, b: 2.0 + a,
    "2 - a": lambda a, b: 2.0 - a,
    "2 * a": lambda a, b: 2.0 * a,
    "2 / a": lambda a, b: 2.0 / a,
    "-a": lambda a, b: -a,
    "dot": lambda a, b: dot([a, b, a], [b, 3.0, b]),
}
CONDITIONS = {
    "a < b": operator.lt,
    "a <= b": operator.le,
    "a > b": operator.gt,
    "a >= b": operator.ge,
    "both": lambda a, b: (a < b) & (b > 0.0),
    "either": lambda a, b: (a < b) | (b > 0.0),
}
PAIRS = ((0.7, 1.9), (1.9, 0.7), (-0.4, -1.1), (0.5, 0.5))
each_pair = pytest.mark.parametrize("pair", PAIRS)


def names(program: Program) -> list[str]:
    return [instruction.operation for instruction in program.instructions]


def record(function: object, pair: tuple[float, float]) -> float:
    """The value of a function of two numbers, through a tape."""
    tape = Tape()
    tape.store(1, [function(*tape.array(0, 2))])
    out = np.zeros(1)
    run(tape.program, [np.array(pair), out])
    return out[0]


@each_pair
@pytest.mark.parametrize("function", OPERATORS.values(), ids=OPERATORS)
def test_operators_mean_what_they_mean_in_python(function, pair):
    assert record(function, pair) == function(*pair)


@each_pair
def test_a_sum_is_added_up_from_the_left(pair):  # as Python did before 3.12, which carries what is rounded away
    assert record(lambda a, b: sum([a, b, a]), pair) == pair[0] + pair[1] + pair[0]


@each_pair
@pytest.mark.parametrize("condition", CONDITIONS.values(), ids=CONDITIONS)
def test_conditions_choose(condition, pair):
    assert record(lambda a, b: condition(a, b).where(a, -7.0), pair) == (pair[0] if condition(*pair) else -7.0)


@each_pair
def test_smaller_larger_and_root(pair):
    assert record(lambda a, b: a.minimum(b), pair) == min(pair)
    assert record(lambda a, b: a.maximum(b), pair) == max(pair)
    assert record(lambda a, b: (a * a).square_root(), pair) == abs(pair[0])


def test_the_same_operation_is_recorded_once():
    tape = Tape()
    a, b = tape.array(0, 2)
    assert (a * b + 1.0).result == (a * b + 1.0).result
    assert names(tape.program) == ["load", "load", "multiply", "constant", "add"]
    assert tape.program.count() == 2


def test_unlike_operations_are_not_confused():
    tape = Tape()
    a, b = tape.array(0, 2)
    assert len({(a - b).result, (b - a).result, (a / b).result, tape.lift(1.0).result, tape.lift(2.0).result}) == 5


def test_numbers_are_loaded_where_they_are_used():
    tape = Tape()
    a, _, c = tape.array(0, 3)
    assert tape.program.instructions == ()
    _ = c + a
    assert [instruction.index for instruction in tape.program.instructions if instruction.operation == "load"] == [2, 0]


def test_a_section_loads_numbers_in_memory_anew():
    tape = Tape()
    (a,) = tape.array(0, 1)
    _ = a + 1.0
    tape.section()
    _ = a * 2.0
    assert names(tape.program).count("load") == 2


def test_a_section_keeps_results():
    tape = Tape()
    (a,) = tape.array(0, 1)
    total = a + 1.0
    tape.section()
    assert (total * 1.0)._result == len(tape.instructions) - 1
    assert names(tape.program).count("load") == 1


def test_what_was_stored_is_read_from_memory():
    tape = Tape()
    (a,) = tape.array(0, 1)
    (kept,) = tape.store(1, [a + 1.0])
    tape.section()
    tape.store(2, [kept * 3.0])
    memory, out = np.zeros(1), np.zeros(1)
    run(tape.program, [np.array([4.0]), memory, out])
    assert (memory[0], out[0]) == (5.0, 15.0)
    assert Instruction("load", 5, (), 1, 0) in tape.program.instructions


def test_stores_keep_their_order():
    tape = Tape()
    a, b = tape.array(0, 2)
    tape.store(1, [a, b])
    tape.store(1, [b], start=0)
    out = np.zeros(2)
    run(tape.program, [np.array([1.0, 2.0]), out])
    assert_array_equal(out, [2.0, 2.0])


def test_python_numbers_are_stored_as_constants():
    tape = Tape()
    tape.store(0, [0.0, 1.5], start=1)
    out = np.full(3, 9.0)
    run(tape.program, [out])
    assert_array_equal(out, [9.0, 0.0, 1.5])


def test_a_number_that_is_no_number_stays_one_if_it_comes_first():
    nan = float("nan")
    assert np.isnan(record(lambda a, b: a.minimum(b), (nan, 1.0)))
    assert np.isnan(record(lambda a, b: a.maximum(b), (nan, 1.0)))
    assert record(lambda a, b: a.maximum(b), (1.0, nan)) == 1.0


def test_every_operation_of_a_number_has_a_meaning():
    tape = Tape()
    a, b = (Number(tape, argument=0, index=k) for k in range(2))
    mixed = (((a < b) & (b <= a)) | (a > b)).where(a - b, -(a / b)).minimum(a * b + 1.0).maximum(b).square_root()
    tape.store(1, [mixed])
    assert set(names(tape.program)) - {"load", "store", "constant", "section"} <= set(MEANING)
