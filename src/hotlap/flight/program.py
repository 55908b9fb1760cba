"""Program: straight-line arithmetic as a list of instructions; `Tape` records one from plain Python arithmetic.

CasADi rewrites products and divisions in ways that cost the backward pass of the solver dearly, and loads all its inputs
first; a tape keeps the order in which it was written, loads numbers where they are used, and `section()` puts
everything that is still needed back into memory, so that the compiler does not juggle hundreds of registers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np


class Instruction(NamedTuple):
    """One step: `result = operation(*operands)`; memory is addressed by argument and index."""

    operation: str
    result: int
    operands: tuple[int, ...] = ()
    argument: int = -1
    index: int = -1  # pyright: ignore[reportIncompatibleMethodOverride]  nobody searches a step
    value: float = 0.0


@dataclass(frozen=True)
class Program:
    """Instructions over 1-d arrays of numbers: first the inputs, then the outputs."""

    instructions: tuple[Instruction, ...]

    def count(self) -> int:
        """Arithmetic operations: everything but loads, stores, constants and section ends."""
        return sum(i.operation not in ("load", "store", "constant", "section") for i in self.instructions)


MEANING: dict[str, Callable[..., Any]] = {
    "add": lambda a, b: a + b,
    "subtract": lambda a, b: a - b,
    "multiply": lambda a, b: a * b,
    "divide": lambda a, b: a / b,
    "negate": lambda a: -a,
    "minimum": min,  # the first, unless the second is smaller: a NaN stays a NaN
    "maximum": max,
    "less": lambda a, b: a < b,
    "less_equal": lambda a, b: a <= b,
    "not_zero": lambda a: a != 0,
    "and": lambda a, b: a and b,
    "or": lambda a, b: a or b,
    "select": lambda condition, a, b: a if condition else b,
    "sqrt": math.sqrt,
    "sin": math.sin,
    "cos": math.cos,
    "exp": math.exp,
}


def run(program: Program, arrays: Sequence[np.ndarray]) -> None:
    """Interpret a program on arrays of floats: what the compiled code does, for debuggers and tests."""
    values: dict[int, Any] = {}
    for operation, result, operands, argument, index, value in program.instructions:
        if operation == "load":
            values[result] = float(arrays[argument][index])
        elif operation == "store":
            arrays[argument][index] = values[operands[0]]
        elif operation == "constant":
            values[result] = value
        elif operation != "section":
            values[result] = MEANING[operation](*(values[operand] for operand in operands))


class Tape:
    """Records arithmetic on `Number`s; equal operations are recorded once."""

    def __init__(self) -> None:
        self.instructions: list[Instruction] = []
        self._known: dict[tuple, int] = {}
        self._sections = 0

    def record(self, operation: str, *operands: int, argument: int = -1, index: int = -1, value: float = 0.0) -> int:
        """Append an instruction unless the same one is known; returns its result."""
        key = (operation, operands, argument, index, value, self._sections if operation == "load" else 0)
        if key not in self._known:
            self._known[key] = len(self.instructions)
            self.instructions.append(Instruction(operation, len(self.instructions), operands, argument, index, value))
        return self._known[key]

    def array(self, argument: int, size: int, start: int = 0) -> list[Number]:
        """Numbers in memory: loaded where they are used, once a section."""
        return [Number(self, argument=argument, index=start + i) for i in range(size)]

    def store(self, argument: int, values: Sequence[Number | float], start: int = 0) -> list[Number]:
        """Write values to an argument; gives back the numbers in memory."""
        for i, value in enumerate(values):
            source = self.lift(value).result  # may append
            self.instructions.append(Instruction("store", len(self.instructions), (source,), argument, start + i))
        return self.array(argument, len(values), start)

    def section(self) -> None:
        """End a section: later uses of numbers in memory load them again."""
        self._sections += 1
        self.instructions.append(Instruction("section", len(self.instructions)))

    def lift(self, value: Number | float) -> Number:
        """A Python number becomes a constant."""
        return value if isinstance(value, Number) else Number(self, self.record("constant", value=float(value)))

    @property
    def program(self) -> Program:
        """What was recorded."""
        return Program(tuple(self.instructions))


class Number:
    """A value on a tape: the result of an instruction, or a place in memory."""

    def __init__(self, tape: Tape, result: int = -1, argument: int = -1, index: int = -1) -> None:
        self.tape, self._result, self._argument, self._index = tape, result, argument, index

    @property
    def result(self) -> int:
        """The instruction that makes this value; loads it where it lies in memory."""
        if self._argument < 0:
            return self._result
        return self.tape.record("load", argument=self._argument, index=self._index)

    def _apply(self, operation: str, *others: Number | float) -> Number:
        operands = [self.result, *(self.tape.lift(other).result for other in others)]
        return Number(self.tape, self.tape.record(operation, *operands))

    def __add__(self, other: Number | float) -> Number:
        return self._apply("add", other)

    def __radd__(self, other: float) -> Number:
        return self if other == 0 else self._apply("add", other)

    def __sub__(self, other: Number | float) -> Number:
        return self._apply("subtract", other)

    def __rsub__(self, other: float) -> Number:
        return self.tape.lift(other) - self

    def __mul__(self, other: Number | float) -> Number:
        return self._apply("multiply", other)

    __rmul__ = __mul__

    def __truediv__(self, other: Number | float) -> Number:
        return self._apply("divide", other)

    def __rtruediv__(self, other: float) -> Number:
        return self.tape.lift(other) / self

    def __neg__(self) -> Number:
        return self._apply("negate")

    def __lt__(self, other: Number | float) -> Number:
        return self._apply("less", other)

    def __le__(self, other: Number | float) -> Number:
        return self._apply("less_equal", other)

    def __gt__(self, other: Number | float) -> Number:
        return self.tape.lift(other) < self

    def __ge__(self, other: Number | float) -> Number:
        return self.tape.lift(other) <= self

    def __and__(self, other: Number) -> Number:
        return self._apply("and", other)

    def __or__(self, other: Number) -> Number:
        return self._apply("or", other)

    def where(self, a: Number | float, b: Number | float) -> Number:
        """Value a where this condition holds, else b."""
        return self._apply("select", a, b)

    def minimum(self, other: Number | float) -> Number:
        """The smaller of two."""
        return self._apply("minimum", other)

    def maximum(self, other: Number | float) -> Number:
        """The larger of two."""
        return self._apply("maximum", other)

    def square_root(self) -> Number:
        """Its square root."""
        return self._apply("sqrt")


def dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """Sum of products, from left to right."""
    total = a[0] * b[0]
    for x, y in zip(a[1:], b[1:], strict=True):
        total = total + x * y
    return total
