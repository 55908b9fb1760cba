"""Numbers: code that is written for them computes one flight (float64), or one flight in each SIMD lane.

`Lanes(element, width)` is an LLVM vector that behaves like a float inside compiled code, so nothing depends on
the auto-vectoriser. Every function here also has a plain Python body: with NUMBA_DISABLE_JIT=1 the same code runs
in the interpreter on floats. This file, `lending.py` and `compile.py` are all that touches Numba's extension interface.
"""

# pyright: reportCallIssue=false, reportAttributeAccessIssue=false
# Numba's decorators change what they decorate.

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, models, overload, register_model
from numba.np.arrayobj import make_array, populate_array

FAST_MATH = ("contract", "reassoc", "nsz", "arcp", "afn")  # never "nnan": a crashed flight may hold NaN
PLAIN_MATH = ("contract", "nsz", "arcp", "afn")  # keeps the order that the tracer chose

implement = partial(overload, strict=False)  # Numba takes annotations that one side lacks for another signature


class Lanes(types.Type):
    """`width` floats of one kind, one for each flight."""

    def __init__(self, element: types.Float, width: int) -> None:
        self.element, self.width = element, width
        super().__init__(f"Lanes({element}x{width})")


class Mask(types.Type):
    """`width` truth values."""

    def __init__(self, width: int) -> None:
        self.width = width
        super().__init__(f"Mask({width})")


@register_model(Lanes)
class LanesModel(models.PrimitiveModel):
    """An LLVM vector of floats."""

    def __init__(self, manager: Any, kind: Lanes) -> None:
        element = ir.FloatType() if kind.element == types.float32 else ir.DoubleType()
        super().__init__(manager, kind, ir.VectorType(element, kind.width))


@register_model(Mask)
class MaskModel(models.PrimitiveModel):
    """An LLVM vector of bits."""

    def __init__(self, manager: Any, kind: Mask) -> None:
        super().__init__(manager, kind, ir.VectorType(ir.IntType(1), kind.width))


def _spread(context: Any, builder: Any, value: Any, kind: Any, lanes: Lanes) -> Any:
    """The same number in every lane."""
    if isinstance(kind, Lanes):
        return value
    undefined = ir.Constant(context.get_value_type(lanes), ir.Undefined)
    first = builder.insert_element(undefined, context.cast(builder, value, kind, lanes.element), ir.Constant(ir.IntType(32), 0))
    return builder.shuffle_vector(first, first, ir.Constant(ir.VectorType(ir.IntType(32), lanes.width), [0] * lanes.width))


def _operation(emit: Callable, mask: bool = False) -> Any:
    """An intrinsic on numbers of which at least one is `Lanes`."""

    @intrinsic
    def operation(typing: Any, a: Any, b: Any) -> Any:
        lanes = a if isinstance(a, Lanes) else b

        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return emit(builder, *(_spread(context, builder, v, t, lanes) for v, t in zip(arguments, signature.args, strict=True)))

        return (Mask(lanes.width) if mask else lanes)(a, b), generate

    return operation


def _register(function: Any, operation: Any) -> None:
    """Make a Python operator or function use an intrinsic where lanes are concerned."""

    @implement(function)
    def typed(a: Any, b: Any) -> Any:
        if isinstance(a, Lanes) or isinstance(b, Lanes):
            return lambda a, b: operation(a, b)
        return None


for _name, _operators in {
    "fadd": (operator.add, operator.iadd),
    "fsub": (operator.sub, operator.isub),
    "fmul": (operator.mul, operator.imul),
    "fdiv": (operator.truediv, operator.itruediv),
}.items():
    _arithmetic = _operation(lambda builder, x, y, name=_name: getattr(builder, name)(x, y, flags=FAST_MATH))
    for _operator in _operators:
        _register(_operator, _arithmetic)
for _operator, _sign in ((operator.lt, "<"), (operator.le, "<="), (operator.gt, ">"), (operator.ge, ">=")):
    _register(_operator, _operation(lambda builder, x, y, sign=_sign: builder.fcmp_ordered(sign, x, y), mask=True))


@intrinsic
def _negate(typing: Any, a: Any) -> Any:
    return a(a), lambda _, builder, __, arguments: builder.fneg(arguments[0], flags=FAST_MATH)


@implement(operator.neg)
def _typed_negate(a: Any) -> Any:
    return (lambda a: _negate(a)) if isinstance(a, Lanes) else None


