"""CasADi functions become programs, and programs become code, without a change of meaning."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from numba import njit
from numpy.testing import assert_allclose, assert_array_equal

from hotlap.core.errors import HotlapError
from hotlap.flight.compile import compiled, translate
from hotlap.flight.lanes import as_numbers
from hotlap.flight.numbers import COMPILE, Numbers
from hotlap.flight.program import MEANING, Instruction, Program, run

OPERATIONS = {
    "OP_ADD": lambda a, b, c: a + b,
    "OP_SUB": lambda a, b, c: a - b,
    "OP_MUL": lambda a, b, c: a * b,
    "OP_DIV": lambda a, b, c: a / b,
    "OP_NEG": lambda a, b, c: -a,
    "OP_FMIN": lambda a, b, c: ca.fmin(a, b),
    "OP_FMAX": lambda a, b, c: ca.fmax(a, b),
    "OP_FABS": lambda a, b, c: ca.fabs(a),
    "OP_SQ": lambda a, b, c: a**2,
    "OP_TWICE": lambda a, b, c: a + a,
    "OP_INV": lambda a, b, c: 1 / a,
    "OP_SQRT": lambda a, b, c: ca.sqrt(1 + a * a),
    "OP_SIN": lambda a, b, c: ca.sin(a),
    "OP_COS": lambda a, b, c: ca.cos(a),
    "OP_EXP": lambda a, b, c: ca.exp(a),
    "OP_LT": lambda a, b, c: a < b,
    "OP_LE": lambda a, b, c: a <= b,
    "OP_NOT": lambda a, b, c: ca.logic_not(a < b),
    "OP_IF_ELSE_ZERO": lambda a, b, c: ca.if_else(a < b, c, 2 * b),
    "OP_CONST": lambda a, b, c: a + 0.1,
}
NAMES = {getattr(ca, name): name for name in dir(ca) if name.startswith("OP_")}
POINTS = [*np.random.default_rng(4).normal(size=(40, 3)), np.array([0.5, 0.5, 1.0]), np.array([0.5, -0.5, 0.0])]
ALSO = {"OP_TWICE": "OP_ADD"}  # how CasADi 3.6 writes it


def make(expression: object) -> ca.Function:
    x = ca.SX.sym("x", 3)
    return ca.Function("made", [x], [expression(x[0], x[1], x[2])])


@pytest.mark.parametrize("name", OPERATIONS)
def test_an_operation_means_what_it_means_in_casadi(name):
    function = make(OPERATIONS[name])
    assert {name, ALSO.get(name)} & {NAMES[function.instruction_id(k)] for k in range(function.n_instructions())}
    program, out = translate(function), np.zeros(1)
    for point in POINTS:
        run(program, [point, out])
        assert out[0] == pytest.approx(float(function(point)), rel=1e-15, abs=0)


def test_work_slots_that_casadi_uses_again_do_not_mix():
    function = make(lambda a, b, c: ca.sin(a + b) * ca.cos(b + c) - ca.exp(a * c) / (2 + ca.sin(c - a) ** 2))
    program, out = translate(function), np.zeros(1)
    assert [instruction.result for instruction in program.instructions] == list(range(len(program.instructions)))
    run(program, [POINTS[0], out])
    assert out[0] == pytest.approx(float(function(POINTS[0])), rel=1e-14)


def test_arguments_and_results_keep_their_places():
    x, y = ca.SX.sym("x", 2), ca.SX.sym("y", 2)
    function = ca.Function("several", [x, y], [ca.vertcat(x[1], y[0], 7), x[0] - y[1]])
    first, second = np.zeros(3), np.zeros(1)
    run(translate(function), [np.array([1.0, 2.0]), np.array([30.0, 40.0]), first, second])
    assert_array_equal(first, [2.0, 30.0, 7.0])
    assert second[0] == -39.0


@pytest.mark.parametrize(("expression", "name"), [(ca.tan, "tan"), (ca.atan, "atan"), (ca.floor, "floor")])
def test_an_unknown_operation_is_named(expression, name):
    with pytest.raises(HotlapError, match=rf"^made: .* {name}$"):
        translate(make(lambda a, b, c: expression(a)))


BINARY = ("add", "subtract", "multiply", "divide", "minimum", "maximum")
UNARY = ("negate", "sqrt", "sin", "cos", "exp")
COMPARISONS = ("less", "less_equal")
OUTPUTS = len(BINARY) + len(UNARY) + len(COMPARISONS) + 3


def every_operation() -> Program:
    """Each operation of programs, of the numbers in memory 0 (two of any sign, one positive, a truth value), into memory 1."""
    made: list[Instruction] = []

    def add(operation: str, *operands: int, argument: int = -1, index: int = -1, value: float = 0.0) -> int:
        made.append(Instruction(operation, len(made), operands, argument, index, value))
        return len(made) - 1

    a, b, positive, flag = (add("load", argument=0, index=k) for k in range(4))
    results = [add(name, a, b) for name in BINARY]
    results += [add(name, positive if name == "sqrt" else a) for name in UNARY]
    one, zero = add("constant", value=1.0), add("constant", value=0.0)
    conditions = [add(name, a, b) for name in COMPARISONS]
    add("section")
    conditions += [add("not_zero", flag), add("and", conditions[0], add("not_zero", flag)), add("or", conditions[0], add("not_zero", flag))]
    results += [add("select", condition, one, zero) for condition in conditions]
    for index, result in enumerate(results):
        add("store", result, argument=1, index=index)
    return Program(tuple(made))


everything = compiled(every_operation)


def values(kind: type, count: int) -> np.ndarray:
    """Memory for `every_operation`, shape (4, count)."""
    rng = np.random.default_rng(7)
    memory = np.vstack([rng.normal(size=(2, count)), rng.uniform(0.1, 3.0, count), rng.integers(0, 2, count)])
    return memory.astype(kind)


def test_every_operation_is_tried():
    tried = {instruction.operation for instruction in every_operation().instructions}
    assert tried >= set(MEANING)


@pytest.mark.parametrize("numbers", Numbers)
def test_compiled_programs_do_what_interpreted_ones_do(numbers):
    width = numbers.width

    @njit(**COMPILE)
    def call(memory: np.ndarray, out: np.ndarray) -> None:
        everything(as_numbers(memory, width), as_numbers(out, width))

    tolerance = 4 * np.finfo(numbers.dtype).eps
    for special in (None, 0, 1, 2, 3):  # no number in one place
        memory = values(numbers.dtype, numbers.lanes)
        if special is not None:
            memory[special] = np.nan
        out, expected = np.zeros((OUTPUTS, numbers.lanes), numbers.dtype), np.zeros((OUTPUTS, numbers.lanes))
        call(memory, out)
        for lane in range(numbers.lanes):
            everything(memory[:, lane], expected[:, lane])
        assert_allclose(out, expected, rtol=tolerance, atol=tolerance)
