"""What is lent is read and written as the named tuple itself."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.testing import assert_array_equal

from hotlap.flight.lending import lend, lend_parts

from .kept import kept


class Inner(NamedTuple):
    numbers: Any
    scale: float


class Outer(NamedTuple):
    first: Any
    second: Any
    wanted: bool
    inner: Inner


@kept
def through_a_pointer(memory: Outer) -> Any:
    """Write through tuples that are lent, and give back what they hold."""
    lent, parts = lend(memory), lend_parts(memory)
    lent.first[0] = lent.inner.scale * lent.inner.numbers[1]
    parts.second[1, 0] = parts.inner.numbers[2] + len(parts.inner.numbers)
    return lent.wanted, parts.wanted


def test_fields_are_those_of_the_tuple():
    for wanted in (False, True):
        memory = Outer(np.zeros(2), np.zeros((2, 2)), wanted, Inner(np.array([1.0, 2.0, 4.0]), 3.0))
        assert through_a_pointer(memory) == (wanted, wanted)
        assert_array_equal(memory.first, [6.0, 0.0])
        assert_array_equal(memory.second, [[0.0, 0.0], [7.0, 0.0]])
