"""Lending: named tuples of many arrays that compiled functions hand on as one pointer.

Numba passes a named tuple field by field, and an array as five numbers and more: a function with two tuples of twenty arrays takes
hundreds of arguments, and copies all of them wherever it is inlined or reads one field. Compiling that took longer than anything else.
"""

# pyright: reportAttributeAccessIssue=false
# Numba sets its configuration at run time.

from __future__ import annotations

import hashlib
from typing import Any

from llvmlite import ir
from numba import config, types
from numba.core import cgutils
from numba.core.imputils import lower_getattr_generic
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, intrinsic, models, register_model

from hotlap.flight.lanes import without_owners


class Lent(types.Type):
    """A pointer to a named tuple, whose fields are read as those of the tuple."""

    def __init__(self, held: Any) -> None:
        self.held = held
        super().__init__(f"Lent({held.instance_class.__name__}, {hashlib.sha256(str(held).encode()).hexdigest()[:8]})")

    def field(self, name: str) -> tuple[int, Any]:
        """Index of a field, and its type: tuples within are lent too."""
        index = self.held.fields.index(name)
        kind = self.held.types[index]
        return index, Lent(kind) if isinstance(kind, types.BaseNamedTuple) else kind


@register_model(Lent)
class LentModel(models.PrimitiveModel):
    """The address of the tuple."""

    def __init__(self, manager: Any, kind: Lent) -> None:
        super().__init__(manager, kind, manager.lookup(kind.held).get_value_type().as_pointer())


@infer_getattr
class _LentFields(AttributeTemplate):
    key = Lent

    def generic_resolve(self, lent: Lent, name: str) -> Any:
        """The type of a field."""
        return lent.field(name)[1] if name in lent.held.fields else None


@lower_getattr_generic(Lent)
def _read_field(context: Any, builder: Any, lent: Lent, value: Any, name: str) -> Any:
    """Load one field; arrays know no owner."""
    index, kind = lent.field(name)
    place = cgutils.gep_inbounds(builder, value, 0, index)
    return place if isinstance(kind, Lent) else without_owners(context, builder, kind, builder.load(place))


@intrinsic
def _lend(typing: Any, memory: Any) -> Any:
    """The tuples are put into the frame of the function that calls this; so it cannot be an overload, which has a frame of its own."""
    kinds = [Lent(kind) if isinstance(kind, types.BaseNamedTuple) else kind for kind in memory.types]
    result = types.NamedTuple(kinds, memory.instance_class)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> ir.Value:
        parts = zip(memory.types, cgutils.unpack_tuple(builder, arguments[0], len(kinds)), strict=True)
        lent = [
            cgutils.alloca_once_value(builder, part)
            if isinstance(kind, types.BaseNamedTuple)
            else without_owners(context, builder, kind, part)
            for kind, part in parts
        ]
        return context.make_tuple(builder, result, lent)

    return result(memory), generate


def _hand_on(memory: Any) -> Any:
    return memory


lend: Any = _hand_on if config.DISABLE_JIT else _lend
"""A named tuple whose arrays know no owner, and whose named tuples are pointers; valid until the function that calls this returns."""
