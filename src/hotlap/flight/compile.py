"""Translates CasADi functions into programs, and programs into LLVM code for any kind of number."""

# pyright: reportCallIssue=false
# Numba's decorators change what they decorate.

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

from hotlap.core.errors import HotlapError
from hotlap.flight.lanes import PLAIN_MATH, Lanes, implement, math_intrinsic
from hotlap.flight.program import Instruction, Program, run

_ARITHMETIC = {"add": "fadd", "subtract": "fsub", "multiply": "fmul", "divide": "fdiv"}
_COMPARISON = {"less": "<", "less_equal": "<="}


def compiled(build: Callable[[], Program]) -> Callable[..., None]:
    """A function of 1-d arrays of numbers that runs a program: compiled inside @njit code, interpreted elsewhere.

    The program is built when it is first needed, so a cached kernel never builds it (nor imports CasADi).
    """
    program = cache(build)

    def function(*arrays: np.ndarray) -> None:
        """Outside of compiled code: instruction by instruction."""
        run(program(), arrays)

    @intrinsic
    def emit(typing: Any, arrays: Any) -> Any:
        """Inside of it: the instructions, in place of the call."""

        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            """Write the instructions, with the arrays' first elements as where they read and write."""
            kinds = signature.args[0].types
            values = cgutils.unpack_tuple(builder, arguments[0], len(kinds))
            pointers = [make_array(kind)(context, builder, value).data for kind, value in zip(kinds, values, strict=True)]
            _emit(builder, program(), pointers, kinds[0].dtype, context.get_value_type(kinds[0].dtype))
            return context.get_dummy_value()

        return types.void(arrays), generate

    @implement(function)
    def typed(*arrays: Any) -> Any:
        """For any number of arrays."""
        return lambda *arrays: emit(arrays)

    return function


def compiled_dynamics(name: str) -> Callable[..., None]:
    """A function of `hotlap.dynamics.models` as `compiled` makes it; CasADi is loaded when it is compiled, not before."""
    return compiled(lambda: translate(getattr(import_module("hotlap.dynamics.models"), name)()))


def _emit(builder: Any, program: Program, pointers: list, kind: Any, llvm_type: Any) -> None:
    """Write the instructions of a program at the builder's place."""
    lanes = isinstance(kind, Lanes)
    alignment = (kind.element if lanes else kind).bitwidth // 8
    values: dict[int, Any] = {}

    def constant(value: float) -> Any:
        """A number, once or in every lane."""
        scalar = ir.Constant(llvm_type.element if lanes else llvm_type, value)
        return ir.Constant(llvm_type, [scalar] * kind.width) if lanes else scalar

    for operation, result, operands, argument, index, value in program.instructions:
        inputs = [values[operand] for operand in operands]
        if operation in ("load", "store"):
            place = builder.gep(pointers[argument], [ir.Constant(ir.IntType(64), index)])
            access = builder.load(place) if operation == "load" else builder.store(inputs[0], place)
            access.align = alignment
            values[result] = access
        elif operation == "constant":
            values[result] = constant(value)
        elif operation == "section":
            builder.asm(ir.FunctionType(ir.VoidType(), []), "", "~{memory}", [], side_effect=True)
        elif operation == "not_zero":
            values[result] = builder.fcmp_unordered("!=", inputs[0], constant(0.0))
        else:
            values[result] = _calculate(builder, operation, inputs)


def _calculate(builder: Any, operation: str, inputs: list) -> Any:
    """One arithmetic operation."""
    if operation in _ARITHMETIC:
        return getattr(builder, _ARITHMETIC[operation])(*inputs, flags=PLAIN_MATH)
    if operation in _COMPARISON:
        return builder.fcmp_ordered(_COMPARISON[operation], *inputs)
    if operation in ("minimum", "maximum"):  # as in `program.MEANING`: a NaN stays a NaN
        closer = builder.fcmp_ordered("<" if operation == "minimum" else ">", inputs[1], inputs[0])
        return builder.select(closer, inputs[1], inputs[0])
    if operation == "negate":
        return builder.fneg(inputs[0], flags=PLAIN_MATH)
    if operation == "and":
        return builder.and_(*inputs)
    if operation == "or":
        return builder.or_(*inputs)
    if operation == "select":
        return builder.select(*inputs)
    return math_intrinsic(builder, operation, inputs[0])


