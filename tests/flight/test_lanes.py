"""Numbers behave like floats, one in every lane."""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from threading import Barrier
from typing import Any, NamedTuple

import numpy as np
import pytest
from numba import njit
from numpy.testing import assert_allclose, assert_array_equal

from hotlap.flight.lanes import as_numbers, borrow, every, fetch_and_add, number, select, square_root
from hotlap.flight.numbers import COMPILE, Numbers

from .kept import kept

INPUTS = 3  # two of any sign, one positive

EXPECTED = {
    "a + b": lambda a, b, c: a + b,
    "a - b": lambda a, b, c: a - b,
    "a * b": lambda a, b, c: a * b,
    "a / c": lambda a, b, c: a / c,
    "-a": lambda a, b, c: -a,
    "a + 2": lambda a, b, c: a + 2.5,
    "2 - a": lambda a, b, c: 2.5 - a,
    "3 * a, whole": lambda a, b, c: 3 * a,
    "1 / c": lambda a, b, c: 1.0 / c,
    "root": lambda a, b, c: np.sqrt(c),
    "constant": lambda a, b, c: np.full_like(a, 0.1),
    "in place": lambda a, b, c: ((a + b) * c - 1.0) / 2.0,
    "a < b": lambda a, b, c: np.where(a < b, a, b),
    "a <= 0": lambda a, b, c: np.where(a <= 0, 1.0, c),
    "a > b": lambda a, b, c: np.where(a > b, a, -1.0),
    "a < b, strictly": lambda a, b, c: np.where(a < b, a, -1.0),
    "a >= b": lambda a, b, c: np.where(a >= b, a, -1.0),
    "0 >= a": lambda a, b, c: np.where(a <= 0, c, b),
}
CONDITIONS = {
    "all": lambda a, b, c: (c > 0).all(),
    "some": lambda a, b, c: (a > 0).all(),
    "none": lambda a, b, c: (c < 0).all(),
}


def work(x: Any, out: Any, flags: Any) -> None:
    """Everything of `EXPECTED`, and of `CONDITIONS`, in that order; `x` and `out` are arrays of numbers."""
    a, b, c = x[0], x[1], x[2]
    out[0], out[1], out[2], out[3], out[4] = a + b, a - b, a * b, a / c, -a
    out[5], out[6], out[7], out[8] = a + 2.5, 2.5 - a, 3 * a, 1.0 / c
    out[9], out[10] = square_root(c), number(a, 0.1)
    out[11] = a
    out[11] += b
    out[11] *= c
    out[11] -= 1.0
    out[11] /= 2.0
    out[12], out[13] = select(a < b, a, b), select(a <= 0.0, 1.0, c)
    out[14], out[15] = select(a > b, a, -1.0), select(a < b, a, -1.0)
    out[16], out[17] = select(a >= b, a, -1.0), select(a <= 0.0, c, b)
    flags[0], flags[1], flags[2] = every(c > 0.0), every(a > 0.0), every(c < 0.0)


@cache
def compiled_work(numbers: Numbers) -> Any:
    inner, width = njit(**COMPILE)(work), numbers.width

    def call(x: np.ndarray, out: np.ndarray, flags: np.ndarray) -> None:
        inner(as_numbers(x, width), as_numbers(out, width), flags)

    return kept(call, numbers)


def draw(numbers: Numbers) -> np.ndarray:
    """Values that differ from lane to lane, of both signs."""
    rng = np.random.default_rng(numbers.lanes)
    x = np.vstack([rng.normal(size=(2, numbers.lanes)), rng.uniform(0.5, 2.0, (1, numbers.lanes))])
    x[0, 0] = -abs(x[0, 0])
    x[:2, -1] = abs(x[1, -1])  # two that are equal
    return x.astype(numbers.dtype)