def math_intrinsic(builder: Any, name: str, value: Any) -> Any:
    """LLVM's llvm.sqrt, llvm.sin, ... of a float or a vector of floats."""
    vector = isinstance(value.type, ir.VectorType)
    element = value.type.element if vector else value.type
    suffix = (f"v{value.type.count}" if vector else "") + ("f32" if isinstance(element, ir.FloatType) else "f64")
    kind = ir.FunctionType(value.type, [value.type])
    return builder.call(cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.{suffix}"), [value])


@intrinsic
def _square_root(typing: Any, a: Any) -> Any:
    return a(a), lambda _, builder, __, arguments: math_intrinsic(builder, "sqrt", arguments[0])


@intrinsic
def _select(typing: Any, mask: Any, a: Any, b: Any) -> Any:
    lanes = a if isinstance(a, Lanes) else b

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        values = (_spread(context, builder, v, t, lanes) for v, t in zip(arguments[1:], signature.args[1:], strict=True))
        return builder.select(arguments[0], *values)

    return lanes(mask, a, b), generate


@intrinsic
def _constant(typing: Any, like: Any, value: Any) -> Any:
    return like(like, value), lambda context, builder, signature, arguments: _spread(
        context, builder, arguments[1], signature.args[1], signature.args[0]
    )


@intrinsic
def _all(typing: Any, mask: Any) -> Any:
    def generate(_: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        bits = builder.bitcast(arguments[0], ir.IntType(signature.args[0].width))
        return builder.icmp_unsigned("==", bits, ir.Constant(bits.type, -1))

    return types.boolean(mask), generate


def number(like: Any, value: float) -> Any:
    """A constant of the same kind as `like`."""
    return float(value)


def select(condition: Any, a: Any, b: Any) -> Any:
    """Value a where the condition holds, else b."""
    return a if condition else b


def square_root(a: Any) -> Any:
    """Square root."""
    return math.sqrt(a)


def every(condition: Any) -> bool:
    """Whether the condition holds in every lane."""
    return bool(condition)


@implement(number)
def _typed_number(like: Any, value: Any) -> Any:
    return (lambda like, value: _constant(like, value)) if isinstance(like, Lanes) else (lambda like, value: float(value))


@implement(select)
def _typed_select(condition: Any, a: Any, b: Any) -> Any:
    if isinstance(condition, Mask):
        return lambda condition, a, b: _select(condition, a, b)
    return lambda condition, a, b: a if condition else b


@implement(square_root)
def _typed_square_root(a: Any) -> Any:
    return (lambda a: _square_root(a)) if isinstance(a, Lanes) else (lambda a: math.sqrt(a))


@implement(every)
def _typed_every(condition: Any) -> Any:
    return (lambda condition: _all(condition)) if isinstance(condition, Mask) else (lambda condition: condition)


def as_numbers(memory: Any, width: int) -> Any:
    """Memory seen as numbers: a C-contiguous array of shape (..., max(width, 1)) as one of shape (...), or a named tuple of such."""
    if isinstance(memory, tuple):
        return type(memory)(*[as_numbers(array, width) for array in memory])
    return memory.reshape(memory.shape[:-1])


def _viewed(array: Any, width: int) -> Any:
    """The type of an array seen as numbers."""
    return types.Array(Lanes(array.dtype, width) if width else array.dtype, array.ndim - 1, "C", aligned=False)


def _view(context: Any, builder: Any, array: Any, value: Any, kind: Any) -> Any:
    """An array's value seen as numbers: the same data, one dimension less."""
    source = make_array(array)(context, builder, value)
    element, index = context.get_value_type(kind.dtype), context.get_value_type(types.intp)
    shape = cgutils.unpack_tuple(builder, source.shape, array.ndim)[:-1]
    size = ir.Constant(index, context.get_abi_sizeof(element))
    strides = [size]
    for length in reversed(shape[1:]):
        strides.insert(0, builder.mul(strides[0], length))
    view = make_array(kind)(context, builder)
    populate_array(
        view,
        data=builder.bitcast(source.data, element.as_pointer()),
        shape=cgutils.pack_array(builder, shape),
        strides=cgutils.pack_array(builder, strides),
        itemsize=size,
        meminfo=None,
        parent=None,
    )
    return view._getvalue()  # noqa: SLF001 - how Numba's own intrinsics return an array


@intrinsic(prefer_literal=True)
def _as_numbers(typing: Any, memory: Any, width: Any) -> Any:
    arrays = memory.types if isinstance(memory, types.BaseNamedTuple) else (memory,)
    kinds = [_viewed(array, width.literal_value) for array in arrays]
    result = types.NamedTuple(kinds, memory.instance_class) if isinstance(memory, types.BaseNamedTuple) else kinds[0]

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        if not isinstance(memory, types.BaseNamedTuple):
            return _view(context, builder, memory, arguments[0], result)
        values = cgutils.unpack_tuple(builder, arguments[0], len(kinds))
        views = [_view(context, builder, *each) for each in zip(arrays, values, kinds, strict=True)]
        return context.make_tuple(builder, result, views)

    return result(memory, width), generate


@implement(as_numbers, prefer_literal=True)
def _typed_as_numbers(memory: Any, width: Any) -> Any:
    return lambda memory, width: _as_numbers(memory, width)


def borrow(memory: Any) -> Any:
    """A named tuple of arrays to which compiled code counts no references; the caller must keep the arrays.

    Counting is atomic, and happens at every access of an array in a tuple: it would cost more than the arithmetic.
    """
    return memory


@intrinsic
def _borrow(typing: Any, memory: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return without_owners(context, builder, memory, arguments[0])

    return memory(memory), generate


def without_owners(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    """A value whose arrays, those of tuples in it too, know no owner."""
    if isinstance(kind, types.Array):
        array = make_array(kind)(context, builder, value)
        array.meminfo = ir.Constant(array.meminfo.type, None)
        array.parent = ir.Constant(array.parent.type, None)
        return array._getvalue()  # noqa: SLF001
    if isinstance(kind, types.BaseTuple):
        parts = zip(kind.types, cgutils.unpack_tuple(builder, value, len(kind.types)), strict=True)
        return context.make_tuple(builder, kind, [without_owners(context, builder, *part) for part in parts])
    return value


@implement(borrow)
def _typed_borrow(memory: Any) -> Any:
    return lambda memory: _borrow(memory)


def fetch_and_add(counter: np.ndarray) -> int:
    """Add one to counter[0] and return its old value; atomic, so that threads never get the same one."""
    counter[0] += 1
    return counter[0] - 1


@intrinsic
def _fetch_and_add(typing: Any, counter: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = make_array(signature.args[0])(context, builder, arguments[0]).data
        return builder.atomic_rmw("add", data, ir.Constant(ir.IntType(64), 1), "monotonic")

    return types.int64(counter), generate


@implement(fetch_and_add)
def _typed_fetch_and_add(counter: Any) -> Any:
    return lambda counter: _fetch_and_add(counter)