_PLAIN = {
    "OP_ADD": "add", "OP_SUB": "subtract", "OP_MUL": "multiply", "OP_DIV": "divide", "OP_NEG": "negate",
    "OP_FMIN": "minimum", "OP_FMAX": "maximum", "OP_SQRT": "sqrt", "OP_SIN": "sin", "OP_COS": "cos", "OP_EXP": "exp",
}  # fmt: skip


class _Translator:
    """Collects the instructions of a CasADi function; work slots are renamed so that every result is new."""

    def __init__(self) -> None:
        self.instructions: list[Instruction] = []
        self.slot: dict[int, int] = {}

    def add(self, operation: str, *operands: int, argument: int = -1, index: int = -1, value: float = 0.0) -> int:
        """Append an instruction; returns its result."""
        self.instructions.append(Instruction(operation, len(self.instructions), operands, argument, index, value))
        return len(self.instructions) - 1


def translate(function: Any) -> Program:
    """A CasADi SX function with dense column arguments as a program.

    Known are + - * / negation, squares, sqrt, sin, cos, exp, fmin, fmax, fabs, sign, <, <= and if_else.

    Raises:
        HotlapError: names an operation that is not known.
    """
    import casadi as ca  # noqa: PLC0415 - only when something is compiled

    names = {getattr(ca, name): name for name in dir(ca) if name.startswith("OP_")}
    out = _Translator()
    for k in range(function.n_instructions()):
        name = names[function.instruction_id(k)]
        source, target = function.instruction_input(k), function.instruction_output(k)
        if name == "OP_OUTPUT":
            out.add("store", out.slot[source[0]], argument=function.n_in() + target[0], index=target[1])
        elif name == "OP_INPUT":
            out.slot[target[0]] = out.add("load", argument=source[0], index=source[1])
        elif name == "OP_CONST":
            out.slot[target[0]] = out.add("constant", value=function.instruction_constant(k))
        else:
            out.slot[target[0]] = _translate_operation(out, name, [out.slot[slot] for slot in source], function.name())
    return Program(tuple(out.instructions))


def _translate_operation(out: _Translator, name: str, x: list[int], function: str) -> int:
    """One operation of CasADi, in ours."""
    if name in _PLAIN:
        return out.add(_PLAIN[name], *x)
    if name == "OP_ASSIGN":
        return x[0]
    if name == "OP_SQ":
        return out.add("multiply", x[0], x[0])
    if name == "OP_TWICE":
        return out.add("add", x[0], x[0])
    if name == "OP_INV":
        return out.add("divide", out.add("constant", value=1.0), x[0])
    if name == "OP_FABS":
        return out.add("maximum", x[0], out.add("negate", x[0]))
    if name == "OP_SIGN":
        zero, one, minus = (out.add("constant", value=value) for value in (0.0, 1.0, -1.0))
        below = out.add("select", out.add("less", x[0], zero), minus, zero)
        return out.add("select", out.add("less", zero, x[0]), one, below)
    if name in ("OP_LT", "OP_LE"):
        condition = out.add("less" if name == "OP_LT" else "less_equal", *x)
        return out.add("select", condition, out.add("constant", value=1.0), out.add("constant", value=0.0))
    if name == "OP_NOT":
        return out.add("select", out.add("not_zero", x[0]), out.add("constant", value=0.0), out.add("constant", value=1.0))
    if name == "OP_IF_ELSE_ZERO":
        return out.add("select", out.add("not_zero", x[0]), x[1], out.add("constant", value=0.0))
    raise HotlapError(f"{function}: the flight core's compiler does not know the operation {name[3:].lower()}")