def calculate(numbers: Numbers, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    out, flags = np.zeros((len(EXPECTED), numbers.lanes), numbers.dtype), np.zeros(len(CONDITIONS), dtype=np.bool_)
    compiled_work(numbers)(x, out, flags)
    return out, flags


@pytest.mark.parametrize("numbers", Numbers)
def test_numbers_calculate_as_numpy_does(numbers):
    x = draw(numbers)
    out, flags = calculate(numbers, x)
    expected = np.array([function(*x) for function in EXPECTED.values()])
    tolerance = 4 * np.finfo(numbers.dtype).eps
    assert_allclose(out, expected, rtol=tolerance, atol=tolerance)
    assert_array_equal(flags, [condition(*x) for condition in CONDITIONS.values()])


@pytest.mark.parametrize("numbers", Numbers)
def test_what_is_no_number_stays_in_its_lane(numbers):
    x = draw(numbers)
    clean, _ = calculate(numbers, x)
    x[0, -1] = np.nan
    out, flags = calculate(numbers, x)
    assert_array_equal(out[:, :-1], clean[:, :-1])
    with np.errstate(invalid="ignore"):
        assert_array_equal(np.isnan(out[:, -1]), [np.isnan(function(*x)[-1]) for function in EXPECTED.values()])
    assert_array_equal(flags, [True, False, False])


def test_the_same_code_runs_without_a_compiler():
    x, out, flags = draw(Numbers.FLOAT64), np.zeros((len(EXPECTED), 1)), np.zeros(len(CONDITIONS), dtype=np.bool_)
    work(as_numbers(x, 0), as_numbers(out, 0), flags)
    assert_allclose(out[:, 0], calculate(Numbers.FLOAT64, x)[0][:, 0], rtol=1e-15)


class Memory(NamedTuple):
    one: Any
    two: Any


@pytest.mark.parametrize("numbers", Numbers)
def test_memory_seen_as_numbers_is_the_same_memory(numbers):
    width = numbers.width

    def double_and_move(memory: Memory) -> int:
        m = as_numbers(memory, width)
        m.one[1] = m.one[0] * 2.0
        m.two[1, 2] = m.two[0, 1]
        return len(m.one) * 100 + m.two.shape[0] * 10 + m.two.shape[1]

    one = np.arange(2 * numbers.lanes, dtype=numbers.dtype).reshape(2, numbers.lanes)
    two = np.arange(6 * numbers.lanes, dtype=numbers.dtype).reshape(2, 3, numbers.lanes) + 0.5
    before = two.copy()
    assert kept(double_and_move, numbers)(Memory(one, two)) == 223
    assert_array_equal(one[1], 2 * np.arange(numbers.lanes))
    assert_array_equal(two[1, 2], before[0, 1])
    before[1, 2] = before[0, 1]
    assert_array_equal(two, before)


def test_memory_without_a_compiler_is_the_same_memory():
    memory = Memory(np.zeros((2, 1)), np.zeros((2, 3, 1)))
    seen = as_numbers(memory, 0)
    seen.two[1, 2] = 4.0
    assert memory.two[1, 2, 0] == 4.0
    assert (seen.one.shape, seen.two.shape) == ((2,), (2, 3))


def test_borrowed_memory_is_used_and_not_counted():
    @njit(**COMPILE)
    def fill(memory: Memory) -> Any:
        lent = borrow(memory)
        for i in range(len(lent.one)):
            lent.one[i] = lent.two[i] + 1.0
        return lent.one[-1]

    memory = Memory(np.zeros(5), np.arange(5.0))
    counts = sys.getrefcount(memory.one), sys.getrefcount(memory.two)
    for _ in range(10):
        assert fill(memory) == 5.0
    assert (sys.getrefcount(memory.one), sys.getrefcount(memory.two)) == counts
    assert_array_equal(memory.one, np.arange(1.0, 6.0))
    assert borrow(memory) is memory


def test_threads_never_get_the_same():
    rounds, counter, start = 5_000_000, np.zeros(1, dtype=np.int64), Barrier(2)

    @njit(nogil=True)
    def sum_of(counter: np.ndarray, latest: np.ndarray, rounds: int) -> int:
        total = 0
        for _ in range(rounds):
            latest[0] = fetch_and_add(counter)  # in memory, lest the loop is replaced by its result
            total += latest[0]
        return total

    def together(_: int) -> int:
        start.wait()
        return sum_of(counter, np.zeros(1, dtype=np.int64), rounds)

    assert sum_of(counter, np.zeros(1, dtype=np.int64), 0) == 0
    with ThreadPoolExecutor(2) as pool:
        totals = list(pool.map(together, range(2)))
    assert sum(totals) == rounds * (2 * rounds - 1)  # each number from 0 once
    assert fetch_and_add(counter) == 2 * rounds
